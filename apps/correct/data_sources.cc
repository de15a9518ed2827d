#include "apps/correct/data_sources.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/common/sha256.h"
#include "mle/base/absl_view.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/data/row_source.h"
#include "mle/database/record_sources.h"

namespace mle::correct {
namespace {

// A row as CSV; names are quoted whatever they are.
std::string AsCsv(const std::vector<std::string_view>& fields, bool is_header) {
  std::string text;
  for (const std::string_view field : fields) {
    if (!text.empty()) text += ',';
    if (is_header) {
      absl::StrAppend(&text, "\"",
                      absl::StrReplaceAll(AbslView(field), {{"\"", "\"\""}}),
                      "\"");
    } else {
      text += QuoteCsvField(field);
    }
  }
  // An empty line would be no row.
  return text.empty() ? "\"\"\n" : text + '\n';
}

// Hashes the rows that are read through it, into `file` at their end.
class HashingRows : public RowSource {
 public:
  HashingRows(std::unique_ptr<RowSource> rows, std::shared_ptr<DataFile> file)
      : RowSource(rows->source(), rows->is_table()),
        rows_(std::move(rows)),
        file_(std::move(file)) {}

  bool Next(std::vector<std::string_view>& fields) override {
    const bool has_row = rows_->Next(fields);
    status_ = rows_->status();
    row_line_ = rows_->line();
    if (has_row) {
      const std::string text = AsCsv(fields, row_line_ == 1);
      hash_.Add(text);
      bytes_ += static_cast<std::int64_t>(text.size());
    } else if (status_.ok() && !has_ended_) {
      file_->sha256 = hash_.HexDigest();
      file_->bytes = bytes_;
      has_ended_ = true;
    }
    return has_row;
  }
  std::unique_ptr<RowSource> Preview() override { return rows_->Preview(); }

 private:
  std::unique_ptr<RowSource> rows_;
  std::shared_ptr<DataFile> file_;
  Sha256 hash_;
  std::int64_t bytes_ = 0;
  bool has_ended_ = false;
};

HistorianSource Hashed(HistorianSource source,
                       const std::shared_ptr<DataFile>& file) {
  source.open_rows = [open = std::move(source.open_rows),
                      file]() -> absl::StatusOr<std::unique_ptr<RowSource>> {
    MLE_ASSIGN_OR_RETURN(std::unique_ptr<RowSource> rows, open());
    return std::make_unique<HashingRows>(std::move(rows), file);
  };
  return source;
}

}  // namespace

absl::StatusOr<DataFile> ReadDataFile(const std::string& path) {
  if (path == "-") {
    return DataFile{path, Sha256Of(StandardInput()),
                    static_cast<std::int64_t>(StandardInput().size())};
  }
  MLE_RETURN_IF_ERROR(CheckRegularFile(path));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      std::fopen(path.c_str(), "rb"), &std::fclose);
  if (file == nullptr) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot open '", path, "'"));
  }
  Sha256 hash;
  DataFile result{.path = path};
  std::array<char, 1 << 16> block;
  while (true) {
    const std::size_t size =
        std::fread(block.data(), 1, block.size(), file.get());
    if (size == 0) break;
    result.bytes += static_cast<std::int64_t>(size);
    hash.Add(std::string_view(block.data(), size));
  }
  if (std::ferror(file.get()) != 0) {
    return absl::ErrnoToStatus(errno, absl::StrCat("cannot read '", path, "'"));
  }
  result.sha256 = hash.HexDigest();
  if (result.sha256.empty()) {
    return absl::InternalError(
        absl::StrCat("the checksum of '", path, "' could not be computed"));
  }
  return result;
}

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
      MLE_ASSIGN_OR_RETURN(*file, ReadDataFile(names[s]));
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
