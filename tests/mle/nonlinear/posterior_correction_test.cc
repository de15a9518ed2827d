#include "mle/nonlinear/posterior_correction.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_correction.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using Eigen::VectorXd;

constexpr int kSamples = 120;  // of step responses
constexpr RecordNoise kNoise = {.variance = 1e-2};

// 2 (3 s + 1) / ((8 s + 1)(1.5 s + 1)) e^{−s}: the same gain as before.
ProcessModel WithLead() {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction({6.0, 2.0}, {12.0, 9.5, 1.0}, 1.0);
  return plant;
}

struct Case {
  OutputErrorCorrection output_error;
  PosteriorCorrection posterior;
};

Case Complete(const ProcessModel& model, const std::vector<Record>& records,
              const OutputErrorOptions& options = {}) {
  const auto output_error = CorrectByOutputError(model, records, options);
  EXPECT_TRUE(output_error.ok()) << output_error.status();
  const auto posterior =
      CompleteByPosterior(model, records, output_error->corrected, options);
  EXPECT_TRUE(posterior.ok()) << posterior.status();
  return {*output_error, *posterior};
}

double Distance(const ProcessModel& model, const ProcessModel& plant) {
  return SquaredDistance(model.ComputeStepResponse(0.5, kSamples),
                         plant.ComputeStepResponse(0.5, kSamples));
}

// Right or with other gains, the structure suffices and stands bit for bit.
TEST(PosteriorCorrectionTest, LeavesTheStructureWhereItSuffices) {
  ProcessModel aged = TwoElements();
  aged.element(0, 1) = TransferFunction::FirstOrder(-4.5, 8.0, 3.0);
  for (const ProcessModel& plant : {TwoElements(), aged}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const auto [output_error, posterior] =
          Complete(TwoElements(), MakeRecords(plant, 500, seed, kNoise));
      EXPECT_FALSE(posterior.any()) << "seed " << seed;
      EXPECT_EQ(Distance(posterior.model, output_error.corrected.model), 0.0);
    }
  }
}

TEST(PosteriorCorrectionTest, FindsTheElementOfAnotherShape) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto [output_error, posterior] =
        Complete(TwoElements(), MakeRecords(WithLead(), 500, seed, kNoise));
    ASSERT_TRUE(posterior.outputs[0].needed) << "seed " << seed;
    const auto& elements = posterior.outputs[0].elements;
    EXPECT_TRUE(elements[0].reshaped);
    EXPECT_GT(elements[0].shape_probability, 0.99);
    EXPECT_FALSE(elements[1].changed);
    EXPECT_EQ(posterior.model.element(0, 1).numerator(),
              TwoElements().element(0, 1).numerator());
    // Of the structure alone 1.5 are left on average, of the model 2.0.
    EXPECT_LT(Distance(posterior.model, WithLead()), 0.05);
    EXPECT_GT(Distance(output_error.corrected.model, WithLead()), 0.05);
    EXPECT_LT(elements[0].reduction_error, 0.01);
  }
}

// Of the points of the changed element's response over many records.
TEST(PosteriorCorrectionTest, BandsHoldTheTruth) {
  const VectorXd truth =
      WithLead().ComputeStepResponse(0.5, kSamples).element(0, 0);
  double held = 0.0;
  double points = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto [output_error, posterior] =
        Complete(TwoElements(), MakeRecords(WithLead(), 500, seed, kNoise));
    if (!posterior.any()) continue;
    const VectorXd mean = posterior.MeanStep(TwoElements(), 0, 0, kSamples);
    const VectorXd errors = posterior.StepErrors(TwoElements(), 0, 0, kSamples);
    for (int k = 4; k < kSamples; k += 4) {
      held += std::abs(mean(k) - truth(k)) < 1.96 * errors(k) ? 1.0 : 0.0;
      points += 1.0;
    }
  }
  // Points of one response are not independent.
  EXPECT_GT(held / points, 0.90);
  EXPECT_LT(held / points, 0.99);
  EXPECT_GE(points, 10 * 29.0);
}

