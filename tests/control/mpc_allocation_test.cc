#include <utility>

#include "control/mpc.h"
#include "gtest/gtest.h"
#include "tests/sim/allocation_counter.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

TEST(MpcAllocationTest, StepAllocatesNothing) {
  MpcOptions options;
  options.output_weight = Eigen::MatrixXd::Identity(2, 2);
  options.move_weight = Eigen::MatrixXd::Identity(3, 3);
  const std::size_t before_create = testing::AllocationCount();
  absl::StatusOr<Mpc> created = Mpc::Create(testing::MixedModel(), options);
  ASSERT_TRUE(created.ok()) << created.status();
  // The counter counts.
  ASSERT_GT(testing::AllocationCount(), before_create);

  Mpc mpc = *std::move(created);
  // Columns of matrices, as the closed loop passes them.
  Eigen::MatrixXd measured = Eigen::MatrixXd::Random(2, 100);
  const Eigen::MatrixXd set_points = Eigen::MatrixXd::Random(2, 100);
  Eigen::VectorXd next(3);
  const std::size_t before = testing::AllocationCount();
  for (int l = 0; l < 100; ++l) {
    mpc.Step(measured.col(l), set_points.col(l), next);
  }
  EXPECT_EQ(testing::AllocationCount(), before);
}

}  // namespace
}  // namespace mle::control
