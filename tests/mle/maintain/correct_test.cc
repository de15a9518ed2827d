#include "mle/maintain/correct.h"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/data/record_csv.h"
#include "mle/mle.h"
#include "tests/mle/base/scratch_folder.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;
using testing::TankRecord;

CorrectOptions Fast() {
  CorrectOptions options;
  options.estimation.estimator = Estimator::kOutputError;
  options.make_arx = false;
  options.threads = 1;
  return options;
}

bool Mentions(const absl::Status& status, const std::string& word) {
  return std::string(status.message()).find(word) != std::string::npos;
}

TEST(CorrectFromRecordsTest, AnAgedGainIsCorrected) {
  const auto result =
      CorrectFromRecords(Tank(1.0), {TankRecord(Tank(1.6), 0.02, 1)}, Fast());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCorrected);
  ASSERT_TRUE(result->usable());
  ASSERT_EQ(result->fopdt.size(), 1);
  EXPECT_NEAR(result->fopdt[0].gain, 1.6, 4.0 * result->fopdt[0].gain_error);
  EXPECT_LT(result->fopdt[0].gain_error, 0.02);
  EXPECT_EQ(result->fopdt_model.element(0, 0).StaticGain(),
            result->fopdt[0].gain);
  // The response change is that of the gain, dead time and time constant being
  // kept.
  EXPECT_NEAR(result->change.elements(0, 0), 0.6, 0.02);
  EXPECT_TRUE(result->corrected_residuals[0].white());
  EXPECT_FALSE(result->initial_residuals[0].white());
}

