#include "mle/explain/explained_output.h"

#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

// Records of which the outputs are 0, so that the residual is −z.
std::vector<Record> InputsAlone() {
  std::vector<Record> records = {CloseLoops(TwoLoops(), 1)};
  records[0].outputs.setZero();
  return records;
}

ExplainedOutput Make(const std::vector<Record>& records) {
  auto made = ExplainedOutput::Create(TwoLoops(), records, 0);
  EXPECT_TRUE(made.ok()) << made.status();
  return *std::move(made);
}

// Means of the rows of what the simulator says.
Eigen::VectorXd Simulated(const ProcessModel& model,
                          const std::vector<Record>& records,
                          const ExplainedOutput& output) {
  Eigen::MatrixXd inputs = records[0].inputs;
  inputs.colwise() -= Eigen::VectorXd(inputs.col(0));
  const auto z = SimulateResponse(model, records[0].sample_time, inputs);
  EXPECT_TRUE(z.ok()) << z.status();
  const Eigen::VectorXd row = z->row(0).transpose();
  return output.RowMeans({row});
}

TEST(ExplainedOutputTest, WithoutExplanationsItIsTheModel) {
  const std::vector<Record> records = InputsAlone();
  const ExplainedOutput output = Make(records);
  const Eigen::VectorXd z = Simulated(TwoLoops(), records, output);
  EXPECT_LT((output.Residual({}) + z).norm(), 1e-9 * z.norm());
  const auto other = output.ResidualOf(TwoLoops());
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_LT((*other + z).norm(), 1e-9 * z.norm());
}

// What ageing changes is what the model with other numbers says.
TEST(ExplainedOutputTest, AgeingIsAnotherModel) {
  const std::vector<Record> records = InputsAlone();
  const ExplainedOutput output = Make(records);
  const std::vector<Explanation> ageing = {
      {ExplanationKind::kGain, 0, std::log(0.7)},
      {ExplanationKind::kTimeConstant, 1, std::log(1.3)},
      {ExplanationKind::kDeadTime, 1, 2.5 / 17.0}};
  ProcessModel aged = TwoLoops();
  aged.element(0, 0) = TransferFunction::FirstOrder(1.4, 10.0, 2.0);
  aged.element(0, 1) = TransferFunction::FirstOrder(0.6, 18.2, 5.5);
  const Eigen::VectorXd z = Simulated(aged, records, output);
  EXPECT_LT((output.Residual(ageing) + z).norm(), 1e-9 * z.norm());
  const ElementValues values = output.Aged(1, ageing);
  EXPECT_NEAR(values.time_scale, 18.2, 1e-9);
  EXPECT_NEAR(values.delay, 5.5, 1e-9);
}

// A clock is every dead time of the row, also where one would be negative.
TEST(ExplainedOutputTest, AClockMovesTheWholeRow) {
  const std::vector<Record> records = InputsAlone();
  const ExplainedOutput output = Make(records);
  ProcessModel late = TwoLoops();
  for (int j = 0; j < 2; ++j) {
    late.element(0, j).set_delay(late.element(0, j).delay() + 4.0);
  }
  const double half = 0.5 * output.tau();
  const Eigen::VectorXd z = Simulated(late, records, output);
  EXPECT_LT(
      (output.Residual({{ExplanationKind::kOutputClock, 0, 4.0 / half}}) + z)
          .norm(),
      1e-9 * z.norm());
  // Earlier than its inputs: the same a while later.
  const Eigen::VectorXd early =
      output.Residual({{ExplanationKind::kOutputClock, 0, -5.0 / half}});
  const Eigen::VectorXd now = output.Residual({});
  ASSERT_EQ(output.samples_a_row(), 1);
  const Eigen::Index n = now.size() - 5;
  EXPECT_LT((early.head(n) - now.tail(n)).norm(), 0.02 * now.norm());
}

// The neutral value of every explanation that has one changes nothing.
TEST(ExplainedOutputTest, NothingHappensAtZero) {
  const std::vector<Record> records = InputsAlone();
  const ExplainedOutput output = Make(records);
  const Eigen::VectorXd plain = output.Residual({});
  for (Explanation one : output.Applicable({})) {
    if (one.kind == ExplanationKind::kRateLimit ||
        one.kind == ExplanationKind::kReversed) {
      continue;
    }
    one.value = 0.0;
    EXPECT_EQ(output.Residual({one}), plain) << TypeOf(one.kind).code;
  }
  // As fast as it can be, a rate limit limits nothing.
  const Explanation fast = {ExplanationKind::kRateLimit, 0, -20.0};
  EXPECT_LT((output.Residual({fast}) - plain).norm(), 1e-9 * plain.norm());
  EXPECT_LT((output.Residual({{ExplanationKind::kReversed, 0, 0.0},
                              {ExplanationKind::kReversed, 1, 0.0}}) +
             plain)
                .norm(),
            1e-9 * plain.norm());
}

// A load follows one set point that moves, or their mean; gaps of a set point
// are held.
TEST(ExplainedOutputTest, LoadsFollowTheSetPointsThatMove) {
  constexpr ExplanationKind kLoad = ExplanationKind::kLoadWithSetPoints;
  std::vector<Record> records = InputsAlone();
  records[0].set_points.row(0).array() += 5.0;
  records[0].set_points(0, 1) = std::numeric_limits<double>::quiet_NaN();
  const ExplainedOutput output = Make(records);
  ASSERT_EQ(output.num_moving_set_points(), 2);
  EXPECT_EQ(output.PartsOf(kLoad), std::vector<int>({0, 1, 2}));
  const auto effect = [&output](int part) -> Eigen::VectorXd {
    return output.Residual({{kLoad, 0, 0.4, part}}) - output.Residual({});
  };
  std::vector<Record> loaded = records;
  const auto input = records[0].inputs.row(0);
  loaded[0].inputs.row(0) += 0.4 * (input.maxCoeff() - input.minCoeff()) *
                             output.SetPointMoves(0, 0).transpose();
  const Eigen::VectorXd expected = Simulated(TwoLoops(), records, output) -
                                   Simulated(TwoLoops(), loaded, output);
  EXPECT_LT((effect(0) - expected).norm(), 1e-9 * expected.norm());
  EXPECT_LT((effect(2) - 0.5 * (effect(0) + effect(1))).norm(),
            1e-9 * expected.norm());

  records[0].set_points.row(0).setConstant(5.0);
  const ExplainedOutput other = Make(records);
  EXPECT_EQ(other.num_moving_set_points(), 1);
  EXPECT_EQ(other.PartsOf(kLoad), std::vector<int>{0});
  const Eigen::VectorXd moves = other.SetPointMoves(0, 0);
  EXPECT_EQ(moves[0], 0.0);
  EXPECT_DOUBLE_EQ(moves.maxCoeff() - moves.minCoeff(), 1.0);
}

TEST(ExplainedOutputTest, EveryKindHasARowAndASentence) {
  for (const ExplanationType& type : ExplanationTable()) {
    EXPECT_EQ(&TypeOf(type.kind), &type);
    EXPECT_NE(std::string(type.sentence).find("%s"), std::string::npos);
    EXPECT_LE(type.lower, type.upper);
    for (const double start : type.start) {
      EXPECT_GE(start, type.lower);
      EXPECT_LE(start, type.upper);
    }
    EXPECT_EQ(IsAgeing(type.kind), std::string(type.settled_by).empty());
  }
}

}  // namespace
}  // namespace mle
