// Output-error fits of outputs that integrate: levels.

#include <cmath>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_reconstruction.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

// An integrator without lag, one with lag, and an element that settles.
ProcessModel Level() {
  ProcessModel model = MakeModel(1, 3);
  model.element(0, 0) = TransferFunction::Integrator(-0.4, 0.0, 0.6);
  model.element(0, 1) = TransferFunction::Integrator(0.3, 4.0, 1.3);
  model.element(0, 2) = TransferFunction::FirstOrder(2.0, 6.0, 1.0);
  return model;
}

ProcessModel AgedLevel() {
  ProcessModel plant = Level();
  plant.element(0, 0) = TransferFunction::Integrator(-0.26, 0.0, 1.43);
  return plant;
}

OutputErrorCorrection Correct(const std::vector<Record>& records,
                              const OutputErrorOptions& options = {}) {
  auto correction = CorrectByOutputError(Level(), records, options);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

// Inputs do not balance the level where records begin, and have not before.
TEST(OutputErrorIntegratingTest, RecoversAnExactPlant) {
  ProcessModel plant = AgedLevel();
  plant.element(0, 1) = TransferFunction::Integrator(0.5, 7.0, 0.27);
  const auto correction = Correct(MakeRecords(plant, 500, 1, {.offset = 40.0}));
  const std::vector<std::vector<double>> truth = {
      {-0.26, 0.0, 1.43}, {0.5, 7.0, 0.27}, {2.0, 6.0, 1.0}};
  for (int j = 0; j < 3; ++j) {
    const ElementEstimate& e = correction.full.element(0, j);
    // The plant is simulated to about 1e-9 of its levels, some tens.
    EXPECT_NEAR(e.gain.value, truth[j][0], 1e-6) << correction.FullReport();
    EXPECT_NEAR(e.time_scale.value, truth[j][1], 1e-5);
    EXPECT_NEAR(e.delay.value, truth[j][2], 1e-5);
  }
  // Of an integrator without a lag T is any.
  EXPECT_EQ(correction.full.element(0, 0).values().time_scale, 1.0);
  const ElementValues values = correction.full.element(0, 1).values();
  EXPECT_EQ(values.gain, correction.full.element(0, 1).gain.value);
  EXPECT_EQ(values.time_scale, correction.full.element(0, 1).time_scale.value);
  EXPECT_EQ(values.delay, correction.full.element(0, 1).delay.value);
  EXPECT_TRUE(correction.aged(0, 0));
  EXPECT_TRUE(correction.aged(0, 1));
  // Two elements with three parameters, one with two.
  EXPECT_EQ(correction.degrees_of_freedom, 8);
  EXPECT_EQ(correction.full.certificates[0].num_parameters, 8);
  EXPECT_EQ(correction.full.certificates[0].rank, 8);
}

// A constant load, and whatever level a record begins at, say nothing.
TEST(OutputErrorIntegratingTest, RampsOfRecordsChangeNothing) {
  std::vector<Record> records =
      MakeRecords(AgedLevel(), 400, 3, {.variance = 0.01});
  const auto plain = Correct(records);
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (int k = 0; k < records[r].samples(); ++k) {
      records[r].outputs(0, k) += 7.0 - (r == 0 ? 0.03 : 0.06) * k;
    }
  }
  const auto sloped = Correct(records);
  for (int j = 0; j < 3; ++j) {
    const ElementEstimate& a = plain.full.element(0, j);
    const ElementEstimate& b = sloped.full.element(0, j);
    // Both have converged to 1e-4 standard errors or so.
    EXPECT_NEAR(a.gain.value, b.gain.value, 1e-3 * a.gain.standard_error);
    EXPECT_NEAR(a.delay.value, b.delay.value, 1e-3 * a.delay.standard_error);
    EXPECT_NEAR(a.gain.standard_error, b.gain.standard_error,
                1e-3 * a.gain.standard_error);
  }
  EXPECT_NEAR(plain.statistic, sloped.statistic, 1e-3 * plain.statistic);
}

TEST(OutputErrorIntegratingTest, IntervalsHoldTheTruthAsOftenAsTheySay) {
  const ProcessModel plant = AgedLevel();
  int held = 0;
  int all = 0;
  int named = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto correction = Correct(
        MakeRecords(plant, 300, seed, {.variance = 0.02, .increment = 2e-4}));
    named += correction.aged(0, 0) && !correction.aged(0, 1) ? 1 : 0;
    for (int j = 0; j < 3; ++j) {
      const ElementEstimate& e = correction.full.element(0, j);
      const TransferFunction& g = plant.element(0, j);
      held += e.gain.lower <= g.StaticGain() && g.StaticGain() <= e.gain.upper;
      held += e.delay.lower <= g.delay() && g.delay() <= e.delay.upper;
      all += 2;
    }
  }
  // 95 % of 120; six standard deviations below.
  EXPECT_GE(held, all - 20);
  EXPECT_GE(named, 17);
}

TEST(OutputErrorIntegratingTest, NothingIsFoundWhereNothingHasAged) {
  int alarms = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto correction = Correct(
        MakeRecords(Level(), 300, seed, {.variance = 0.02, .increment = 2e-4}));
    alarms += correction.change_proposed ? 1 : 0;
  }
  // At a level of 1 %.
  EXPECT_LE(alarms, 2);
}

// Integrating outputs keep offset and ramp whatever is asked for.
TEST(OutputErrorIntegratingTest, HasOffsetsInAnyCase) {
  const std::vector<Record> records =
      MakeRecords(AgedLevel(), 400, 5, {.variance = 0.01, .offset = 30.0});
  OutputErrorOptions options;
  options.offsets = WindowOffsets::kNever;
  const ElementEstimate never = Correct(records, options).full.element(0, 0);
  options.offsets = WindowOffsets::kAlways;
  const ElementEstimate always = Correct(records, options).full.element(0, 0);
  EXPECT_EQ(never.gain.value, always.gain.value);
  EXPECT_NEAR(never.gain.value, -0.26, 5.0 * never.gain.standard_error);
}

TEST(OutputErrorIntegratingTest, ExpectedOutputsFollowALevelThatRamps) {
  Record record = MakeRecord(Level(), 300, 4, {.variance = 1e-4});
  for (int k = 0; k < record.samples(); ++k) record.outputs(0, k) += 0.2 * k;
  NoiseEstimate noise;
  noise.variance = 1e-4;
  const auto expected = ExpectedOutputs(Level(), {noise}, record);
  ASSERT_TRUE(expected.ok()) << expected.status();
  // Five standard deviations of the noise.
  EXPECT_LT((*expected - record.outputs).cwiseAbs().maxCoeff(), 0.05);
}

}  // namespace
}  // namespace mle
