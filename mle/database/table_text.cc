#include "mle/database/table_text.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "absl/strings/str_cat.h"

namespace mle {
namespace {

bool IsControl(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte < 0x20 || byte == 0x7F;
}

// Nothing in it has a meaning, and no program would drop its blanks.
bool IsPlain(std::string_view value) {
  if (value.empty() || value.front() == ' ' || value.back() == ' ') {
    return value.empty();
  }
  return std::none_of(value.begin(), value.end(), [](char c) {
    return c == ',' || c == '"' || IsControl(c);
  });
}

}  // namespace

void TableText::Separate() {
  if (!is_first_) text_ += ',';
  is_first_ = false;
}

void TableText::AddQuoted(std::string_view value) {
  text_ += '"';
  for (const char c : value) {
    if (c == '"') {
      text_ += "\"\"";
    } else if (c == '\n' || c == '\r' || c == '\t') {
      text_ += ' ';
    } else if (IsControl(c)) {
      absl::StrAppend(
          &text_, "\\x",
          absl::Hex(static_cast<unsigned char>(c), absl::kZeroPad2));
    } else {
      text_ += c;
    }
  }
  text_ += '"';
}

void TableText::AddName(std::string_view name) {
  Separate();
  AddQuoted(name);
}

void TableText::Add(std::string_view value) {
  Separate();
  if (IsPlain(value)) {
    text_ += value;
  } else {
    AddQuoted(value);
  }
}

void TableText::Add(std::int64_t value) {
  Separate();
  absl::StrAppend(&text_, value);
}

void TableText::Add(double value) {
  Separate();
  std::array<char, 32> digits;
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text_.append(digits.data(), end);
}

void TableText::AddNull() { Separate(); }

void TableText::EndRow() {
  // An empty line would be no row.
  if (text_.empty() || text_.back() == '\n') text_ += "\"\"";
  text_ += '\n';
  is_first_ = true;
}

}  // namespace mle
