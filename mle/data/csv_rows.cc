#include "mle/data/csv_rows.h"

#include <algorithm>
#include <cstring>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/file_kind.h"
#include "mle/data/import_options.h"

namespace mle {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::size_t kFirstBlock = std::size_t{1} << 18;
constexpr std::size_t kShownBytes = 60;

unsigned char Byte(char c) { return static_cast<unsigned char>(c); }

// Whether `second` may follow `lead` in a UTF-8 character: not in a longer form
// than needed, in a surrogate, or beyond U+10FFFF (Unicode 15.0, table 3-7).
bool MayFollow(unsigned char lead, unsigned char second) {
  if (lead == 0xE0) return second >= 0xA0;
  if (lead == 0xED) return second < 0xA0;
  if (lead == 0xF0) return second >= 0x90;
  if (lead == 0xF4) return second < 0x90;
  return true;
}

// Bytes of the UTF-8 character at the front of `text`; 0 if there is none.
std::size_t CharacterLength(std::string_view text) {
  const unsigned char lead = Byte(text[0]);
  const std::size_t length = lead < 0x80                   ? 1
                             : lead >= 0xC2 && lead < 0xE0 ? 2
                             : lead >= 0xE0 && lead < 0xF0 ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  if (length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((Byte(text[i]) & 0xC0) != 0x80) return 0;
  }
  if (length > 1 && !MayFollow(lead, Byte(text[1]))) return 0;
  return length;
}

constexpr std::size_t kLongestError = 8;

// Whether the text begins with an error that spreadsheets write in place of a
// number.
bool IsSpreadsheetError(std::string_view text) {
  for (const std::string_view error :
       {"#N/A", "#VALUE!", "#DIV/0!", "#REF!", "#NUM!", "#NAME?", "#NULL!"}) {
    if (text.starts_with(error)) return true;
  }
  return false;
}

}  // namespace

CsvRows::CsvRows(std::istream& in, std::string source, CsvLimits limits)
    : RowSource(std::move(source)), in_(in), limits_(limits) {
  set_separator(',');
}

CsvRows::CsvRows(std::unique_ptr<std::istream> in, std::string source,
                 CsvLimits limits)
    : RowSource(std::move(source)),
      owned_(std::move(in)),
      in_(*owned_),
      limits_(limits) {
  set_separator(',');
}

void CsvRows::set_separator(char separator) {
  separator_ = separator;
  is_special_.fill(false);
  for (const char c : {separator, '\n', '\r', '"', '\0'}) {
    is_special_[Byte(c)] = true;
  }
}

// More of the file behind what is not yet taken; false at its end, or if the
// row that begins there is too long.
bool CsvRows::Fill() {
  if (at_end_ || !status_.ok()) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ >= limits_.max_row_bytes) {
    Fault(absl::StrCat("the line is longer than ", limits_.max_row_bytes,
                       " bytes; a row must be shorter"));
    return false;
  }
  if (end_ == buffer_.size()) {
    buffer_.resize(std::min(std::max(kFirstBlock, 2 * buffer_.size()),
                            limits_.max_row_bytes));
  }
  in_.read(buffer_.data() + end_,
           static_cast<std::streamsize>(buffer_.size() - end_));
  end_ += static_cast<std::size_t>(in_.gcount());
  if (in_.bad()) {
    status_ = absl::DataLossError(
        absl::StrCat(source(), ": cannot be read after line ", line_ - 1,
                     "; a compressed file may be damaged or cut"));
    return false;
  }
  at_end_ = in_.eof();
  if (started_) return true;
  started_ = true;
  const std::string_view start(buffer_.data(), end_);
  if (start.starts_with("\xFF\xFE") || start.starts_with("\xFE\xFF")) {
    Fault("the file is in UTF-16; save it as UTF-8");
    return false;
  }
  if (const std::string_view kind = NotText(start); !kind.empty()) {
    Fault(absl::StrCat("the file is ", std::string(kind)));
    return false;
  }
  if (start.starts_with(kByteOrderMark)) begin_ = kByteOrderMark.size();
  return true;
}

