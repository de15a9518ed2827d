#include "mle/maintain/examine_records.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/operation.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/exchanged_set_points.h"
#include "tests/mle/data/loop_records.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using testing::LoopModel;
using testing::LoopRecord;
using ::testing::Not;

std::vector<Finding> Examine(Record& record,
                             const ExamineOptions& options = {}) {
  std::vector<Record> records = {record};
  std::vector<Finding> findings =
      *ExamineRecords(LoopModel(), options, records);
  record = records.front();
  return findings;
}

int Bad(const Eigen::MatrixXd& rows, int row) {
  return static_cast<int>(rows.row(row).array().isNaN().count());
}

TEST(ExamineRecordsTest, FindsNothingInRightRecords) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const double walk : {0.0, 0.003}) {
      for (const double quantum : {0.0, 0.05}) {
        Record record = LoopRecord({.walk = walk, .seed = seed});
        if (quantum > 0.0) testing::Quantise(quantum, record.outputs);
        const Record before = record;
        EXPECT_TRUE(Examine(record).empty());
        EXPECT_EQ(record.outputs, before.outputs);
        EXPECT_EQ(record.inputs, before.inputs);
      }
    }
  }
}

TEST(ExamineRecordsTest, SetPointsUnderEachOthersTagsAreTakenSo) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Record right = LoopRecord({.walk = 0.002, .seed = seed});
    Record record = right;
    record.set_points.row(0).swap(record.set_points.row(1));
    const std::vector<Finding> findings = Examine(record);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].message.code, MessageCode::kMistake);
    EXPECT_EQ(findings[0].consequence, Consequence::kRepair);
    EXPECT_GT(findings[0].value, 10.0);
    EXPECT_EQ(record.set_points, right.set_points);
  }
  // Not where outputs do not settle, nor where one set point moves.
  Record open = LoopRecord();
  open.set_points.row(0).swap(open.set_points.row(1));
  open.outputs = Eigen::MatrixXd::Random(2, 4000);
  EXPECT_TRUE(FindExchangedSetPoints({open}).empty());
  Record one = LoopRecord();
  one.set_points.row(1).setZero();
  EXPECT_TRUE(FindExchangedSetPoints({one}).empty());
  // An output that follows another's set point, as in a cascade.
  one.outputs.row(1) = one.outputs.row(0);
  EXPECT_TRUE(FindExchangedSetPoints({one}).empty());
}

TEST(ExamineRecordsTest, UsesArchivedSamplesOnly) {
  Record record = LoopRecord();
  Eigen::RowVectorXd row = record.outputs.row(0);
  const int kept = testing::Compress(0.02, row);
  ASSERT_GT(kept, 1000);
  record.outputs.row(0) = row;
  const std::vector<Finding> findings = Examine(record);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].message.code, MessageCode::kCompressed);
  EXPECT_EQ(findings[0].message.place, "y1");
  EXPECT_EQ(findings[0].consequence, Consequence::kRepair);
  EXPECT_NEAR(findings[0].value, kept / 4000.0, 0.01);
  EXPECT_NEAR(Bad(record.outputs, 0), 4000 - kept, 80);
  EXPECT_EQ(Bad(record.outputs, 1), 0);
  EXPECT_EQ(FirstBlocking(findings), nullptr);
}

// Outputs that change slowly repeat values at their declared period, which what
// is found would not keep.
TEST(ExamineRecordsTest, WhatIsDeclaredTakesThePlaceOfWhatIsFound) {
  constexpr int kPeriod = 20;
  Record held = LoopRecord();
  for (int k = 0; k < held.samples(); ++k) {
    held.outputs(0, k) = held.outputs(0, k - k % kPeriod);
  }
  testing::Quantise(0.5, held.outputs);
  ExamineOptions options;
  options.tags = {
      {LoopModel().outputs()[0].name, LoopModel().outputs()[0].name}};
  options.tags[0].sampling =
      Sampling{.period = kPeriod * held.sample_time, .held = true};
  Record record = held;
  const std::vector<Finding> findings = Examine(record, options);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings[0].message.code, MessageCode::kCompressed);
  EXPECT_EQ(findings[0].consequence, Consequence::kRepair);
  EXPECT_EQ(Bad(record.outputs, 0), held.samples() - held.samples() / kPeriod);
  // Values that are known not to be held are all taken.
  options.tags[0].sampling->held = false;
  record = held;
  Examine(record, options);
  EXPECT_EQ(Bad(record.outputs, 0), 0);
}