// Windows of 50 min around the changes at 100 and 300 min; between and after
// them the tank is at rest.
TEST(CorrectFromRecordsTest, WhatLiesBetweenTheWindowsIsAtRest) {
  CorrectOptions options = Fast();
  options.records.windows.before = 20.0;
  options.records.windows.after = 50.0;
  const Record record = TankRecord(Tank(1.6), 0.02, 1);
  const auto result = CorrectFromRecords(Tank(1.0), {record, record}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_EQ(result->data.windows.size(), 4);
  int in_windows = 0;
  for (const SetPointWindow& window : result->data.windows) {
    in_windows += window.record.samples();
  }
  int at_rest = 0;
  for (const Record& rest : result->data.AtRest()) {
    at_rest += rest.samples();
    EXPECT_EQ(rest.set_points.row(0).minCoeff(),
              rest.set_points.row(0).maxCoeff());
    const auto first = static_cast<int>(std::lround(rest.start_time / 0.5));
    EXPECT_EQ(rest.outputs, record.outputs.middleCols(first, rest.samples()));
  }
  EXPECT_EQ(in_windows + at_rest, 2 * record.samples());
  const NoiseEstimate& noise = result->estimate.setting.noise[0];
  EXPECT_GT(noise.samples_at_rest, 0.8 * at_rest);
  EXPECT_LE(noise.samples_at_rest, at_rest);
  EXPECT_GE(noise.inflation, 1.0);
  EXPECT_EQ(result->decision, Decision::kCorrected);
  // No more of them than windows can use.
  options.records.windows.before = 5.0;
  options.records.windows.after = 10.0;
  options.records.windows.change_times = {300.0};
  const auto little = PrepareRecords({record}, Tank(1.0), options.records);
  ASSERT_TRUE(little.ok()) << little.status();
  ASSERT_EQ(little->windows.size(), 1);
  const std::vector<Record> rest = little->AtRest();
  ASSERT_EQ(rest.size(), 1);
  EXPECT_EQ(rest[0].samples(), 4 * little->windows[0].record.samples());
  EXPECT_EQ(rest[0].outputs, record.outputs.rightCols(rest[0].samples()));
}

// Two windows that meet say as much as one that holds both changes.
TEST(CorrectFromRecordsTest, WindowsThatMeetAreFittedAsOne) {
  CorrectOptions options = Fast();
  options.records.windows.before = 150.0;
  options.records.windows.after = 150.0;
  const Record record = TankRecord(Tank(1.2), 0.1, 1);
  const auto two = CorrectFromRecords(Tank(1.0), {record}, options);
  ASSERT_TRUE(two.ok()) << two.status();
  ASSERT_EQ(two->data.windows.size(), 2);
  options.records.windows.join_within = 1000.0;
  const auto one = CorrectFromRecords(Tank(1.0), {record}, options);
  ASSERT_TRUE(one.ok()) << one.status();
  ASSERT_EQ(one->data.windows.size(), 1);
  ASSERT_EQ(two->data.windows[0].record.samples() +
                two->data.windows[1].record.samples(),
            one->data.windows[0].record.samples());
  const auto gain = [](const CorrectionResult& result) {
    return result.estimate.fit.output_error.full.element(0, 0).gain;
  };
  EXPECT_EQ(gain(*two).value, gain(*one).value);
  EXPECT_EQ(gain(*two).standard_error, gain(*one).standard_error);
  EXPECT_EQ(two->initial_residuals[0].variance,
            one->initial_residuals[0].variance);
  // They are held out, and reported, as two.
  EXPECT_EQ(two->validation.windows.size(), 2);
  EXPECT_EQ(two->decision, Decision::kCorrected);
}

// An experiment without a controller: a whole record, in which the input moves
// at every sample, is held out in parts.
TEST(CorrectFromRecordsTest, AnExperimentWithoutSetPointsIsCorrected) {
  Record record = TankRecord(Tank(1.0), 0.02, 1);
  record.set_points.setZero();
  for (int k = 0; k < record.samples(); ++k) {
    record.inputs(0, k) = std::sin(0.031 * k) + std::sin(0.17 * k + 1.0);
  }
  record.outputs = *SimulateResponse(Tank(1.5), 0.5, record.inputs) +
                   GaussianNoise(1, 0, kMeasurementNoise)
                       .DrawMatrix(1, record.samples(), 0.05);
  const auto result = CorrectFromRecords(Tank(1.0), {record}, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->validation.held_out) << result->validation.missing;
  EXPECT_EQ(result->decision, Decision::kCorrected);
  EXPECT_NEAR(result->model.element(0, 0).StaticGain(), 1.5, 0.03);
}

TEST(CorrectFromRecordsTest, ARightModelIsKeptToTheLastDigit) {
  const auto result =
      CorrectFromRecords(Tank(1.6), {TankRecord(Tank(1.6), 0.02, 1)}, Fast());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kNoChange);
  EXPECT_EQ(result->change.total, 0.0);
  EXPECT_EQ(result->corrected.process->element(0, 0).StaticGain(), 1.6);
  ASSERT_EQ(result->reasons.size(), 1);
  EXPECT_EQ(result->reasons[0].code, MessageCode::kNoChangeFound);
}

TEST(CorrectFromRecordsTest, WindowsThatDisagreeCannotTell) {
  const auto result = CorrectFromRecords(
      Tank(1.5),
      {TankRecord(Tank(3.0), 0.02, 1), TankRecord(Tank(1.3), 0.02, 2)}, Fast());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCannotTell);
  EXPECT_EQ(result->change.total, 0.0);
  // The estimate is there to be looked at.
  EXPECT_TRUE(result->estimate.fit.output_error.aged(0, 0));
}

TEST(CorrectFromRecordsTest, AChangeBelowTheThresholdIsNoChange) {
  CorrectOptions options = Fast();
  const std::vector<Record> records = {TankRecord(Tank(1.03), 0.002, 1),
                                       TankRecord(Tank(1.03), 0.002, 2)};
  options.decision.least_change = 0.05;
  const auto small = CorrectFromRecords(Tank(1.0), records, options);
  ASSERT_TRUE(small.ok()) << small.status();
  EXPECT_EQ(small->decision, Decision::kNoChange);
  EXPECT_EQ(small->reasons.front().code, MessageCode::kChangeTooSmall);
  EXPECT_EQ(small->change.total, 0.0);
  options.decision.least_change = 0.01;
  const auto large = CorrectFromRecords(Tank(1.0), records, options);
  ASSERT_TRUE(large.ok()) << large.status();
  EXPECT_EQ(large->decision, Decision::kCorrected);
  EXPECT_NEAR(large->change.elements(0, 0), 0.03, 0.005);
}

