#include "sim/transformed_plant.h"

#include <cmath>
#include <memory>
#include <utility>

#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "sim/closed_loop.h"
#include "sim/plant.h"
#include "tests/mle/model/transforms.h"

namespace mle::sim {
namespace {

ProcessModel Tank() {
  ProcessModel model("tank", "min", {{"valve", "%"}, {"drain", "%"}},
                     {{"level", "m"}});
  model.element(0, 0) = TransferFunction::FirstOrder(0.05, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-0.02, 4.0, 0.0);
  model.set_input_transform(0, EqualPercentage(50.0, 40.0));
  model.set_output_transform(0, Root(4.0));
  return model;
}

TransformedPlant MakeTank() {
  auto linear = Plant::Create(Tank(), {.sample_time = 0.5});
  EXPECT_TRUE(linear.ok()) << linear.status();
  return TransformedPlant(std::make_unique<Plant>(*std::move(linear)), Tank());
}

TEST(TransformedPlantTest, IsAtRestAtItsOperatingPoint) {
  TransformedPlant plant = MakeTank();
  for (int k = 0; k < 20; ++k) {
    EXPECT_NEAR(plant.outputs()[0], 0.0, 1e-12);
    plant.Advance(Eigen::Vector2d::Zero());
  }
}

// At rest elsewhere √level is what the valve lets through.
TEST(TransformedPlantTest, GainsFollowTheOperatingPoint) {
  TransformedPlant plant = MakeTank();
  for (int k = 0; k < 400; ++k) plant.Advance(Eigen::Vector2d(20.0, 0.0));
  const double c = std::log(50.0) / 100.0;
  const double v = std::expm1(c * 20.0) / c;
  const double z = 0.05 * v;  // 4 + z = 4 + 4 · 2 (√(y/4) − 1)
  const double root = 1.0 + z / 8.0;
  EXPECT_NEAR(plant.outputs()[0], 4.0 * root * root - 4.0, 1e-9);
  // What has no transform is as it was.
  TransformedPlant drained = MakeTank();
  for (int k = 0; k < 400; ++k) drained.Advance(Eigen::Vector2d(0.0, 10.0));
  const double lower = 1.0 - 0.2 / 8.0;
  EXPECT_NEAR(drained.outputs()[0], 4.0 * lower * lower - 4.0, 1e-9);
}

TEST(TransformedPlantTest, WithoutOneTransformsAreRefusedNotIgnored) {
  const auto record = SimulateClosedLoop(
      Tank(), [](const auto&, const auto&, auto next) { next.setZero(); },
      SetPointProfile{}, {.sample_time = 0.5, .control_period = 0.5});
  EXPECT_NE(record.status().message().find("has a transform"),
            std::string::npos);
}

}  // namespace
}  // namespace mle::sim
