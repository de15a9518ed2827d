#include "mle/explain/instruments.h"

#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/explain/explained_output.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

Instruments InstrumentsOf(const ExplainedOutput& output) {
  auto made = Instruments::Create(TwoLoops(), output);
  EXPECT_TRUE(made.ok()) << made.status();
  return *std::move(made);
}

TEST(InstrumentsTest, OffsetsRampsAndFreeResponsesAreNotDriven) {
  const std::vector<Record> records = {CloseLoops(TwoLoops(), 1)};
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const Instruments instruments = InstrumentsOf(*output);
  EXPECT_TRUE(instruments.by_set_points());
  const auto rows = static_cast<Eigen::Index>(output->rows().size());
  for (const Eigen::VectorXd& free :
       {Eigen::VectorXd(Eigen::VectorXd::Ones(rows)),
        Eigen::VectorXd(Eigen::VectorXd::LinSpaced(rows, 0.0, 5.0))}) {
    EXPECT_LT(instruments.Project(free).norm(), 1e-9 * free.norm());
    EXPECT_LT(instruments.ProjectPlacebos(free).norm(), 1e-9 * free.norm());
  }
}

// E of noise is what placebos make of it, on average over seeds.
TEST(InstrumentsTest, PlacebosMakeOfNoiseWhatSetPointsDo) {
  double driven = 0.0;
  double placebo = 0.0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const std::vector<Record> records = {CloseLoops(TwoLoops(), seed)};
    const auto output = ExplainedOutput::Create(TwoLoops(), records, 1);
    ASSERT_TRUE(output.ok()) << output.status();
    const Instruments instruments = InstrumentsOf(*output);
    const Eigen::VectorXd e = output->Residual({});
    driven += instruments.Project(e).squaredNorm();
    placebo += instruments.ProjectPlacebos(e).rowwise().squaredNorm().mean();
  }
  EXPECT_NEAR(driven / placebo, 1.0, 0.25);
}

TEST(InstrumentsTest, InputsStandForSetPointsThatDoNotMove) {
  std::vector<Record> records = {CloseLoops(TwoLoops(), 1)};
  records[0].set_points.setConstant(3.0);
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const Instruments instruments = InstrumentsOf(*output);
  EXPECT_FALSE(instruments.by_set_points());
  EXPECT_GT(instruments.rank(), 6);
}

// Of more set points than there is room for those are kept that move what the
// output's inputs do.
TEST(InstrumentsTest, OfManySetPointsThoseThatMoveTheElementsJudge) {
  constexpr int kMany = 30;
  constexpr int kSamples = 1600;
  std::vector<InputChannel> inputs;
  std::vector<OutputChannel> outputs;
  for (int i = 0; i < kMany; ++i) {
    inputs.push_back({"u" + std::to_string(i), "%"});
    outputs.push_back({"y" + std::to_string(i), "m"});
  }
  ProcessModel model("many", "min", inputs, outputs);
  for (int i = 0; i < kMany; ++i) {
    model.element(i, i) = TransferFunction::FirstOrder(1.0, 10.0, 1.0);
  }
  model.element(0, kMany - 1) = TransferFunction::FirstOrder(0.2, 8.0, 1.0);
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Zero(kMany, kSamples);
  record.set_points = Eigen::MatrixXd::Zero(kMany, kSamples);
  for (int i = 0; i < kMany; ++i) {
    record.set_points.row(i).segment(40 + 50 * i, 60).setOnes();
  }
  record.inputs = record.set_points;
  const std::vector<Record> records = {record};
  const auto output = ExplainedOutput::Create(model, records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const auto instruments = Instruments::Create(model, *output);
  ASSERT_TRUE(instruments.ok()) << instruments.status();
  EXPECT_LE(instruments->rank(), 72);
  for (const int input : {0, kMany - 1}) {
    const Eigen::VectorXd moved =
        instruments->Freed(output->ContributionOf(input));
    EXPECT_GT(instruments->Project(moved).squaredNorm(),
              0.95 * moved.squaredNorm())
        << input;
  }
}

// Rows without weight have no part, whatever stands there.
TEST(InstrumentsTest, RowsWithoutWeightHaveNoPart) {
  const std::vector<Record> records = {CloseLoops(TwoLoops(), 1)};
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const Instruments instruments = InstrumentsOf(*output);
  Eigen::VectorXd e = output->Residual({});
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(e.size());
  weights.segment(100, 200).setZero();
  const auto project = instruments.ProjectionOf(weights);
  const Eigen::VectorXd before = project(e);
  e.segment(100, 200).array() += 7.0;
  EXPECT_LT((project(e) - before).norm(), 1e-6 * before.norm());
  const auto project_all =
      instruments.ProjectionOf(Eigen::VectorXd::Ones(e.size()));
  EXPECT_EQ(project_all(e), instruments.Project(e));
}

}  // namespace
}  // namespace mle