TEST(CorrectFromRecordsTest, AChangeOfArxBelowTheThresholdIsNoChangeToo) {
  CorrectOptions options = Fast();
  options.estimation.estimator = Estimator::kArx;
  options.estimation.conversion.samples = 20000;
  options.decision.least_change = 0.5;
  const auto result = CorrectFromRecords(
      Tank(1.0),
      {TankRecord(Tank(1.2), 0.01, 1), TankRecord(Tank(1.2), 0.01, 2)},
      options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kNoChange);
  EXPECT_EQ(result->reasons.front().code, MessageCode::kChangeTooSmall);
  EXPECT_FALSE(ProposesChange(result->estimate, 0));
  EXPECT_EQ(result->change.total, 0.0);
}

ProcessModel TwoInputs() {
  return ProcessModel("tank", "min", {{"valve", "%"}, {"heat", "%"}},
                      {{"level", "m"}});
}

// Two records of a plant like Tank with a second input, in white noise.
std::vector<Record> RecordsOfTwoInputs(const ProcessModel& plant) {
  std::vector<Record> records;
  for (const std::uint64_t seed : {1, 2}) {
    Record record = TankRecord(Tank(1.0), 0.02, seed);
    const Eigen::MatrixXd noise =
        record.outputs - *SimulateResponse(Tank(1.0), 0.5, record.inputs);
    record.inputs.conservativeResize(2, Eigen::NoChange);
    record.inputs.row(1).setZero();
    record.inputs.row(1).segment(300, 100).setOnes();
    record.inputs.row(1).segment(650, 30).setConstant(-1.0);
    record.outputs = *SimulateResponse(plant, 0.5, record.inputs) + noise;
    records.push_back(record);
  }
  return records;
}

// A pair that the model has not becomes present.
TEST(CorrectFromRecordsTest, WhatNoParameterExplainsIsAShape) {
  ProcessModel model = TwoInputs();
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 1.5);
  ProcessModel plant = model;
  plant.element(0, 1) = TransferFunction::FirstOrder(0.5, 5.0, 1.5);
  const std::vector<Record> records = RecordsOfTwoInputs(plant);
  CorrectOptions options = Fast();
  const auto result = CorrectFromRecords(model, records, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCorrected);
  EXPECT_LT(PValue(*result), 0.01);
  EXPECT_NEAR(result->model.element(0, 1).StaticGain(), 0.5, 0.05);
  EXPECT_EQ(result->model.element(0, 0).StaticGain(), 1.0);
  EXPECT_LT(CompareResponses(result->corrected.response,
                             plant.ComputeStepResponse(
                                 0.5, result->corrected.response.samples()))
                .total,
            0.2);
}