// A drum's level, which water swells: steam and a settling element beside it.
ProcessModel Drum() {
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::Integrator(0.3, 2.0, 1.0);
  model.element(0, 1) = TransferFunction::Integrator(-0.3, 0.0, 0.5);
  return model;
}

// 0.3 e^{−s} / (s (2 s + 1)) − 1.5 e^{−s} / (4 s + 1): the same slope as
// before, to which the level falls at first.
ProcessModel ShrinkingDrum() {
  ProcessModel plant = Drum();
  plant.element(0, 0) =
      TransferFunction({-3.0, -0.3, 0.3}, {8.0, 6.0, 1.0, 0.0}, 1.0);
  return plant;
}

TEST(PosteriorCorrectionTest, LeavesLevelsWhereTheirStructureSuffices) {
  ProcessModel aged = Drum();
  aged.element(0, 1) = TransferFunction::Integrator(-0.2, 0.0, 1.5);
  for (const ProcessModel& plant : {Drum(), aged}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const auto [output_error, posterior] =
          Complete(Drum(), MakeRecords(plant, 500, seed, kNoise));
      EXPECT_FALSE(posterior.any()) << "seed " << seed;
    }
  }
}

TEST(PosteriorCorrectionTest, FindsWhatALevelDoesBesideItsRamp) {
  const VectorXd truth =
      ShrinkingDrum().ComputeStepResponse(0.5, kSamples).element(0, 0);
  double held = 0.0;
  double points = 0.0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    auto [output_error, posterior] =
        Complete(Drum(), MakeRecords(ShrinkingDrum(), 500, seed, kNoise));
    ASSERT_TRUE(posterior.outputs[0].needed);
    const auto& elements = posterior.outputs[0].elements;
    EXPECT_TRUE(elements[0].reshaped);
    EXPECT_FALSE(elements[1].changed);
    const TransferFunction& found = posterior.model.element(0, 0);
    EXPECT_TRUE(found.IsIntegrating());
    EXPECT_LT(elements[0].reduction_error, 0.02);
    const double left = Distance(posterior.model, ShrinkingDrum());
    EXPECT_LT(left, 0.02 * Distance(Drum(), ShrinkingDrum()));
    EXPECT_LT(left,
              0.5 * Distance(output_error.corrected.model, ShrinkingDrum()));
    const VectorXd mean = posterior.MeanStep(Drum(), 0, 0, kSamples);
    const VectorXd errors = posterior.StepErrors(Drum(), 0, 0, kSamples);
    for (int k = 4; k < kSamples; k += 4) {
      held += std::abs(mean(k) - truth(k)) < 1.96 * errors(k) ? 1.0 : 0.0;
      points += 1.0;
    }
    posterior.Describe(Drum(), 0.95, output_error);
    const ParameterEstimate& slope = output_error.corrected.element(0, 0).gain;
    EXPECT_NEAR(slope.value, found.StaticGain(), 1e-9);
    // Held, where h alone explains the records.
    EXPECT_NEAR(slope.value, 0.3, 5.0 * slope.standard_error + 1e-12);
    EXPECT_LT(slope.standard_error, 0.01);
  }
  EXPECT_GT(held / points, 0.88);
}

// A pair that the model has not becomes present, with its gain.
TEST(PosteriorCorrectionTest, AddsAPairThatIsAbsent) {
  ProcessModel model = TwoElements();
  model.element(0, 1) = TransferFunction();
  ProcessModel plant = model;
  plant.element(0, 1) = TransferFunction::FirstOrder(-0.5, 3.0, 2.0);
  auto [output_error, posterior] =
      Complete(model, MakeRecords(plant, 500, 5, kNoise));
  ASSERT_TRUE(posterior.any());
  const auto& elements = posterior.outputs[0].elements;
  EXPECT_FALSE(elements[0].changed);
  EXPECT_TRUE(elements[1].reshaped);
  EXPECT_GT(elements[1].shape_probability, 0.99);
  EXPECT_LT(Distance(posterior.model, plant), 0.1 * Distance(model, plant));
  posterior.Describe(model, 0.95, output_error);
  EXPECT_TRUE(output_error.aged(0, 1));
  const ParameterEstimate& gain = output_error.corrected.element(0, 1).gain;
  EXPECT_EQ(gain.initial, 0.0);
  EXPECT_LT(gain.lower, -0.5);
  EXPECT_GT(gain.upper, -0.5);
}

