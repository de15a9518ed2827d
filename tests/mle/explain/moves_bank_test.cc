#include "mle/explain/moves_bank.h"

#include <vector>

#include "gtest/gtest.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/projected_residual.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

RecordSignal SetPointOf(const std::vector<Record>& records, int output) {
  RecordSignal signal;
  for (const Record& record : records) {
    signal.emplace_back(record.set_points.row(output).transpose());
  }
  return signal;
}

// Two records of other lengths; samples of one are missing, so that rows are.
std::vector<Record> TwoRecords() {
  Happening shorter;
  shorter.samples = 900;
  std::vector<Record> records = {CloseLoops(TwoLoops(), 1),
                                 CloseLoops(TwoLoops(), 2, shorter)};
  records[0].outputs.row(0).segment(300, 41).setConstant(std::nan(""));
  return records;
}

// The functions run backward over x give what B_s gives, for any shift.
TEST(MovesBankTest, ProductsNeedNoColumns) {
  const std::vector<Record> records = TwoRecords();
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const Eigen::VectorXd x = output->Residual({});
  const std::vector<double> shares = {0.0, 0.13, 0.5, 0.98};
  for (const int functions : {3, 4, 5, 6}) {
    const MovesBank bank(*output,
                         {SetPointOf(records, 0), SetPointOf(records, 1)},
                         functions, 0.6 * output->tau());
    ASSERT_EQ(bank.columns(), 2 * functions);
    const Eigen::MatrixXd products = bank.Project(x, shares);
    for (std::size_t s = 0; s < shares.size(); ++s) {
      const Eigen::MatrixXd columns = bank.Columns(shares[s]);
      const double size = columns.norm() * x.norm();
      EXPECT_LT(
          (products.col(static_cast<Eigen::Index>(s)) - columns.transpose() * x)
              .norm(),
          1e-12 * size)
          << functions << " functions, " << shares[s];
      const Eigen::MatrixXd third = bank.Columns(shares[s], 3);
      EXPECT_EQ(third.row(5), columns.row(15));
    }
  }
}

// Laguerre functions are orthonormal: those of an impulse are, where it has
// died out.
TEST(MovesBankTest, FunctionsOfAnImpulseAreOrthonormal) {
  std::vector<Record> records = {CloseLoops(TwoLoops(), 1)};
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  ASSERT_EQ(output->samples_a_row(), 1);
  Eigen::VectorXd impulse = Eigen::VectorXd::Zero(records[0].samples());
  impulse[20] = 4.0;  // of any size: signals are in units of their range
  const MovesBank bank(*output, {{impulse}}, 6, 0.6 * output->tau());
  const Eigen::MatrixXd columns = bank.Columns(0.0);
  EXPECT_LT((columns.transpose() * columns - Eigen::MatrixXd::Identity(6, 6))
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

// What is kept of responses gives the same as the residual made anew.
TEST(ProjectedResidualTest, IsTheMapOfTheResidual) {
  const std::vector<Record> records = TwoRecords();
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  const Eigen::MatrixXd map = Eigen::MatrixXd::Random(
      7, static_cast<Eigen::Index>(output->rows().size()));
  const ProjectedResidual projected(
      *output,
      [&](const Eigen::VectorXd& e) -> Eigen::VectorXd { return map * e; });
  using Kind = ExplanationKind;
  const std::vector<std::vector<Explanation>> cases = {
      {},
      {{Kind::kGain, 0, 0.3}},
      {{Kind::kGain, 0, 0.3}, {Kind::kDeadTime, 1, 0.2}},
      {{Kind::kChangeDuringRecord, 1, 0.4, 2}},
      {{Kind::kOutputClock, 0, 0.7}, {Kind::kHigherOrder, 0, 0.3}},
      {{Kind::kAveragedOutput, 0, 0.5}},
      {{Kind::kCurvedOutput, 0, 0.3}, {Kind::kGain, 1, -0.2}},
      {{Kind::kLoadWithSetPoints, 0, 0.3, 1}}};
  for (int round = 0; round < 2; ++round) {
    for (const std::vector<Explanation>& explanations : cases) {
      const Eigen::VectorXd expected = map * output->Residual(explanations);
      EXPECT_LT((projected(explanations) - expected).norm(),
                1e-11 * (map * output->Measured()).norm());
    }
  }
}

}  // namespace
}  // namespace mle