// Dead times of a whole row that are 1 min longer: a clock, or the plant.
TEST(CorrectFromRecordsTest, WhatAClockMayHaveDoneCannotTell) {
  ProcessModel model = TwoInputs();
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 1.5);
  model.element(0, 1) = TransferFunction::FirstOrder(0.8, 8.0, 2.5);
  ProcessModel late = model;
  late.element(0, 0).set_delay(2.5);
  late.element(0, 1).set_delay(3.5);
  ProcessModel aged = late;
  aged.element(0, 1) = TransferFunction::FirstOrder(0.5, 8.0, 3.5);
  CorrectOptions options = Fast();
  const auto clock =
      CorrectFromRecords(model, RecordsOfTwoInputs(late), options);
  ASSERT_TRUE(clock.ok()) << clock.status();
  EXPECT_EQ(clock->decision, Decision::kCannotTell);
  EXPECT_EQ(clock->reasons.back().code, MessageCode::kClock);
  EXPECT_NE(clock->reasons.back().text.find("min longer"), std::string::npos)
      << clock->reasons.back().text;
  EXPECT_EQ(clock->change.total, 0.0);
  // Tags may wait for a scan: five samples of half a minute.
  options.decision.clock_error = 1.0;
  const auto scan =
      CorrectFromRecords(model, RecordsOfTwoInputs(late), options);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_EQ(scan->reasons.back().code, MessageCode::kClock);
  // What differs from it by no more than the errors is nothing besides.
  options.decision.least_change = 0.0;
  const auto errors =
      CorrectFromRecords(model, RecordsOfTwoInputs(late), options);
  ASSERT_TRUE(errors.ok()) << errors.status();
  EXPECT_EQ(errors->reasons.back().code, MessageCode::kClock);
  options.decision.least_change = DecisionOptions().least_change;
  // Where clocks are known to be right, they have changed.
  options.decision.clock_error = 0.0;
  const auto right =
      CorrectFromRecords(model, RecordsOfTwoInputs(late), options);
  ASSERT_TRUE(right.ok()) << right.status();
  EXPECT_EQ(right->decision, Decision::kCorrected);
  EXPECT_NEAR(right->model.element(0, 0).delay(), 2.5, 0.1);
  EXPECT_NEAR(right->model.element(0, 1).delay(), 3.5, 0.1);
  // What has aged besides is delivered.
  options.decision.clock_error = DecisionOptions().clock_error;
  const auto both =
      CorrectFromRecords(model, RecordsOfTwoInputs(aged), options);
  ASSERT_TRUE(both.ok()) << both.status();
  EXPECT_EQ(both->decision, Decision::kCorrected);
  EXPECT_NEAR(both->model.element(0, 1).StaticGain(), 0.5, 0.02);
  EXPECT_EQ(both->model.element(0, 0).delay(), 1.5);
  EXPECT_NEAR(both->model.element(0, 1).delay(), 2.5, 0.1);
  EXPECT_NE(both->reasons.back().text.find("min longer"), std::string::npos)
      << both->reasons.back().text;
}

TEST(CorrectFromRecordsTest, FilesGiveTheSameAsMemory) {
  const ScratchFolder folder;
  const std::string model_path = folder / "tank.json";
  const std::string record_path = folder / "tank.csv";
  ASSERT_TRUE(WriteProcessModel(Tank(1.0), model_path).ok());
  const Record record = TankRecord(Tank(1.6), 0.02, 1);
  ASSERT_TRUE(WriteRecordCsv(record_path, record, Tank(1.0)).ok());
  const auto files = CorrectFromRecords(model_path, {record_path}, {}, Fast());
  ASSERT_TRUE(files.ok()) << files.status();
  const auto imported = ImportHistorian({record_path}, Tank(1.0), {});
  ASSERT_TRUE(imported.ok()) << imported.status();
  const auto memory = CorrectFromRecords(Tank(1.0), imported->records, Fast());
  ASSERT_TRUE(memory.ok()) << memory.status();
  EXPECT_EQ(files->decision, memory->decision);
  EXPECT_EQ(files->fopdt[0].gain, memory->fopdt[0].gain);
  EXPECT_EQ(files->estimate.fit.test.p_value,
            memory->estimate.fit.test.p_value);
}

