#include "mle/data/file_kind.h"

#include <zlib.h>

#include <utility>
#include <vector>

namespace mle {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr int kGzipOnly = 16;  // zlib: windowBits + 16 expects a gzip header

struct KnownKind {
  std::string_view start;
  std::string_view meaning;
};

constexpr KnownKind kKinds[] = {
    {"PAR1"sv,
     "a Parquet file; write it as CSV first (pandas: "
     "read_parquet(…).to_csv(…), DuckDB: COPY … TO 'x.csv')"sv},
    {"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1"sv,
     "an Excel workbook of the old kind (xls); save its sheet as CSV UTF-8"sv},
    {"%PDF"sv, "a PDF; export the records as CSV"sv},
    {"\x89HDF\r\n\x1A\n"sv, "an HDF5 file; write its table as CSV first"sv},
    {"SQLite format 3\0"sv,
     "an SQLite database; name it sqlite:FILE, with a table or a query"sv},
    {"BZh"sv, "compressed by bzip2; unpack it, or use gzip"sv},
    {"\xFD\x37zXZ\0"sv, "compressed by xz; unpack it, or use gzip"sv},
    {"\x28\xB5\x2F\xFD"sv, "compressed by zstd; unpack it, or use gzip"sv},
    {"7z\xBC\xAF\x27\x1C"sv, "a 7z archive; unpack it"sv},
};

class GunzipBuffer : public std::streambuf {
 public:
  // `owner` turns bad() where the file is damaged.
  GunzipBuffer(std::unique_ptr<std::istream> in, std::ios& owner)
      : in_(std::move(in)), owner_(owner), packed_(kBlock), text_(kBlock) {
    is_open_ = inflateInit2(&stream_, kGzipOnly + MAX_WBITS) == Z_OK;
  }
  ~GunzipBuffer() override {
    if (is_open_) inflateEnd(&stream_);
  }
  GunzipBuffer(const GunzipBuffer&) = delete;
  GunzipBuffer& operator=(const GunzipBuffer&) = delete;

 protected:
  int_type underflow() override {
    if (gptr() < egptr()) return traits_type::to_int_type(*gptr());
    const std::size_t size = Unpack();
    setg(text_.data(), text_.data(), text_.data() + size);
    return size > 0 ? traits_type::to_int_type(text_[0]) : traits_type::eof();
  }

 private:
  // The next block of the text; 0 at the end.
  std::size_t Unpack();
  bool FillPacked();
  // Nothing but zeros is left, which tapes and blocks of disks end with.
  bool OnlyZerosFollow();

  std::unique_ptr<std::istream> in_;
  std::ios& owner_;
  std::vector<char> packed_;
  std::vector<char> text_;
  z_stream stream_ = {};
  bool is_open_ = false;
  bool is_between_ = false;  // the parts of a file
};

bool GunzipBuffer::FillPacked() {
  if (stream_.avail_in > 0) return true;
  in_->read(packed_.data(), static_cast<std::streamsize>(packed_.size()));
  stream_.next_in = reinterpret_cast<Bytef*>(packed_.data());
  stream_.avail_in = static_cast<uInt>(in_->gcount());
  return stream_.avail_in > 0;
}

bool GunzipBuffer::OnlyZerosFollow() {
  while (FillPacked()) {
    if (*stream_.next_in != 0) return false;
    ++stream_.next_in;
    --stream_.avail_in;
  }
  return true;
}

std::size_t GunzipBuffer::Unpack() {
  stream_.next_out = reinterpret_cast<Bytef*>(text_.data());
  stream_.avail_out = static_cast<uInt>(text_.size());
  while (stream_.avail_out == text_.size()) {
    int code = Z_OK;
    if (is_between_ && OnlyZerosFollow()) return 0;
    if (!FillPacked()) {
      code = Z_BUF_ERROR;  // the file ends too early
    } else if (is_between_) {
      code = inflateReset(&stream_);
    }
    if (code == Z_OK) code = is_open_ ? inflate(&stream_, 0) : Z_MEM_ERROR;
    is_between_ = code == Z_STREAM_END;
    if (code != Z_OK && code != Z_STREAM_END) {
      owner_.setstate(std::ios::badbit);
      return 0;
    }
  }
  return text_.size() - stream_.avail_out;
}

class GunzipStream : public std::istream {
 public:
  explicit GunzipStream(std::unique_ptr<std::istream> packed)
      : std::istream(nullptr), buffer_(std::move(packed), *this) {
    rdbuf(&buffer_);
  }

 private:
  GunzipBuffer buffer_;
};

}  // namespace

std::string_view NotText(std::string_view start) {
  for (const KnownKind& kind : kKinds) {
    if (start.starts_with(kind.start)) return kind.meaning;
  }
  if (IsGzip(start)) return "compressed by gzip; unpack it";
  if (start.starts_with("PK\x03\x04")) {
    const bool is_workbook =
        start.find("[Content_Types].xml") != std::string_view::npos ||
        start.find("xl/") != std::string_view::npos;
    return is_workbook ? "an Excel workbook (xlsx); save its sheet as CSV UTF-8"
                       : "a ZIP archive; unpack it";
  }
  if (start.starts_with("<!DOCTYPE") || start.starts_with("<html") ||
      start.starts_with("<?xml")) {
    return "a page of HTML or XML, not a table as text; export CSV";
  }
  // A tag in braces is not an object.
  const std::size_t next = start.find_first_not_of(" \t\r\n", 1);
  if (start.starts_with('{') && next != std::string_view::npos &&
      start[next] == '"') {
    return "JSON, not a table as text; export the records as CSV";
  }
  return {};
}

bool IsGzip(std::string_view start) {
  return start.starts_with("\x1F\x8B\x08");
}

std::unique_ptr<std::istream> Gunzip(std::unique_ptr<std::istream> compressed) {
  return std::make_unique<GunzipStream>(std::move(compressed));
}

}  // namespace mle
