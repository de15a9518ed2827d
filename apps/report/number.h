// Numbers as they are printed in tables and sentences: with U+2212 as minus
// sign, × and superscripts for powers of ten, "–" for NaN and "∞" for infinity,
// independent of the locale.

#ifndef APPS_REPORT_NUMBER_H_
#define APPS_REPORT_NUMBER_H_

#include <cstdint>
#include <string>

namespace mle::report {

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

#endif  // APPS_REPORT_NUMBER_H_