TEST(CorrectFromRecordsTest, ArxModelsComeOutInTheUnitsOfTheRecords) {
  CorrectOptions options = Fast();
  options.make_arx = true;
  options.estimation.conversion.samples = 20000;
  const auto result =
      CorrectFromRecords(Tank(1.0), {TankRecord(Tank(1.6), 0.02, 1)}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  const StepResponse arx = result->corrected.arx.ComputeStepResponse(
      result->change.elements.size() ? 80 : 0);
  const StepResponse wanted =
      result->corrected.process->ComputeStepResponse(0.5, 80);
  EXPECT_NEAR(arx.element(0, 0)(79), wanted.element(0, 0)(79), 1e-9);
  EXPECT_LT(result->corrected.max_relative_gap, options.accepted_gap);
}

// Seconds for minutes: windows of the model's settling time are longer than the
// record, or its dead times and time constants shorter than a sample.
TEST(CorrectFromRecordsTest, AWrongTimeUnitIsAnAnswerNotAnError) {
  const Record record = TankRecord(Tank(1.0), 0.02, 1);
  for (const double factor : {60.0, 1.0 / 60.0}) {
    ProcessModel model = Tank(1.0);
    model.element(0, 0) =
        TransferFunction::FirstOrder(1.0, 5.0 * factor, 1.5 * factor);
    for (const Estimator estimator : AllEstimators()) {
      CorrectOptions options = Fast();
      options.estimation.estimator = estimator;
      const auto result = CorrectFromRecords(model, {record}, options);
      ASSERT_TRUE(result.ok()) << factor << ": " << result.status();
      EXPECT_EQ(result->decision, Decision::kCannotTell);
      EXPECT_EQ(result->reasons.front().code, MessageCode::kMistake);
      EXPECT_NE(result->reasons.front().text.find("time unit"),
                std::string::npos);
      EXPECT_EQ(result->change.total, 0.0);
    }
  }
}

// An element with feedthrough cannot be fitted: an error, unless the records
// could not be used anyway.
TEST(CorrectFromRecordsTest, AFitThatFailsBesideAnObstacleIsAnAnswer) {
  ProcessModel model = Tank(1.0);
  model.element(0, 0) = TransferFunction({1.0, 1.0}, {5.0, 1.0}, 1.5);
  auto data = PrepareRecords({TankRecord(model, 0.02, 1)}, model, {});
  ASSERT_TRUE(data.ok()) << data.status();
  const auto failed = CorrectFromData(model, *data, Fast());
  EXPECT_EQ(failed.status().code(), absl::StatusCode::kInvalidArgument);
  data->obstacles = {{MessageCode::kInputLimits, "valve", "At its limit.", {}}};
  const auto result = CorrectFromData(model, *data, Fast());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCannotTell);
  EXPECT_EQ(result->reasons.front().code, MessageCode::kInputLimits);
  EXPECT_EQ(result->change.total, 0.0);
}

TEST(CorrectFromRecordsTest, ProgressNamesEveryStageAndCanStop) {
  CorrectOptions options = Fast();
  std::vector<std::string> stages;
  options.progress = [&](const RunProgress& progress) {
    if (progress.fraction == 0.0) stages.push_back(progress.stage);
    EXPECT_GE(progress.fraction, 0.0);
    EXPECT_LE(progress.fraction, 1.0);
    return true;
  };
  const std::vector<Record> records = {TankRecord(Tank(1.6), 0.02, 1)};
  ASSERT_TRUE(CorrectFromRecords(Tank(1.0), records, options).ok());
  ASSERT_GE(stages.size(), 3);
  for (const std::string& last : stages) {
    options.progress = [&](const RunProgress& progress) {
      return progress.stage != last;
    };
    const auto stopped = CorrectFromRecords(Tank(1.0), records, options);
    EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled) << last;
    EXPECT_TRUE(Mentions(stopped.status(), last)) << stopped.status();
  }
}

TEST(CorrectFromRecordsTest, TheModelInUseIsTheRival) {
  CorrectOptions options = Fast();
  // A rival that knows every output: no correction predicts better.
  options.in_use = [](const Record& record, int) -> Eigen::MatrixXd {
    return Eigen::MatrixXd::Constant(record.num_outputs(), record.samples(),
                                     1e-6);
  };
  const auto result =
      CorrectFromRecords(Tank(1.0), {TankRecord(Tank(1.6), 0.02, 1)}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCannotTell);
}

