#include <limits>

#include "apps/report/text.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle::report {
namespace {

TEST(FormatHalfWidth, StandsBelowTheDigitsOfItsValue) {
  EXPECT_EQ(FormatHalfWidth(3.84e-4), "0.00038");
  EXPECT_EQ(FormatHalfWidth(9.96e-4), "0.0010");
  EXPECT_EQ(FormatHalfWidth(0.00525), FormatSignificant(0.00525, 2));
  EXPECT_EQ(FormatHalfWidth(12.3), "12");
  EXPECT_EQ(FormatHalfWidth(1.23e-8), "1.2×10⁻⁸");
  EXPECT_EQ(FormatHalfWidth(0.0), "0");
}

TEST(FormatSignificant, PlainWhereThatIsReadable) {
  EXPECT_EQ(FormatSignificant(0.09334, 3), "0.0933");
  EXPECT_EQ(FormatSignificant(8.1, 3), "8.10");
  EXPECT_EQ(FormatSignificant(-20.62, 3), "−20.6");
  EXPECT_EQ(FormatSignificant(19363.2, 3), "19,363");
  EXPECT_EQ(FormatSignificant(999949.0, 3), "999,949");
  EXPECT_EQ(FormatSignificant(999999.4, 3), "999,999");
  EXPECT_EQ(FormatSignificant(0.001, 2), "0.0010");
}

TEST(FormatSignificant, ScientificBeyond) {
  EXPECT_EQ(FormatSignificant(1.5e-5, 2), "1.5×10⁻⁵");
  EXPECT_EQ(FormatSignificant(1e6, 1), "1×10⁶");
  EXPECT_EQ(FormatSignificant(-1.2345e12, 3), "−1.23×10¹²");
}

TEST(FormatSignificant, RoundingMayCarryIntoTheNextPower) {
  EXPECT_EQ(FormatSignificant(9.996, 3), "10.0");
  EXPECT_EQ(FormatSignificant(0.00099996, 3), "0.00100");
  EXPECT_EQ(FormatSignificant(999999.9, 3), "1.00×10⁶");
}

TEST(FormatScientific, MantissaAndPower) {
  EXPECT_EQ(FormatScientific(0.09334, 3), "9.33×10⁻²");
  EXPECT_EQ(FormatScientific(-12345, 2), "−1.2×10⁴");
  EXPECT_EQ(FormatScientific(3.14159, 3), "3.14");
  EXPECT_EQ(FormatScientific(9.999, 2), "1.0×10");
}

TEST(FormatFixed, ZeroHasNoSign) {
  EXPECT_EQ(FormatFixed(-3.14159, 2), "−3.14");
  EXPECT_EQ(FormatFixed(-0.001, 2), "0.00");
  EXPECT_EQ(FormatFixed(-0.0, 0), "0");
  EXPECT_EQ(FormatFixed(1234567.891, 1), "1,234,567.9");
}

TEST(Format, WhatIsNoNumberIsShownAsSuch) {
  for (const auto format : {FormatSignificant, FormatScientific, FormatFixed}) {
    EXPECT_EQ(format(kNaN, 3), "–");
    EXPECT_EQ(format(kInfinity, 3), "∞");
    EXPECT_EQ(format(-kInfinity, 3), "−∞");
  }
  EXPECT_EQ(FormatSignificant(0.0), "0");
  EXPECT_EQ(FormatScientific(-0.0), "0");
}

TEST(Format, ExtremesFit) {
  EXPECT_EQ(FormatScientific(std::numeric_limits<double>::denorm_min(), 2),
            "4.9×10⁻³²⁴");
  // 309 digits, 102 commas, the point and 17 decimals.
  EXPECT_EQ(FormatFixed(std::numeric_limits<double>::max(), 17).size(), 429u);
}

TEST(FormatInteger, GroupsThousands) {
  EXPECT_EQ(FormatInteger(0), "0");
  EXPECT_EQ(FormatInteger(999), "999");
  EXPECT_EQ(FormatInteger(10001), "10,001");
  EXPECT_EQ(FormatInteger(-1234567), "−1,234,567");
  EXPECT_EQ(FormatInteger(std::numeric_limits<std::int64_t>::min()),
            "−9,223,372,036,854,775,808");
}

TEST(PowerOfTen, Superscripts) {
  EXPECT_EQ(PowerOfTen(0), "1");
  EXPECT_EQ(PowerOfTen(1), "10");
  EXPECT_EQ(PowerOfTen(-13), "10⁻¹³");
  EXPECT_EQ(PowerOfTen(204), "10²⁰⁴");
}

}  // namespace
}  // namespace mle::report