std::string_view CsvRows::Peek() {
  if (begin_ == end_) Fill();
  return {buffer_.data() + begin_, end_ - begin_};
}

std::unique_ptr<RowSource> CsvRows::Preview() {
  std::string text(Peek());
  if (!at_end_) text.resize(text.rfind('\n') + 1);
  auto rows = std::make_unique<CsvRows>(
      std::make_unique<std::istringstream>(std::move(text)), source(), limits_);
  rows->set_separator(separator_);
  rows->header_ = header_;
  rows->line_ = line_;
  return rows;
}

std::int64_t CsvRows::bytes_read() const {
  return in_.rdbuf()->pubseekoff(0, std::ios::cur, std::ios::in);
}

bool CsvRows::SkipLine() {
  while (status_.ok()) {
    const void* found = begin_ == end_ ? nullptr
                                       : std::memchr(buffer_.data() + begin_,
                                                     '\n', end_ - begin_);
    if (found != nullptr) {
      begin_ = static_cast<const char*>(found) - buffer_.data() + 1;
      ++line_;
      return true;
    }
    if (at_end_ && begin_ < end_) {
      begin_ = end_;
      return true;
    }
    if (!Fill()) return false;
  }
  return false;
}

bool CsvRows::Next(std::vector<std::string_view>& fields) {
  if (!header_.empty()) {
    fields.assign(header_.begin(), header_.end());
    row_line_ = line_;
    taken_header_.swap(header_);
    return true;
  }
  while (status_.ok()) {
    if (skips_comments_ && begin_ < end_ &&
        (buffer_[begin_] == '#' || buffer_[begin_] == '/')) {
      if (end_ - begin_ < kLongestError && !at_end_) {
        if (!Fill()) return false;
        continue;
      }
      const std::string_view rest(buffer_.data() + begin_, end_ - begin_);
      if (rest[0] == '#' ? !IsSpreadsheetError(rest) : rest.starts_with("//")) {
        if (!SkipLine()) return false;
        ++comments_;
        continue;
      }
    }
    row_line_ = line_;
    Scan scan = begin_ == end_ && at_end_ ? Scan::kMore : ScanRow();
    if (scan == Scan::kMore) {
      if (!Fill()) return false;
      continue;
    }
    if (scan == Scan::kFault) return false;
    if (scan == Scan::kRow) {
      fields.resize(fields_.size());
      for (std::size_t c = 0; c < fields_.size(); ++c) {
        if (fields_[c].escaped) Unescape(fields_[c]);
        fields[c] = {buffer_.data() + fields_[c].begin,
                     fields_[c].end - fields_[c].begin};
      }
    }
    begin_ = next_;
    line_ += lines_;
    if (scan == Scan::kRow) return true;
  }
  return false;
}

// The row at begin_ into fields_, as far as it has been read.
CsvRows::Scan CsvRows::ScanRow() {
  fields_.clear();
  lines_ = 1;
  std::size_t at = begin_;
  while (true) {
    if (static_cast<int>(fields_.size()) == limits_.max_columns) {
      fields_.emplace_back();
      return Fault(absl::StrCat("there are more than ", limits_.max_columns,
                                " columns"));
    }
    Field& field = fields_.emplace_back();
    if (at == end_ && !at_end_) return Scan::kMore;
    if (at < end_ && buffer_[at] == '"') {
      const Scan scan = ScanQuoted(at, field);
      if (scan != Scan::kRow) return scan;
    } else {
      field.begin = at;
      while (at < end_ && !is_special_[Byte(buffer_[at])]) ++at;
      field.end = at;
    }
    if (at == end_) return at_end_ ? ScanEnd(at) : Scan::kMore;
    if (buffer_[at] == separator_) {
      ++at;
      continue;
    }
    if (buffer_[at] == '"') {
      return Fault(
          "a quote inside an unquoted field; quote the whole field and double "
          "the quotes in it");
    }
    if (buffer_[at] == '\0') {
      return Fault(
          "a NUL byte: the file is binary or in UTF-16; save it as text in "
          "UTF-8");
    }
    return ScanEnd(at);
  }
}