// Nobody has asked for a horizon of the step responses that is too short.
TEST(CorrectFromRecordsTest, AModelFasterThanASampleHasStepResponses) {
  const auto fast = [](double gain) {
    ProcessModel model = Tank(1.0);
    model.element(0, 0) = TransferFunction::FirstOrder(gain, 1e-3, 0.5);
    return model;
  };
  CorrectOptions options = Fast();
  options.records.windows.before = 20.0;
  options.records.windows.after = 50.0;
  const auto result =
      CorrectFromRecords(fast(1.0), {TankRecord(fast(1.6), 0.02, 1)}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->initial_response.samples(), 5);
}

TEST(CorrectFromRecordsTest, WrongArgumentsAreNamed) {
  const Record record = TankRecord(Tank(1.6), 0.02, 1);
  const auto message = [&](const ProcessModel& model,
                           const std::vector<Record>& records,
                           const CorrectOptions& options) {
    const auto result = CorrectFromRecords(model, records, options);
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    return result.status();
  };
  CorrectOptions options = Fast();
  options.response_horizon = -1.0;
  EXPECT_TRUE(
      Mentions(message(Tank(1.0), {record}, options), "response_horizon"));
  options = Fast();
  options.accepted_gap = 0.0;
  EXPECT_TRUE(Mentions(message(Tank(1.0), {record}, options), "accepted_gap"));
  options = Fast();
  options.threads = -1;
  EXPECT_TRUE(Mentions(message(Tank(1.0), {record}, options), "threads"));
  options = Fast();
  options.estimation.change_test = ChangeTest::kAdequacy;
  EXPECT_TRUE(Mentions(message(Tank(1.0), {record}, options), "change_test"));
  options = Fast();
  options.estimation.output_error.confidence = 2.0;
  EXPECT_TRUE(Mentions(message(Tank(1.0), {record}, options), "confidence"));

  EXPECT_TRUE(Mentions(message(Tank(1.0), {}, Fast()), "records"));
  Record quiet = record;
  quiet.set_points.setZero();
  quiet.inputs.setZero();
  EXPECT_TRUE(Mentions(message(Tank(1.0), {quiet}, Fast()), "change_times"));
  Record slower = record;
  slower.sample_time = 1.0;
  EXPECT_TRUE(
      Mentions(message(Tank(1.0), {record, slower}, Fast()), "record 2"));
  Record wide = record;
  wide.inputs = Eigen::MatrixXd::Zero(2, record.samples());
  EXPECT_TRUE(Mentions(message(Tank(1.0), {wide}, Fast()), "2 inputs"));
  const ProcessModel nothing("nothing", "min", {{"valve", ""}},
                             {{"level", ""}});
  EXPECT_TRUE(Mentions(message(nothing, {record}, Fast()), "nothing"));
}

TEST(CorrectFromRecordsTest, WhatIsFoundInTheRecordsIsData) {
  Record record = TankRecord(Tank(1.6), 0.02, 1);
  record.inputs(0, 560) = std::nan("");
  record.inputs(0, 561) = std::nan("");
  const auto result = CorrectFromRecords(Tank(1.0), {record}, Fast());
  ASSERT_TRUE(result.ok()) << result.status();
  bool found = false;
  for (const Message& warning : result->warnings) {
    if (warning.code != MessageCode::kWindowCut &&
        warning.code != MessageCode::kWindowDropped) {
      continue;
    }
    found = true;
    EXPECT_FALSE(warning.place.empty());
    EXPECT_EQ(warning.options, std::vector<std::string>{"max_gap"});
  }
  EXPECT_TRUE(found);
}

TEST(EstimatorTest, NamesAreReadBack) {
  for (const Estimator estimator : AllEstimators()) {
    const auto parsed = ParseEstimator(NameOf(estimator));
    ASSERT_TRUE(parsed.ok());
    EXPECT_EQ(*parsed, estimator);
  }
  const absl::Status unknown = ParseEstimator("arx2").status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  for (const Estimator estimator : AllEstimators()) {
    EXPECT_TRUE(Mentions(unknown, std::string(NameOf(estimator))));
  }
}

}  // namespace
}  // namespace mle
