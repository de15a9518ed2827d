#include <utility>

#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "tests/sim/allocation_counter.h"
#include "tests/sim/test_models.h"

namespace mle {
namespace {

TEST(ProcessSimulatorAllocationTest, AdvanceAllocatesNothing) {
  const std::size_t before_create = testing::AllocationCount();
  absl::StatusOr<ProcessSimulator> created =
      ProcessSimulator::Create(testing::MixedModel(), 0.2);
  ASSERT_TRUE(created.ok()) << created.status();
  // The counter counts.
  ASSERT_GT(testing::AllocationCount(), before_create);

  ProcessSimulator plant = *std::move(created);
  Eigen::VectorXd input = Eigen::VectorXd::Ones(3);
  const std::size_t before = testing::AllocationCount();
  for (int k = 0; k < 100; ++k) {
    plant.Advance(input);
    input[0] = -input[0] + plant.outputs()[0];
  }
  EXPECT_EQ(testing::AllocationCount(), before);
}

}  // namespace
}  // namespace mle
