#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "apps/report/text.h"

namespace mle::report {
namespace {

constexpr std::string_view kMinus = "\u2212";
constexpr std::string_view kTimes = "\u00D7";

std::string ToChars(double value, std::chars_format format, int precision) {
  // 309 digits before the point, 17 after it, sign and point.
  std::array<char, 400> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                 value, format, precision);
  return std::string(buffer.data(), end.ptr);
}

std::string NotFinite(double value) {
  if (std::isnan(value)) return "–";
  return value > 0 ? "∞" : std::string(kMinus) + "∞";
}

// Commas between the thousands of the digits before the point.
std::string Grouped(const std::string& digits) {
  const std::size_t whole = std::min(digits.find('.'), digits.size());
  std::string out;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && i < whole && (whole - i) % 3 == 0) out += ',';
    out += digits[i];
  }
  return out;
}

struct Scientific {
  std::string mantissa;
  int exponent = 0;
};

Scientific Split(double magnitude, int digits) {
  const std::string text =
      ToChars(magnitude, std::chars_format::scientific, digits - 1);
  const std::size_t e = text.find('e');
  return {text.substr(0, e), std::atoi(text.c_str() + e + 1)};
}

}  // namespace

std::string PowerOfTen(int exponent) {
  static constexpr std::array<std::string_view, 10> kSuperscripts = {
      "⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  if (exponent == 0) return "1";
  if (exponent == 1) return "10";
  std::string out = "10";
  if (exponent < 0) out += "⁻";
  for (const char digit : std::to_string(std::abs(exponent))) {
    out += kSuperscripts[digit - '0'];
  }
  return out;
}

std::string FormatScientific(double value, int digits) {
  if (!std::isfinite(value)) return NotFinite(value);
  if (value == 0.0) return "0";
  const Scientific parts = Split(std::abs(value), std::clamp(digits, 1, 17));
  std::string out(value < 0 ? kMinus : "");
  out += parts.mantissa;
  if (parts.exponent == 0) return out;
  return out + std::string(kTimes) + PowerOfTen(parts.exponent);
}

std::string FormatFixed(double value, int decimals) {
  if (!std::isfinite(value)) return NotFinite(value);
  const std::string digits = ToChars(std::abs(value), std::chars_format::fixed,
                                     std::clamp(decimals, 0, 17));
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;
  std::string out(value < 0 && !zero ? kMinus : "");
  return out + Grouped(digits);
}

std::string FormatSignificant(double value, int digits) {
  if (!std::isfinite(value)) return NotFinite(value);
  if (value == 0.0) return "0";
  digits = std::clamp(digits, 1, 17);
  const int exponent = Split(std::abs(value), digits).exponent;
  const bool plain = exponent >= -3 && std::abs(value) < 999999.5;
  if (!plain) return FormatScientific(value, digits);
  return FormatFixed(value, std::max(0, digits - 1 - exponent));
}

std::string FormatHalfWidth(double half_width) {
  constexpr double kLeast = 1e-6;
  constexpr double kPlainFrom = 1e-3;
  if (!(half_width >= kLeast) || half_width >= kPlainFrom) {
    return FormatSignificant(half_width, 2);
  }
  return FormatFixed(half_width, 1 - Split(half_width, 2).exponent);
}

std::string FormatProbability(double p) {
  return p < 1e-300 ? "less than 10⁻³⁰⁰" : FormatSignificant(p, 2);
}

std::string ShortProbability(double p) {
  return p < 1e-9 ? "< 10⁻⁹" : FormatProbability(p);
}

std::string FormatMoney(double amount) {
  constexpr double kLeastWhole = 100.0;
  constexpr double kMostWhole = 1e12;
  const double size = std::abs(amount);
  return size >= kLeastWhole && size < kMostWhole ? FormatFixed(amount, 0)
                                                  : FormatSignificant(amount);
}

std::string FormatInteger(std::int64_t value) {
  std::string digits = std::to_string(value);
  if (value >= 0) return Grouped(digits);
  return std::string(kMinus) + Grouped(digits.substr(1));
}

}  // namespace mle::report
