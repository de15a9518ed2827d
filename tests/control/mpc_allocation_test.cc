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

TEST(MpcAllocationTest, StepWithADisturbanceModelAllocatesNothing) {
  MpcOptions options;
  options.output_weight = Eigen::MatrixXd::Identity(2, 2);
  options.move_weight = Eigen::MatrixXd::Identity(3, 3);
  DisturbanceForm form;
  form.A = Eigen::Vector4d(1.0, 0.9, 1.0, 0.5).asDiagonal();
  form.C = Eigen::MatrixXd::Zero(2, 4);
  form.C << 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0;
  form.K = 0.2 * form.C.transpose();
  form.Q = Eigen::MatrixXd::Identity(4, 4);
  form.R = Eigen::VectorXd::Ones(2);
  options.disturbance_model = form;
  absl::StatusOr<Mpc> created = Mpc::Create(testing::MixedModel(), options);
  ASSERT_TRUE(created.ok()) << created.status();
  Mpc mpc = *std::move(created);
  const Eigen::MatrixXd measured = Eigen::MatrixXd::Random(2, 100);
  const Eigen::VectorXd set_points = Eigen::VectorXd::Zero(2);
  Eigen::VectorXd next(3);
  const std::size_t before = testing::AllocationCount();
  for (int l = 0; l < 100; ++l) mpc.Step(measured.col(l), set_points, next);
  EXPECT_EQ(testing::AllocationCount(), before);
}

// With limits of all kinds at work, feed-forward and preview.
TEST(MpcAllocationTest, StepWithinLimitsAllocatesNothing) {
  ProcessModel model(
      "test", "min",
      {{.name = "u1", .unit = "1"},
       {.name = "d", .unit = "1", .role = InputRole::kDisturbance},
       {.name = "u2", .unit = "1"}},
      {{.name = "y1", .unit = "1"}, {.name = "y2", .unit = "1"}});
  const ProcessModel mixed = testing::MixedModel();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) model.element(i, j) = mixed.element(i, j);
  }
  MpcOptions options;
  options.output_weight = Eigen::MatrixXd::Identity(2, 2);
  options.move_weight = Eigen::MatrixXd::Identity(3, 3) * 0.01;
  options.limits.min_input = Eigen::VectorXd::Constant(3, -0.3);
  options.limits.max_input = Eigen::VectorXd::Constant(3, 0.2);
  options.limits.max_move = Eigen::VectorXd::Constant(3, 0.1);
  options.limits.min_output = Eigen::VectorXd::Constant(2, -0.2);
  options.limits.max_output = Eigen::VectorXd::Constant(2, 0.1);
  options.limits.output_limit_cost = Eigen::VectorXd::Constant(2, 10.0);
  absl::StatusOr<Mpc> created = Mpc::Create(model, options);
  ASSERT_TRUE(created.ok()) << created.status();
  Mpc mpc = *std::move(created);
  const Eigen::MatrixXd measured = Eigen::MatrixXd::Random(2, 100);
  const Eigen::MatrixXd set_points = Eigen::MatrixXd::Random(2, 100);
  const Eigen::MatrixXd ahead =
      Eigen::MatrixXd::Random(2, options.prediction_horizon);
  const Eigen::VectorXd disturbance = Eigen::VectorXd::Random(100);
  Eigen::VectorXd next(3);
  int active = 0;
  const std::size_t before = testing::AllocationCount();
  for (int l = 0; l < 100; ++l) {
    mpc.MeasureDisturbances(disturbance.segment(l, 1));
    if (l % 2 == 0) {
      mpc.Step(measured.col(l), set_points.col(l), next);
    } else {
      mpc.StepWithPreview(measured.col(l), ahead, next);
    }
    active += mpc.last_plan().active_limits;
  }
  EXPECT_EQ(testing::AllocationCount(), before);
  EXPECT_GT(active, 100);
}

}  // namespace
}  // namespace mle::control