// The end of the row at `at`: LF, CR or the end of the file.
CsvRows::Scan CsvRows::ScanEnd(std::size_t at) {
  if (at < end_ && buffer_[at] == '\r') {
    if (at + 1 == end_ && !at_end_) return Scan::kMore;
    if (at + 1 < end_ && buffer_[at + 1] != '\n') {
      return Fault(
          "a carriage return inside the line; lines must end with LF or CRLF");
    }
    ++at;
  }
  next_ = std::min(at + 1, end_);
  const Field& field = fields_[0];
  const bool is_empty =
      fields_.size() == 1 && field.begin == begin_ && field.end == field.begin;
  return is_empty ? Scan::kEmptyLine : Scan::kRow;
}

// From the opening quote at `at` to what follows the closing one.
CsvRows::Scan CsvRows::ScanQuoted(std::size_t& at, Field& field) {
  field.begin = ++at;
  while (true) {
    while (at < end_ && buffer_[at] != '"') {
      if (buffer_[at] == '\n') ++lines_;
      if (buffer_[at] == '\r') field.escaped = true;
      if (buffer_[at] == '\0') {
        return Fault("a NUL byte: the file is binary or in UTF-16");
      }
      ++at;
    }
    if (at == end_) {
      return at_end_ ? Fault("the quote that opens here is not closed")
                     : Scan::kMore;
    }
    if (at + 1 == end_ && !at_end_) return Scan::kMore;
    if (at + 1 == end_ || buffer_[at + 1] != '"') break;
    field.escaped = true;
    at += 2;
  }
  field.end = at++;
  if (at < end_ && buffer_[at] != separator_ && buffer_[at] != '\n' &&
      buffer_[at] != '\r') {
    return Fault("text after the closing quote");
  }
  return Scan::kRow;
}

// Doubled quotes become one, CRLF becomes LF.
void CsvRows::Unescape(Field& field) {
  std::size_t to = field.begin;
  for (std::size_t from = field.begin; from < field.end; ++from) {
    const char c = buffer_[from];
    if (c == '"') ++from;
    if (c == '\r' && from + 1 < field.end && buffer_[from + 1] == '\n')
      continue;
    buffer_[to++] = c;
  }
  field.end = to;
}

CsvRows::Scan CsvRows::Fault(std::string_view what) {
  row_line_ = line_;
  status_ =
      InvalidArgument(Place(std::max<int>(1, static_cast<int>(fields_.size()))),
                      ": ", std::string(what));
  return Scan::kFault;
}

std::string QuoteCsvField(std::string_view field) {
  std::string text;
  if (IsComputed(field)) {
    text = absl::StrCat("'", std::string(field));
    field = text;
  }
  // Blanks at the ends are quoted for those programs that drop them.
  const bool plain =
      field.find_first_of(",\"\r\n") == std::string_view::npos &&
      (field.empty() || (field.front() != ' ' && field.back() != ' '));
  if (plain) return std::string(field);
  std::string quoted = "\"";
  for (const char c : field) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

bool IsUtf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = CharacterLength(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

std::string QuotedCsvText(std::string_view text) {
  return absl::StrCat("'", ShowCsvText(text), "'");
}

std::string ShowCsvText(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    if (shown.size() >= kShownBytes) return shown + "…";
    const std::size_t length = CharacterLength(text);
    if (length == 0 || Byte(text[0]) < 0x20 || text[0] == 0x7F) {
      absl::StrAppend(&shown, "\\x", absl::Hex(Byte(text[0]), absl::kZeroPad2));
      text.remove_prefix(1);
    } else {
      shown.append(text.substr(0, length));
      text.remove_prefix(length);
    }
  }
  return shown;
}

}  // namespace mle
