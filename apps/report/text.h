// Text as it is shown: what comes from outside (channel names, file names,
// messages) made safe for its place, and numbers.

#ifndef APPS_REPORT_TEXT_H_
#define APPS_REPORT_TEXT_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace mle::report {

// `text` as valid UTF-8 that may stand in XML: bytes that are no UTF-8 become
// U+FFFD, control characters (newlines among them) a space.
std::string CleanText(std::string_view text);

// The code points of CleanText(text).
std::vector<char32_t> CodePoints(std::string_view text);

// The code point as UTF-8.
std::string Utf8(char32_t code_point);

// CleanText, and & < > " ' as entities: safe in the text and in the quoted
// attributes of HTML and XML.
std::string EscapeHtml(std::string_view text);

// With blanks that do not break between a number and its sign: "95 %", "± 2",
// "× 0.5", "← reflux".
std::string WithSignsKept(std::string_view text);

// A path beside the page as the target of a link: "%" before what a URL would
// read as something else, "./" so that no scheme can be meant.
std::string RelativeUrl(std::string_view path);

// As EscapeHtml, but newlines and tabs stay: for <pre>.
std::string EscapeHtmlLines(std::string_view text);

// Columns `text` takes on a terminal: 0 for combining marks, 2 for East Asian
// wide characters and emoji, else 1.
int DisplayWidth(std::string_view text);

// The arguments as one line that a POSIX shell reads back as the same
// arguments: {"mle_correct", "--out=my dir"} gives mle_correct '--out=my dir'.
std::string QuoteCommandLine(const std::vector<std::string>& arguments);

// The font of the figures, and how wide text is in it.
inline constexpr char kFont[] = "DejaVu Sans";

// In units of the font size; characters beyond ASCII are taken a little wider
// than they are.
double TextWidth(std::string_view text);

// CleanText(text), cut and ended with "…" where it is wider than `width` (in
// units of the font size).
std::string Ellipsized(std::string_view text, double width);

// Numbers as they are printed in tables and sentences: with U+2212 as minus
// sign, × and superscripts for powers of ten, "–" for NaN and "∞" for infinity,
// independent of the locale.

// `digits` significant digits (1 … 17): in plain decimals from 1e-3 up to
// 1e6, with the thousands grouped, beyond that in scientific form:
//   FormatSignificant(0.09334, 3) = "0.0933"
//   FormatSignificant(19363.2, 3) = "19,363"  (no digit of the integer is lost)
//   FormatSignificant(1.5e-5, 2)  = "1.5×10⁻⁵"
std::string FormatSignificant(double value, int digits = 3);

// FormatScientific(0.09334, 3) = "9.33×10⁻²"; zero is "0".
std::string FormatScientific(double value, int digits = 3);

// `decimals` (0 … 17) digits after the point; what rounds to zero has no sign:
// FormatFixed(-3.14159, 2) = "−3.14".
std::string FormatFixed(double value, int decimals);

// Behind ±, two significant digits, in plain decimals down to 1e-6 so that they
// stand below those of the value: FormatHalfWidth(3.8e-4) = "0.00038".
std::string FormatHalfWidth(double half_width);

// FormatProbability(3.14e-9) = "3.1×10⁻⁹"; what is too small for a double is
// below its smallest.
std::string FormatProbability(double p);
// The same, but what is far below any level is not told apart: "< 10⁻⁹".
std::string ShortProbability(double p);

// An amount of money: whole from 100 on, three digits below, scientific from
// 1e12 on: FormatMoney(8609.6) = "8,610".
std::string FormatMoney(double amount);

// FormatInteger(10001) = "10,001".
std::string FormatInteger(std::int64_t value);

// "10⁻³"; PowerOfTen(0) = "1" and PowerOfTen(1) = "10".
std::string PowerOfTen(int exponent);

}  // namespace mle::report

#endif  // APPS_REPORT_TEXT_H_
