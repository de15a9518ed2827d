#include "tests/apps/page_tables.h"

#include <cmath>
#include <cstddef>
#include <string_view>

#include "gtest/gtest.h"
#include "tests/apps/report/markup.h"

namespace mle {
namespace {

// What stands between `open` and `close`, again and again.
std::vector<std::string> Pieces(const std::string& text,
                                const std::string& open,
                                const std::string& close) {
  std::vector<std::string> pieces;
  for (std::size_t at = text.find(open); at != std::string::npos;
       at = text.find(open, at + 1)) {
    const std::size_t start = at + open.size();
    pieces.push_back(text.substr(start, text.find(close, start) - start));
  }
  return pieces;
}

bool Take(std::string_view& text, std::string_view start) {
  if (text.substr(0, start.size()) != start) return false;
  text.remove_prefix(start.size());
  return true;
}

// "⁻¹¹", −1 × it if there is no such digit.
int TakeExponent(std::string_view& text) {
  constexpr std::string_view kDigits[] = {"⁰", "¹", "²", "³", "⁴",
                                          "⁵", "⁶", "⁷", "⁸", "⁹"};
  const int sign = Take(text, "⁻") ? -1 : 1;
  int value = 0;
  for (bool found = true; found;) {
    found = false;
    for (int digit = 0; digit < 10; ++digit) {
      if (!Take(text, kDigits[digit])) continue;
      value = 10 * value + digit;
      found = true;
    }
  }
  return sign * value;
}

}  // namespace

std::vector<PageTable> TablesOf(const std::string& html) {
  std::vector<PageTable> tables;
  for (const std::string& piece : Pieces(html, "<table>", "</table>")) {
    const report::Markup markup =
        report::ParseMarkup("<table>" + piece + "</table>");
    EXPECT_EQ(markup.error, "");
    PageTable& table = tables.emplace_back();
    for (const report::Element& element : markup.elements) {
      if (element.name == "caption") table.caption = element.text;
      if (element.name == "tr") table.rows.emplace_back();
      if (element.name == "th" || element.name == "td") {
        table.rows.back().push_back(element.text);
      }
    }
  }
  return tables;
}

PageTable TableOf(const std::string& html, const std::string& caption) {
  for (PageTable& table : TablesOf(html)) {
    if (table.caption.rfind(caption, 0) == 0) return table;
  }
  ADD_FAILURE() << "no table '" << caption << "'";
  return {};
}

void ExpectShows(const std::string& text, double value) {
  std::string_view rest = text;
  const bool negative = Take(rest, "−");
  std::string digits;
  int decimals = 0;
  bool point = false;
  while (!rest.empty()) {
    const char c = rest.front();
    if (c == ',' && !point) {
      // grouped thousands
    } else if (c == '.' && !point) {
      point = true;
    } else if (c >= '0' && c <= '9') {
      digits += c;
      decimals += point ? 1 : 0;
    } else {
      break;
    }
    rest.remove_prefix(1);
  }
  ASSERT_FALSE(digits.empty()) << "'" << text << "' is not " << value;
  const int exponent = Take(rest, "×10") ? TakeExponent(rest) : 0;
  const double unit = std::pow(10.0, exponent - decimals);
  const double shown = (negative ? -1.0 : 1.0) * std::stod(digits) * unit;
  EXPECT_NEAR(shown, value, 0.5001 * unit) << text;
}

}  // namespace mle
