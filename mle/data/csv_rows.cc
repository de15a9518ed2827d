#include "mle/data/csv_rows.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace mle {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

}  // namespace

CsvRows::CsvRows(std::istream& in, std::string source)
    : in_(in), source_(std::move(source)) {}

bool CsvRows::Next(std::vector<std::string>& fields) {
  if (!status_.ok()) return false;
  do {
    if (!ReadLine()) return false;
  } while (text_.empty());
  row_line_ = line_;
  return ParseRow(fields);
}

bool CsvRows::ReadLine() {
  if (!std::getline(in_, text_)) {
    if (in_.bad()) {
      status_ = absl::DataLossError(
          absl::StrCat(source_, ": cannot be read after line ", line_));
    }
    return false;
  }
  ++line_;
  if (!text_.empty() && text_.back() == '\r') text_.pop_back();
  if (line_ == 1 && text_.starts_with(kByteOrderMark)) {
    text_.erase(0, kByteOrderMark.size());
  }
  return true;
}

bool CsvRows::ParseRow(std::vector<std::string>& fields) {
  std::size_t count = 0;
  std::size_t at = 0;
  while (true) {
    if (count == fields.size()) fields.emplace_back();
    std::string& field = fields[count++];
    field.clear();
    const int number = static_cast<int>(count);
    if (at < text_.size() && text_[at] == '"') {
      if (!ParseQuoted(at, field, number)) return false;
    } else {
      const std::size_t end = std::min(text_.find(',', at), text_.size());
      field.assign(text_, at, end - at);
      if (field.find('"') != std::string::npos) {
        return Fault(number,
                     "a quote inside an unquoted field; quote the whole field "
                     "and double the quotes in it");
      }
      at = end;
    }
    if (at == text_.size()) break;
    ++at;  // the comma
  }
  fields.resize(count);
  return true;
}

// From the opening quote at `at` to what follows the closing one.
bool CsvRows::ParseQuoted(std::size_t& at, std::string& field, int number) {
  ++at;
  while (true) {
    const std::size_t quote = text_.find('"', at);
    if (quote == std::string::npos) {
      field.append(text_, at);
      if (!ReadLine()) {
        if (!status_.ok()) return false;
        return Fault(number, "the quote that opens here is not closed");
      }
      field += '\n';
      at = 0;
      continue;
    }
    field.append(text_, at, quote - at);
    at = quote + 1;
    if (at < text_.size() && text_[at] == '"') {
      field += '"';
      ++at;
      continue;
    }
    if (at < text_.size() && text_[at] != ',') {
      return Fault(number, "text after the closing quote");
    }
    return true;
  }
}

bool CsvRows::Fault(int field, std::string_view what) {
  status_ = absl::InvalidArgumentError(
      absl::StrCat(Place(field), ": ", std::string(what)));
  return false;
}

std::string CsvRows::Place(int field) const {
  return absl::StrCat(source_, ": line ", row_line_, ", column ", field);
}

std::string QuoteCsvField(std::string_view field) {
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

}  // namespace mle