// An input that does not move says nothing of its element.
TEST(PosteriorCorrectionTest, KeepsWhatRecordsAreSilentAbout) {
  auto records = MakeRecords(WithLead(), 500, 2, kNoise);
  for (Record& record : records) {
    const double still = record.inputs(1, 0);
    const auto quiet =
        MakeRecord(WithLead(), 500, 2, {}, 100);  // only for its size
    ASSERT_EQ(quiet.samples(), record.samples());
    record.inputs.row(1).setConstant(still);
  }
  const auto [output_error, posterior] = Complete(TwoElements(), records);
  if (!posterior.any()) return;
  EXPECT_FALSE(posterior.outputs[0].elements[1].changed);
}

TEST(PosteriorCorrectionTest, DescribesTheNearestElement) {
  auto [output_error, posterior] =
      Complete(TwoElements(), MakeRecords(WithLead(), 500, 1, kNoise));
  ASSERT_TRUE(posterior.any());
  posterior.Describe(TwoElements(), 0.95, output_error);
  EXPECT_TRUE(output_error.aged(0, 0));
  EXPECT_FALSE(output_error.aged(0, 1));
  const ElementEstimate& element = output_error.corrected.element(0, 0);
  EXPECT_EQ(element.state, ElementState::kFitted);
  EXPECT_EQ(element.gain.initial, 2.0);
  EXPECT_NEAR(element.gain.value, 2.0, 5.0 * element.gain.standard_error);
  EXPECT_GT(element.time_scale.standard_error, 0.0);
  EXPECT_EQ(output_error.corrected.element(0, 1).gain.value, -3.0);
}

// The search for the nearest element may begin at one of which the response
// shows hardly anything; steps towards it are then of any size.
TEST(PosteriorCorrectionTest, TheNearestElementBeginsWithinTheResponse) {
  auto [output_error, posterior] =
      Complete(TwoElements(), MakeRecords(WithLead(), 500, 1, kNoise));
  ASSERT_TRUE(posterior.any());
  OutputShapes& shapes = posterior.outputs[0];
  const double span = posterior.sample_time * shapes.first_lags.back();
  ElementPosterior& element = shapes.elements[0];
  const VectorXd means = element.means;
  for (const double gain : {1e-9, 2.0}) {
    for (const double time_scale : {0.05, 4.0, 1e3}) {
      for (const double delay : {1.0, 0.9 * span, span - 0.01}) {
        element.values = {gain, time_scale, delay};
        element.means = means;
        element.means(0) -= gain;
        posterior.Describe(TwoElements(), 0.95, output_error);
        const ElementEstimate& e = output_error.corrected.element(0, 0);
        EXPECT_TRUE(std::isfinite(e.gain.value));
        EXPECT_TRUE(std::isfinite(e.time_scale.value));
        EXPECT_GE(e.delay.value, 0.0);
        EXPECT_LE(e.delay.value, span);
      }
    }
  }
}

TEST(PosteriorCorrectionTest, ThreadsDoNotMatter) {
  ProcessModel two = MakeModel(2, 2);
  ProcessModel plant = two;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      two.element(i, j) = TwoElements().element(0, j);
      plant.element(i, j) = WithLead().element(0, j);
    }
  }
  const auto records = MakeRecords(plant, 400, 3, kNoise);
  OutputErrorOptions options;
  const PosteriorCorrection one = Complete(two, records, options).posterior;
  options.threads = 2;
  const PosteriorCorrection more = Complete(two, records, options).posterior;
  ASSERT_TRUE(one.any());
  EXPECT_EQ(Distance(one.model, more.model), 0.0);
}

}  // namespace
}  // namespace mle
