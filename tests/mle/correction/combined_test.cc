#include "mle/correction/combined.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/correction/excitation.h"
#include "mle/correction/smoothed_correction.h"
#include "tests/mle/nonlinear/structured_records.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kSampleTime = 0.5;
constexpr int kSamples = 81;

// Two outputs that share their inputs; the second never ages.
ProcessModel Initial() {
  ProcessModel model = MakeModel(2, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3.0, 6.0, 2.3);
  model.element(1, 1) = TransferFunction::FirstOrder(1.0, 5.0, 0.7);
  return model;
}

absl::StatusOr<ConversionSummary> Convert(const ProcessModel& model) {
  ExcitationOptions excitation;
  excitation.sample_time = kSampleTime;
  excitation.duration = 4000.0;
  excitation.noise_variance = 1e-3;
  const auto record = SimulateExcitation(model, excitation);
  if (!record.ok()) return record.status();
  ConversionOptions options;
  options.order = 50;
  return ConvertToArx(*record, options);
}

CombinedOptions Options() {
  CombinedOptions options;
  options.correction.lambdas = *MakeLambdaGrid(1e-2, 1e-4);
  return options;
}

CombinedCorrection Correct(const std::vector<Record>& records) {
  auto structured = CorrectStructure(Initial(), records, Options().structured);
  EXPECT_TRUE(structured.ok()) << structured.status();
  auto combined = CompleteStructured(Initial(), *std::move(structured), records,
                                     Convert, Options());
  EXPECT_TRUE(combined.ok()) << combined.status();
  return *std::move(combined);
}

double Distance(const ProcessModel& plant, const StepResponse& response) {
  return SquaredDistance(plant.ComputeStepResponse(kSampleTime, kSamples),
                         response);
}

// ΔR by itself, around the initial model.
double ArxDistance(const ProcessModel& plant,
                   const std::vector<Record>& records) {
  const auto conversion = Convert(Initial());
  EXPECT_TRUE(conversion.ok()) << conversion.status();
  const auto correction =
      CorrectModel(conversion->model, records, Options().correction);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return Distance(plant, correction->Model().ComputeStepResponse(kSamples));
}

TEST(CombinedCorrectionTest, LeavesNothingToCorrectWhereTheStructureIsRight) {
  ProcessModel plant = Initial();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 4.0, 2.2);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto records = MakeRecords(plant, 700, seed, {.variance = 1e-3});
    const CombinedCorrection combined = Correct(records);
    EXPECT_TRUE(combined.change_proposed());
    EXPECT_TRUE(combined.adequacy.adequate);
    EXPECT_FALSE(combined.correction.has_value());
    EXPECT_EQ(combined.ComputeStepResponse(kSampleTime, kSamples).values,
              combined.structured.corrected.model
                  .ComputeStepResponse(kSampleTime, kSamples)
                  .values);
  }
}

TEST(CombinedCorrectionTest, ProposesNothingWhereNothingHasChanged) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto records = MakeRecords(Initial(), 700, seed, {.variance = 1e-3});
    const CombinedCorrection combined = Correct(records);
    EXPECT_FALSE(combined.change_proposed());
    EXPECT_EQ(Distance(Initial(),
                       combined.ComputeStepResponse(kSampleTime, kSamples)),
              0.0);
  }
}

// One element has become of second order with a lead, or one has appeared:
// better than either part by itself, and the other output is left alone.
TEST(CombinedCorrectionTest, TakesUpWhatTheStructureCannot) {
  std::vector<ProcessModel> plants(2, Initial());
  // 2 (−2s + 1) / ((4s + 1)(3s + 1))
  plants[0].element(0, 0) =
      TransferFunction({-4.0, 2.0}, {12.0, 7.0, 1.0}, 1.0);
  plants[1].element(1, 0) = TransferFunction::FirstOrder(0.7, 3.0, 1.5);
  for (int i = 0; i < 2; ++i) {
    const ProcessModel& plant = plants[i];
    const auto records = MakeRecords(plant, 1500, 21, {.variance = 1e-3});
    const CombinedCorrection combined = Correct(records);
    ASSERT_TRUE(combined.correction.has_value());
    EXPECT_THAT(combined.outputs_corrected, ElementsAre(i == 0, i == 1));
    const StepResponse response =
        combined.ComputeStepResponse(kSampleTime, kSamples);
    const StepResponse structured =
        combined.structured.corrected.model.ComputeStepResponse(kSampleTime,
                                                                kSamples);
    EXPECT_EQ(response.element(1 - i, 1), structured.element(1 - i, 1));
    const double E = Distance(plant, response);
    EXPECT_LT(E, 0.5 * Distance(plant, structured)) << "plant " << i;
    EXPECT_LT(E, 1.1 * ArxDistance(plant, records)) << "plant " << i;
  }
}

// The same ΔR by the other engine.
TEST(CombinedCorrectionTest, CeresAgreesWithTheExactEngine) {
  ProcessModel plant = Initial();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 4.0, 2.2);
  const auto records = MakeRecords(plant, 700, 2, {.variance = 1e-3});
  const auto conversion = Convert(Initial());
  ASSERT_TRUE(conversion.ok());
  const auto exact =
      CorrectModel(conversion->model, records, Options().correction);
  ASSERT_TRUE(exact.ok());
  const auto smoothed =
      CorrectSmoothed(*exact, exact->selection().lambda_star, {});
  ASSERT_TRUE(smoothed.ok()) << smoothed.status();
  EXPECT_LE(smoothed->MaxRelativeGap(), 1e-9);
  EXPECT_LE((smoothed->model.R - exact->Model().R).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_THAT(std::string(CorrectSmoothed(*exact, Eigen::VectorXd::Zero(3), {})
                              .status()
                              .message()),
              HasSubstr("3 values of λ are given for 2 outputs"));
}

TEST(CombinedCorrectionTest, NamesWhatIsInvalid) {
  const auto records = MakeRecords(Initial(), 700, 1, {.variance = 1e-3});
  EXPECT_THAT(
      std::string(CompleteStructured(Initial(), {}, records, nullptr, Options())
                      .status()
                      .message()),
      HasSubstr("no conversion is given"));
  CombinedOptions options = Options();
  options.false_alarm_probability = 0.0;
  EXPECT_THAT(
      std::string(CompleteStructured(Initial(), {}, records, Convert, options)
                      .status()
                      .message()),
      HasSubstr("false_alarm_probability is 0"));
}

}  // namespace
}  // namespace mle
