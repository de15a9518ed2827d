#include "apps/correct/data_sources.h"

#include <cstddef>
#include <istream>
#include <streambuf>
#include <string_view>
#include <utility>

#include "apps/common/sha256.h"
#include "apps/correct/checksum.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"

namespace mle::correct {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16;

// Hashes what is read through it, into `file` at its end.
class HashingBuffer : public std::streambuf {
 public:
  // `owner` turns bad() with `in`.
  HashingBuffer(std::unique_ptr<std::istream> in,
                std::shared_ptr<DataFile> file, std::ios& owner)
      : in_(std::move(in)),
        file_(std::move(file)),
        owner_(owner),
        text_(kBlock) {}

 protected:
  int_type underflow() override {
    if (gptr() < egptr()) return traits_type::to_int_type(*gptr());
    in_->read(text_.data(), static_cast<std::streamsize>(text_.size()));
    const auto size = static_cast<std::size_t>(in_->gcount());
    if (in_->bad()) owner_.setstate(std::ios::badbit);
    if (size == 0) {
      if (!in_->bad() && !has_ended_) {
        file_->sha256 = hash_.HexDigest();
        file_->bytes = bytes_;
        has_ended_ = true;
      }
      return traits_type::eof();
    }
    hash_.Add(std::string_view(text_.data(), size));
    bytes_ += static_cast<std::int64_t>(size);
    setg(text_.data(), text_.data(), text_.data() + size);
    return traits_type::to_int_type(text_[0]);
  }

 private:
  std::unique_ptr<std::istream> in_;
  std::shared_ptr<DataFile> file_;
  std::ios& owner_;
  std::vector<char> text_;
  Sha256 hash_;
  std::int64_t bytes_ = 0;
  bool has_ended_ = false;
};

class HashingStream : public std::istream {
 public:
  HashingStream(std::unique_ptr<std::istream> hashed,
                std::shared_ptr<DataFile> file)
      : std::istream(nullptr),
        buffer_(std::move(hashed), std::move(file), *this) {
    rdbuf(&buffer_);
  }

 private:
  HashingBuffer buffer_;
};

HistorianSource Hashed(HistorianSource source,
                       const std::shared_ptr<DataFile>& file) {
  source.open = [open = std::move(source.open),
                 file]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
    MLE_ASSIGN_OR_RETURN(std::unique_ptr<std::istream> in, open());
    return std::make_unique<HashingStream>(std::move(in), file);
  };
  return source;
}

}  // namespace

absl::StatusOr<DataSources> DataSources::Create(
    const std::vector<std::string>& names, const DatabaseOptions& database,
    const HistorianOptions& import) {
  DataSources data;
  MLE_ASSIGN_OR_RETURN(data.sources_, RecordSources(names, database, import));
  for (std::size_t s = 0; s < names.size(); ++s) {
    HistorianSource& source = data.sources_[s];
    auto file = std::make_shared<DataFile>();
    file->path = source.is_table ? source.name : names[s];
    if (source.is_table) {
      source = Hashed(std::move(source), file);
    } else {
      MLE_ASSIGN_OR_RETURN(FileChecksum checksum, ChecksumOf(names[s]));
      file->sha256 = std::move(checksum.sha256);
      file->bytes = checksum.bytes;
    }
    data.files_.push_back(std::move(file));
  }
  return data;
}

std::vector<DataFile> DataSources::Files() const {
  std::vector<DataFile> files;
  for (const std::shared_ptr<DataFile>& file : files_) files.push_back(*file);
  return files;
}

}  // namespace mle::correct