// Between archived values an input was where the straight line says, within the
// historian's deviation. Where outputs are compressed, too, the lines are no
// ramps.
TEST(ExamineRecordsTest, CompressedInputsAreNoted) {
  Record record = LoopRecord({.period = 1});
  Eigen::RowVectorXd input = record.inputs.row(1);
  testing::Compress(0.01, input);
  record.inputs.row(1) = input;
  std::vector<Finding> findings = Examine(record);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].consequence, Consequence::kNote);
  EXPECT_THAT(findings[0].message.text, HasSubstr("ramps"));

  Eigen::RowVectorXd output = record.outputs.row(0);
  testing::Compress(0.04, output);
  record.outputs.row(0) = output;
  findings = Examine(record);
  EXPECT_EQ(FirstBlocking(findings), nullptr);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].message.place, "y1");
  EXPECT_LT(findings[0].value, 0.1);
  EXPECT_EQ(findings[1].message.place, "u2");
  EXPECT_EQ(findings[1].consequence, Consequence::kNote);
  EXPECT_THAT(findings[1].message.text, Not(HasSubstr("ramps")));
}

TEST(ExamineRecordsTest, ReplacesSpikes) {
  for (const bool repair : {true, false}) {
    Record record = LoopRecord();
    const double usual = record.inputs(0, 1230);
    record.inputs(0, 1230) = 9.0;
    const std::vector<Finding> findings = Examine(record, {.repair = repair});
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].message.code, MessageCode::kInputSpikes);
    EXPECT_EQ(findings[0].from, record.time(1230));
    EXPECT_EQ(record.inputs(0, 1230), repair ? usual : 9.0);
  }
}

// A controller's kick looks like a spike, but the outputs answer it, whether or
// not set points are recorded.
TEST(ExamineRecordsTest, LeavesKicksThatTheOutputsAnswer) {
  for (const auto& [gain, set_points] :
       {std::pair(1.0, false), {0.7, false}, {1.5, false}, {1.0, true}}) {
    const ProcessModel model = testing::LoopModel();
    ProcessModel plant = model;
    plant.element(1, 1) = TransferFunction::FirstOrder(-3.0 * gain, 12.0, 2.0);
    Record record;
    record.sample_time = 0.25;
    record.inputs = LoopRecord().inputs;
    record.inputs(1, 1230) += 3.0;  // the plant sees it
    record.outputs = *SimulateResponse(plant, 0.25, record.inputs);
    for (int k = 0; k < record.samples(); ++k) {
      record.outputs(0, k) += 0.02 * std::sin(2.39996 * k * k);
      record.outputs(1, k) += 0.02 * std::sin(1.7 * k * k);
    }
    if (set_points) record.set_points = 0.0 * record.outputs;
    const double kick = record.inputs(1, 1230);
    const double usual = record.inputs(1, 2230);
    record.inputs(1, 2230) += 3.0;  // the record alone has it
    const std::vector<Finding> findings = Examine(record);
    EXPECT_EQ(record.inputs(1, 1230), kick) << gain;
    EXPECT_EQ(record.inputs(1, 2230), usual) << gain;
    ASSERT_EQ(findings.size(), 2u) << gain;
    EXPECT_EQ(findings[0].message.code, MessageCode::kInputSpikes);
    EXPECT_EQ(findings[0].consequence, Consequence::kRepair);
    EXPECT_EQ(findings[0].from, record.time(2230));
    EXPECT_EQ(findings[1].consequence, Consequence::kNote);
    EXPECT_EQ(findings[1].from, record.time(1230));
  }
}

TEST(ExamineRecordsTest, ADeadSensorSaysNothingOfItsOutputAlone) {
  Record record = LoopRecord();
  record.outputs.row(1).setConstant(3.0);
  const std::vector<Finding> findings = Examine(record);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].message.code, MessageCode::kStuckOutput);
  EXPECT_EQ(findings[0].consequence, Consequence::kDoubts);
  EXPECT_EQ(findings[0].outputs, std::vector<int>{1});
  EXPECT_EQ(Bad(record.outputs, 0), 0);
  EXPECT_EQ(Bad(record.outputs, 1), record.samples());
}

TEST(ExamineRecordsTest, AClippedSensorIsRepaired) {
  Record record = LoopRecord();
  record.outputs.row(0) = record.outputs.row(0).cwiseMin(0.6);
  const std::vector<Finding> findings = Examine(record);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].consequence, Consequence::kRepair);
  EXPECT_EQ(Bad(record.outputs, 0), findings[0].value);
}

// The mistake comes first, whatever else there is.
TEST(ExamineRecordsTest, AMistakeBlocksFirst) {
  Record record = LoopRecord();
  record.inputs(0, 1230) = 9.0;
  record.inputs.row(0).swap(record.inputs.row(1));
  const std::vector<Finding> findings = Examine(record);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].message.code, MessageCode::kMistake);
  EXPECT_EQ(FirstBlocking(findings), &findings[0]);
  EXPECT_EQ(findings[1].message.code, MessageCode::kInputSpikes);
}

