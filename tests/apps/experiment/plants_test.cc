#include <cmath>
#include <string>

#include "Eigen/SVD"
#include "apps/experiment/campaign.h"
#include "apps/experiment/campaign_json.h"
#include "control/loop_analysis.h"
#include "control/mpc.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/experiment/small_campaign.h"

namespace mle::experiment {
namespace {

using ::testing::HasSubstr;

Campaign Small() { return *ParseCampaign(SmallCampaign(2).dump(), "c.json"); }

TEST(PlantsTest, DrawsAreWithinTheirRanges) {
  const std::vector<ControllerSpec> controllers(1);
  const RandomPlants ranges = {.outputs = 3,
                               .inputs = 2,
                               .gain = {2.0, 8.0},
                               .time_constant = {4.0, 9.0},
                               .delay = {1.0, 3.0},
                               .max_condition_number = 6.0,
                               .max_sensitivity = 2.5};
  int negative = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const absl::StatusOr<ProcessModel> model =
        DrawModel(ranges, seed, controllers);
    ASSERT_TRUE(model.ok()) << model.status();
    Eigen::MatrixXd gains(3, 2);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 2; ++j) {
        const TransferFunction& element = model->element(i, j);
        gains(i, j) = element.StaticGain();
        negative += gains(i, j) < 0.0 ? 1 : 0;
        EXPECT_GE(std::abs(gains(i, j)), 2.0);
        EXPECT_LE(std::abs(gains(i, j)), 8.0);
        EXPECT_GE(element.TimeConstant(), 4.0);
        EXPECT_LE(element.TimeConstant(), 9.0);
        EXPECT_GE(element.delay(), 1.0);
        EXPECT_LE(element.delay(), 3.0);
      }
    }
    const Eigen::VectorXd values =
        Eigen::JacobiSVD<Eigen::MatrixXd>(gains).singularValues();
    EXPECT_LE(values(0) / values(1), 6.0 * (1.0 + 1e-12));
    const auto mpc =
        control::Mpc::Create(*model, *controllers.front().For(3, 2));
    ASSERT_TRUE(mpc.ok());
    const auto loop = control::AnalyseLoop(
        *mpc, *control::PredictFromProcess(
                  *model, controllers.front().mpc.control_period));
    ASSERT_TRUE(loop.ok());
    EXPECT_TRUE(loop->stable);
    EXPECT_LE(loop->sensitivity_peak, 2.5);
  }
  // Of 120 gains of either sign: beyond 8 standard deviations otherwise.
  EXPECT_GT(negative, 15);
  EXPECT_LT(negative, 105);
}

TEST(PlantsTest, ASeedIsAPlant) {
  const std::vector<ControllerSpec> controllers(1);
  const ProcessModel a = *DrawModel({}, 7, controllers);
  const ProcessModel b = *DrawModel({}, 7, controllers);
  const ProcessModel c = *DrawModel({}, 8, controllers);
  EXPECT_EQ(FormatProcessModel(a), FormatProcessModel(b));
  EXPECT_NE(FormatProcessModel(a), FormatProcessModel(c));
}

TEST(PlantsTest, SaysWhereNoDrawWillDo) {
  const RandomPlants ranges = {.gain = {1.0, 20.0},
                               .max_condition_number = 1.0};
  const auto model = DrawModel(ranges, 1, std::vector<ControllerSpec>(1));
  ASSERT_FALSE(model.ok());
  EXPECT_THAT(std::string(model.status().message()),
              HasSubstr("condition number"));
}

TEST(PlantsTest, AChangeAgesTheElementsItNames) {
  const ProcessModel model = Small().models[0].model;
  Mismatch mismatch = {.name = "m", .size = 2.0, .plant = {}, .changes = {}};
  mismatch.changes.push_back({.output = "top",
                              .input = "*",
                              .elements = 0,
                              .gain_factor = {0.5, 0.5},
                              .time_constant_factor = {1.5, 1.5},
                              .delay_shift = {0.25, 0.25}});
  const ProcessModel aged = *AgeModel(model, mismatch, 1);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const TransferFunction& was = model.element(i, j);
      const TransferFunction& is = aged.element(i, j);
      const bool changed = i == 0;
      // Size 2: factors squared, shifts doubled.
      EXPECT_NEAR(is.StaticGain(), was.StaticGain() * (changed ? 0.25 : 1.0),
                  1e-12);
      EXPECT_NEAR(is.TimeConstant(),
                  was.TimeConstant() * (changed ? 2.25 : 1.0), 1e-12);
      EXPECT_NEAR(is.delay(), was.delay() + (changed ? 0.5 : 0.0), 1e-12);
    }
  }
}

TEST(PlantsTest, DrawsElementsAndTheirChanges) {
  const ProcessModel model = Small().models[0].model;
  Mismatch mismatch = {.name = "m", .size = 1.0, .plant = {}, .changes = {}};
  mismatch.changes.push_back({.output = "*",
                              .input = "*",
                              .elements = 2,
                              .gain_factor = {0.5, 2.0},
                              .time_constant_factor = {1.0, 1.0},
                              .delay_shift = {1.0, 3.0}});
  Eigen::MatrixXi drawn = Eigen::MatrixXi::Zero(2, 2);
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const ProcessModel aged = *AgeModel(model, mismatch, seed);
    int changed = 0;
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        const double shift =
            aged.element(i, j).delay() - model.element(i, j).delay();
        if (shift == 0.0) continue;
        ++changed;
        ++drawn(i, j);
        EXPECT_GE(shift, 1.0 - 1e-12);
        EXPECT_LE(shift, 3.0 + 1e-12);
        const double factor =
            aged.element(i, j).StaticGain() / model.element(i, j).StaticGain();
        EXPECT_GE(factor, 0.5 - 1e-12);
        EXPECT_LE(factor, 2.0 + 1e-12);
      }
    }
    EXPECT_EQ(changed, 2);
  }
  // Each element half the time; 100 ± 5 standard deviations of 7.1.
  EXPECT_GT(drawn.minCoeff(), 64);
  EXPECT_LT(drawn.maxCoeff(), 136);
}

}  // namespace
}  // namespace mle::experiment
