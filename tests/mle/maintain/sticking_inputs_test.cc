#include "mle/maintain/sticking_inputs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/maintain/play_regression.h"
#include "tests/mle/data/loop_records.h"
#include "tests/mle/maintain/large_plant.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::LoopModel;
using testing::LoopRecord;

std::vector<StickingInput> FindSticking(const Record& record,
                                        const std::vector<bool>& usable = {
                                            true, true}) {
  return *FindStickingInputs(LoopModel(), {record}, usable);
}

double RangeOf(const Record& record, int input) {
  return record.inputs.row(input).maxCoeff() -
         record.inputs.row(input).minCoeff();
}

TEST(StickingInputsTest, PlayFollowsAtHalfItsWidth) {
  Eigen::RowVectorXd asked(8);
  asked << 0, 1, 3, 2.5, 1.5, 0, -2, -1;
  Eigen::RowVectorXd valve(8);
  valve << 0, 0, 2, 2, 2, 1, -1, -1;
  EXPECT_EQ(PassThroughPlay(asked, 2.0), valve);
  EXPECT_EQ(PassThroughPlay(asked, 0.0), asked);
}

// 3, 7 and 15 % of the input's range.
TEST(StickingInputsTest, FindsPlayAndItsWidth) {
  for (const double share : {0.03, 0.07, 0.15}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const double width = share * RangeOf(LoopRecord({.seed = seed}), 0);
      const Record record =
          LoopRecord({.seed = seed, .play = Eigen::Vector2d(width, 0.0)});
      const std::vector<StickingInput> found = FindSticking(record);
      ASSERT_EQ(found.size(), 1u) << share << " " << seed;
      EXPECT_EQ(found[0].input, 0);
      EXPECT_NEAR(found[0].width, width, 4.0 * found[0].error + 0.05 * width);
      EXPECT_LT(found[0].error, 0.2 * width);
      EXPECT_NEAR(found[0].share, found[0].width / RangeOf(record, 0), 1e-12);
      EXPECT_GT(found[0].log_likelihood, 12.0);
      EXPECT_THAT(found[0].outputs, ElementsAre(0, 1));
    }
  }
}

TEST(StickingInputsTest, FindsPlayInALargePlant) {
  const ProcessModel model = testing::LargeModel();
  const std::vector<StickingInput> found =
      *FindStickingInputs(model, {testing::LargeRecord(22, 0.5)},
                          std::vector<bool>(model.num_outputs(), true));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].input, 22);
  EXPECT_NEAR(found[0].width, 0.5, 0.1);
}

// What is kept from fit to fit is what would be computed anew.
TEST(StickingInputsTest, ScoresFollowTheWidths) {
  const ProcessModel model = testing::LargeModel();
  std::vector<Record> parts = {testing::LargeRecord(22, 0.5)};
  const std::vector<Eigen::MatrixXd> bad = {
      Eigen::MatrixXd::Zero(model.num_outputs(), parts[0].samples())};
  PlayRegression used = *PlayRegression::Create(model, parts, bad);
  for (int j = 0; j < model.num_inputs(); ++j) ASSERT_TRUE(used.Score(j).ok());
  const double before = used.Score(22)->nats;
  EXPECT_GT(before, 50.0);
  Eigen::VectorXd widths = Eigen::VectorXd::Zero(model.num_inputs());
  widths(22) = 0.5;
  ASSERT_TRUE(used.SetWidths(widths).ok());
  PlayRegression fresh = *PlayRegression::Create(model, parts, bad);
  ASSERT_TRUE(fresh.SetWidths(widths).ok());
  for (int j = 0; j < model.num_inputs(); ++j) {
    EXPECT_EQ(used.Score(j)->nats, fresh.Score(j)->nats) << j;
  }
  EXPECT_LT(used.Score(22)->nats, 0.1 * before);
  // An input that the plant follows has no play.
  EXPECT_EQ(*used.OwnNats(0), 0.0);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(model.num_inputs());
  EXPECT_NEAR(*used.OwnNats(22),
              *used.LogLikelihood(widths) - *used.LogLikelihood(none), 1e-6);
  EXPECT_GT(used.GainOver(*PlayRegression::Create(model, parts, bad)), 50.0);
}