TEST(ExamineRecordsTest, NotesHowThePlantIsOperated) {
  Record record = LoopRecord({.noise = 0.2});
  record.inputs.row(0) = record.inputs.row(0).cwiseMin(0.5);
  for (int k = 0; k < record.samples(); ++k) {
    record.set_points(1, k) = 0.01 * (k / 10 * 7 % 11);
  }
  record.outputs = *SimulateResponse(LoopModel(), 0.25, record.inputs) +
                   0.02 * Eigen::MatrixXd::Random(2, record.samples());
  const std::vector<Finding> findings = Examine(record);
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].message.code, MessageCode::kInputLimits);
  EXPECT_EQ(findings[1].message.code, MessageCode::kManyMoves);
  EXPECT_EQ(FirstBlocking(findings), nullptr);
}

// The sun at night: what is only measured has no limits. Nor is a record worth
// nothing in which an input stands at a limit for most of the time.
TEST(ExamineRecordsTest, LimitsAreOfManipulatedInputsAndDoNotBlock) {
  Record record = LoopRecord({.noise = 0.2});
  record.inputs.row(0) =
      record.inputs.row(0).cwiseMax(record.inputs.row(0).maxCoeff() -
                                    0.3 * (record.inputs.row(0).maxCoeff() -
                                           record.inputs.row(0).minCoeff()));
  record.outputs = *SimulateResponse(LoopModel(), 0.25, record.inputs) +
                   0.02 * Eigen::MatrixXd::Random(2, record.samples());
  const std::vector<TimeAtLimits> limits = FindTimeAtLimits({record});
  ASSERT_EQ(limits.size(), 1u);
  ASSERT_GT(limits[0].share_low + limits[0].share_high, 0.5);
  for (const InputRole role :
       {InputRole::kManipulated, InputRole::kDisturbance}) {
    ProcessModel model = LoopModel();
    std::vector<InputChannel> inputs = model.inputs();
    inputs[0].role = role;
    ProcessModel with_role(model.name(), model.time_unit(), inputs,
                           model.outputs());
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) with_role.element(i, j) = model.element(i, j);
    }
    std::vector<Record> records = {record};
    const absl::StatusOr<std::vector<Finding>> findings =
        ExamineRecords(with_role, ExamineOptions(), records);
    ASSERT_TRUE(findings.ok()) << findings.status();
    EXPECT_EQ(FirstBlocking(*findings), nullptr);
    const bool is_noted = std::any_of(
        findings->begin(), findings->end(), [](const Finding& finding) {
          return finding.message.code == MessageCode::kInputLimits;
        });
    EXPECT_EQ(is_noted, role == InputRole::kManipulated);
  }
}

// What blocks decides, and is the first reason.
TEST(ExamineRecordsTest, AMistakeForbidsACorrection) {
  Record record = LoopRecord();
  record.inputs.row(0).swap(record.inputs.row(1));
  CorrectOptions options;
  options.estimation.estimator = Estimator::kOutputError;
  options.make_arx = false;
  const absl::StatusOr<CorrectionResult> result =
      CorrectFromRecords(LoopModel(), {record}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_FALSE(result->accepted());
  EXPECT_NE(result->decision, Decision::kNoChange);
  ASSERT_FALSE(result->reasons.empty());
  EXPECT_EQ(result->reasons.front().code, MessageCode::kMistake);
}

TEST(ExamineRecordsTest, FindingsDoNotDependOnThreads) {
  Record spike = LoopRecord();
  spike.inputs(0, 1230) = 9.0;
  Record exchanged = LoopRecord();
  exchanged.inputs.row(0).swap(exchanged.inputs.row(1));
  for (const Record& record : {spike, exchanged}) {
    ExamineOptions options;
    options.threads = 1;
    Record one = record;
    const std::vector<Finding> alone = Examine(one, options);
    ASSERT_FALSE(alone.empty());
    options.threads = 3;
    Record other = record;
    const std::vector<Finding> together = Examine(other, options);
    ASSERT_EQ(together.size(), alone.size());
    for (std::size_t f = 0; f < alone.size(); ++f) {
      EXPECT_EQ(together[f].message.text, alone[f].message.text);
      EXPECT_EQ(together[f].value, alone[f].value);
    }
    EXPECT_EQ(other.inputs, one.inputs);
  }
}

TEST(ExamineRecordsTest, ValidatesOptions) {
  EXPECT_TRUE(ExamineOptions().Validate().ok());
  EXPECT_FALSE(ExamineOptions{.threads = -1}.Validate().ok());
}

}  // namespace
}  // namespace mle
