#include "mle/maintain/common_factor.h"

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

GainEstimates Row(std::vector<double> gains, double error) {
  const auto n = static_cast<Eigen::Index>(gains.size());
  GainEstimates estimates;
  estimates.values = Eigen::Map<Eigen::RowVectorXd>(gains.data(), n);
  estimates.errors = error * estimates.values.cwiseAbs();
  return estimates;
}

double FactorOf(std::vector<double> gains, double error = 0.01) {
  const GainEstimates estimates = Row(std::move(gains), error);
  const auto factor = FindCommonFactor({estimates, estimates}, true, 0);
  return factor.has_value() ? factor->factor : 0.0;
}

TEST(CommonFactorTest, ElementsMustAgree) {
  EXPECT_EQ(FactorOf({1.8, 1.82}), 1.8);
  EXPECT_EQ(FactorOf({1.8, 2.2}), 0.0);
  EXPECT_NEAR(FactorOf({7.0, 7.2}), 7.1, 0.01);
  EXPECT_EQ(FactorOf({7.0, 10.0}), 0.0);
  EXPECT_EQ(FactorOf({90.0, 120.0}), 100.0);
  EXPECT_EQ(FactorOf({0.009, 0.012}), 0.01);
  EXPECT_EQ(FactorOf({30.0, 300.0}), 0.0);
}

TEST(CommonFactorTest, AgeingHasNone) {
  EXPECT_EQ(FactorOf({1.0, 1.0}), 0.0);
  EXPECT_EQ(FactorOf({0.5, 0.5}), 0.0);
  EXPECT_EQ(FactorOf({2.0, 2.0}), 0.0);
  EXPECT_EQ(FactorOf({3.0, 3.0}), 0.0);
  EXPECT_EQ(FactorOf({-1.0, 1.0}), 0.0);
  EXPECT_EQ(FactorOf({-100.0, 100.0}), 0.0);
}

TEST(CommonFactorTest, SignsMayHaveAgedToo) {
  EXPECT_NEAR(FactorOf({-0.7, -1.5}), -std::sqrt(0.7 * 1.5), 1e-12);
  EXPECT_LT(FactorOf({-0.3, -1.0}), 0.0);
  EXPECT_EQ(FactorOf({-0.2, -1.0}), 0.0);
}

TEST(CommonFactorTest, OneOfFourMayHaveAgedBesides) {
  EXPECT_EQ(FactorOf({1.8, 1.26, 1.82, 1.79}), 1.8);
  EXPECT_EQ(FactorOf({1.8, 1.8, 2.3}), 0.0);
  EXPECT_NEAR(FactorOf({-1.0, -0.8, 1.0, -1.1}), -std::cbrt(0.88), 1e-12);
  EXPECT_EQ(FactorOf({100.0, 90.0, 110.0, 3.0}), 100.0);
  EXPECT_EQ(FactorOf({1.8, 1.8, 2.3, 1.3}), 0.0);
  EXPECT_EQ(FactorOf({0.55, 0.56, 0.39, 0.56, 0.8, 0.555, 0.56, 0.55}),
            1.0 / 1.8);
  EXPECT_EQ(FactorOf({1.0, 1.0, 1.0, 1.8}), 0.0);
}

// Of two elements one is not determined: large factors only.
TEST(CommonFactorTest, UndeterminedElementsSayNothing) {
  GainEstimates estimates = Row({100.0, 3.0}, 0.01);
  estimates.errors(1) = 10.0;
  EXPECT_EQ(FindCommonFactor({estimates}, true, 0)->factor, 100.0);
  estimates.values(0) = -1.0;
  EXPECT_FALSE(FindCommonFactor({estimates}, true, 0).has_value());
}

TEST(CommonFactorTest, OneElement) {
  EXPECT_EQ(FactorOf({-1.02}), -1.02);
  EXPECT_EQ(FactorOf({-0.6}), -0.6);
  EXPECT_EQ(FactorOf({-0.2}), 0.0);
  EXPECT_EQ(FactorOf({59.0}), 60.0);
  EXPECT_EQ(FactorOf({30.0}), 0.0);
  EXPECT_EQ(FactorOf({1.8}), 0.0);  // ageing makes it, too
  EXPECT_EQ(FactorOf({60.0}, 0.1), 0.0);
  const GainEstimates one = Row({60.0}, 0.01);
  EXPECT_EQ(FindCommonFactor({one}, true, 0)->elements, 1);
}

// Estimates that differ must be confirmed by what is left.
TEST(CommonFactorTest, DisagreementAsksForMore) {
  const GainEstimates first = Row({1.8, 1.8}, 0.01);
  const GainEstimates second = Row({1.5, 1.8}, 0.01);
  EXPECT_FALSE(FindCommonFactor({first, first}, true, 0)->must_be_complete);
  EXPECT_TRUE(FindCommonFactor({first, second}, true, 0)->must_be_complete);
  EXPECT_FALSE(FindCommonFactor({second, first}, true, 0).has_value());
}

TEST(CommonFactorTest, Columns) {
  GainEstimates estimates;
  estimates.values = Eigen::MatrixXd::Ones(2, 2);
  estimates.values.col(1) *= 100.0;
  estimates.errors = Eigen::MatrixXd::Constant(2, 2, 0.01);
  EXPECT_FALSE(FindCommonFactor({estimates}, false, 0).has_value());
  EXPECT_EQ(FindCommonFactor({estimates}, false, 1)->factor, 100.0);
  EXPECT_FALSE(FindCommonFactor({estimates}, true, 0).has_value());
}

}  // namespace
}  // namespace mle