TEST(StickingInputsTest, FindsEveryInputThatSticks) {
  const std::vector<StickingInput> found =
      FindSticking(LoopRecord({.play = Eigen::Vector2d(0.03, 0.0225)}));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].input, 0);
  EXPECT_EQ(found[1].input, 1);
  EXPECT_NEAR(found[0].width, 0.03, 0.01);
  EXPECT_NEAR(found[1].width, 0.0225, 0.01);
}

// Gains, time constants and dead times that have aged do not hide it.
TEST(StickingInputsTest, FindsPlayBesideAgeing) {
  ProcessModel aged = LoopModel();
  aged.element(0, 0) = TransferFunction::FirstOrder(1.2, 20.0, 2.0);
  aged.element(1, 1) = TransferFunction::FirstOrder(-4.0, 9.0, 2.5);
  const std::vector<StickingInput> found = FindSticking(LoopRecord(
      aged, {.play = Eigen::Vector2d(0.0, 0.09)}, StaticGains(LoopModel())));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].input, 1);
  EXPECT_NEAR(found[0].width, 0.09, 0.02);
}

TEST(StickingInputsTest, LeavesValvesThatFollow) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    for (const double walk : {0.0, 0.003, 0.03}) {
      Record record = LoopRecord({.walk = walk, .seed = seed});
      EXPECT_TRUE(FindSticking(record).empty()) << seed << " " << walk;
      testing::Quantise(0.05, record.outputs);
      EXPECT_TRUE(FindSticking(record).empty()) << seed << " " << walk;
    }
    for (const double memory : {0.5, 0.9, 0.98}) {
      EXPECT_TRUE(FindSticking(LoopRecord({.samples = 2000,
                                           .coloured = 0.05,
                                           .memory = memory,
                                           .seed = seed}))
                      .empty())
          << seed << " " << memory;
    }
  }
}

TEST(StickingInputsTest, LeavesWhatHasAged) {
  for (int element = 0; element < 4; ++element) {
    for (int what = 0; what < 3; ++what) {
      ProcessModel aged = LoopModel();
      TransferFunction& g = aged.element(element / 2, element % 2);
      g = TransferFunction::FirstOrder(
          (what == 0 ? 0.5 : 1.0) * g.StaticGain(),
          (what == 1 ? 1.5 : 1.0) * g.TimeConstant(),
          g.delay() + (what == 2 ? 1.5 : 0.0));
      EXPECT_TRUE(
          FindSticking(LoopRecord(aged, {}, StaticGains(LoopModel()))).empty())
          << element << " " << what;
    }
  }
}

TEST(StickingInputsTest, LeavesClocksThatAreOff) {
  for (const int late : {-3, 4, 8}) {
    for (int i = 0; i < 2; ++i) {
      Record record = LoopRecord();
      const Eigen::RowVectorXd before = record.outputs.row(i);
      for (int k = 0; k < record.samples(); ++k) {
        record.outputs(i, k) =
            before(std::clamp(k - late, 0, record.samples() - 1));
      }
      EXPECT_TRUE(FindSticking(record).empty()) << late << " " << i;
    }
  }
}

// Outputs that are not measured say nothing.
TEST(StickingInputsTest, UsesUsableOutputsOnly) {
  const Record record = LoopRecord({.play = Eigen::Vector2d(0.1, 0.0)});
  EXPECT_EQ(FindSticking(record, {true, false}).size(), 1u);
  EXPECT_TRUE(FindSticking(record, {false, false}).empty());
  Record dead = record;
  dead.outputs.setConstant(1.0);
  EXPECT_TRUE(FindSticking(dead).empty());
}

TEST(StickingInputsTest, ACorrectedInputDoesNotStick) {
  Record record = LoopRecord({.play = Eigen::Vector2d(0.1, 0.0)});
  record.inputs(0, 100) = std::numeric_limits<double>::quiet_NaN();
  const std::vector<StickingInput> found = FindSticking(record);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].Describe(LoopModel()), HasSubstr("u1 seems to stick"));
  std::vector<Record> records = {record};
  CorrectPlay(found[0], records);
  EXPECT_TRUE(std::isnan(records[0].inputs(0, 100)));
  EXPECT_EQ(records[0].inputs.row(1), record.inputs.row(1));
  EXPECT_TRUE(FindStickingInputs(LoopModel(), records, {true, true})->empty());
}

}  // namespace
}  // namespace mle
