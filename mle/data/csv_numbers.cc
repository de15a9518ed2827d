#include "mle/data/csv_numbers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <system_error>

namespace mle {
namespace {

constexpr std::string_view kComputed = "=+-@";

}  // namespace

bool ReadCsvNumber(std::string_view text, double& number, char decimal) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return false;
  }
  std::array<char, 64> with_point;
  if (decimal != '.') {
    if (text.size() > with_point.size()) return false;
    if (text.find('.') != std::string_view::npos) return false;
    std::replace_copy(text.begin(), text.end(), with_point.begin(), decimal,
                      '.');
    text = std::string_view(with_point.data(), text.size());
  }
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

void AppendCsvNumber(double number, std::string& text) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), number);
  text.append(buffer, result.ptr);
}

double RoundCsvTime(double time) {
  char buffer[40];
  const auto result =
      std::to_chars(buffer, buffer + sizeof(buffer), time,
                    std::chars_format::scientific, kCsvTimeDigits - 1);
  std::from_chars(buffer, result.ptr, time);
  return time;
}

std::string_view TrimCsvField(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) {
    text.remove_prefix(1);
  }
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) {
    text.remove_suffix(1);
  }
  if (text.size() > 2 && text[0] == '\'' &&
      kComputed.find(text[1]) != std::string_view::npos) {
    text.remove_prefix(1);
  }
  return text;
}

bool IsComputed(std::string_view field) {
  double number = 0.0;
  return field.size() > 1 &&
         kComputed.find(field[0]) != std::string_view::npos &&
         !ReadCsvNumber(field, number);
}

std::string_view WithoutHash(std::string_view text) {
  text = TrimCsvField(text);
  if (text.starts_with('#') && text.size() > 1) text.remove_prefix(1);
  return TrimCsvField(text);
}

}  // namespace mle
