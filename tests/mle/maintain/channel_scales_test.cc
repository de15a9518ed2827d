#include "mle/maintain/channel_scales.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

ProcessModel Heater(double output_unit, double input_unit) {
  ProcessModel model("heater", "min", {{"u1", ""}, {"u2", ""}},
                     {{"y1", ""}, {"y2", ""}});
  const double f = output_unit / input_unit;
  model.element(0, 0) = TransferFunction::FirstOrder(2.0 * f, 5.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-0.8 * f, 6.0, 2.0);
  model.element(1, 1) = TransferFunction::FirstOrder(1.5 * f, 5.0, 2.5);
  return model;
}

std::vector<NoiseEstimate> Noise(double unit) {
  NoiseEstimate noise;
  noise.variance = 0.004 * unit * unit;
  noise.ratio = 1e-4;
  return {noise, noise};
}

Record Ramp() {
  Record record;
  record.sample_time = 0.5;
  record.outputs = Eigen::MatrixXd::Random(2, 50);
  record.inputs = Eigen::MatrixXd::Random(2, 50);
  return record;
}

TEST(ConversionScalesTest, NoiseOfEveryOutputBecomesThePapers) {
  const ChannelScales scales = ChooseScales(Heater(1, 1), Noise(1), {Ramp()});
  EXPECT_NEAR(0.004 / (scales.outputs(0) * scales.outputs(0)), 0.001, 1e-12);
}

TEST(ConversionScalesTest, UnitsChangeNothing) {
  const Record record = Ramp();
  const ChannelScales a = ChooseScales(Heater(1, 1), Noise(1), {record});
  Record other = record;
  other.outputs *= 1000.0;
  other.inputs *= 0.01;
  const ChannelScales b =
      ChooseScales(Heater(1000, 0.01), Noise(1000), {other});
  EXPECT_TRUE(Scaled(record, a).outputs.isApprox(Scaled(other, b).outputs));
  EXPECT_TRUE(Scaled(record, a).inputs.isApprox(Scaled(other, b).inputs));
  const ProcessModel model_a = Scaled(Heater(1, 1), a);
  const ProcessModel model_b = Scaled(Heater(1000, 0.01), b);
  EXPECT_NEAR(model_a.element(0, 1).StaticGain(),
              model_b.element(0, 1).StaticGain(), 1e-9);
}

TEST(ConversionScalesTest, AModelComesBackInItsUnits) {
  const ProcessModel model = Heater(20.0, 3.0);
  const ChannelScales scales = ChooseScales(model, Noise(20.0), {Ramp()});
  ConversionSettings settings;
  settings.samples = 20000;
  const auto conversion =
      ConvertUnderNoise(model, Noise(20.0), scales, 0.5, settings);
  ASSERT_TRUE(conversion.ok()) << conversion.status();
  const StepResponse wanted = model.ComputeStepResponse(0.5, 80);
  const StepResponse found =
      Unscaled(conversion->model, scales).ComputeStepResponse(80);
  // The noise of the conversion leaves about a percent.
  EXPECT_LT(std::sqrt(SquaredDistance(wanted, found)),
            0.03 * wanted.values.norm());
  // The pair that is zero stays next to zero.
  EXPECT_LT(found.element(1, 0).norm(), 0.03 * found.element(1, 1).norm());
}

TEST(ConversionScalesTest, OutputsWithoutNoiseHaveAScale) {
  std::vector<NoiseEstimate> noise = Noise(1.0);
  noise[0].variance = 0.0;
  const ChannelScales scales = ChooseScales(Heater(1, 1), noise, {Ramp()});
  EXPECT_GT(scales.outputs(0), 0.0);
  EXPECT_TRUE(scales.inputs.allFinite());
}

TEST(ConversionScalesTest, TheOrderIsThatOfThePaperForItsPlant) {
  ProcessModel column("column", "min", {InputChannel{"steam", ""}},
                      {OutputChannel{"overhead", ""}});
  column.element(0, 0) = TransferFunction::FirstOrder(-18.9, 21.0, 3.0);
  EXPECT_EQ(ChooseOrder(column, 0.2), 150);
  // Never more regressors than can be solved for in time.
  EXPECT_EQ(ChooseOrder(column, 1e-4), 750);
  EXPECT_EQ(ChooseOrder(column, 100.0), 10);
  // Unless an order is given.
  ConversionSettings settings;
  EXPECT_EQ(settings.OrderFor(column, 0.2), 150);
  settings.order = 40;
  EXPECT_EQ(settings.OrderFor(column, 0.2), 40);
}

}  // namespace
}  // namespace mle
