#include <utility>

#include "gtest/gtest.h"
#include "sim/plant.h"
#include "tests/sim/allocation_counter.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

TEST(PlantAllocationTest, AdvanceAllocatesNothing) {
  const std::size_t before_create = testing::AllocationCount();
  absl::StatusOr<Plant> created = Plant::Create(testing::MixedModel(), {});
  ASSERT_TRUE(created.ok()) << created.status();
  // The counter counts.
  ASSERT_GT(testing::AllocationCount(), before_create);

  Plant plant = *std::move(created);
  Eigen::VectorXd input = Eigen::VectorXd::Ones(3);
  const std::size_t before = testing::AllocationCount();
  for (int k = 0; k < 100; ++k) {
    plant.Advance(input);
    input[0] = -input[0] + plant.outputs()[0];
  }
  EXPECT_EQ(testing::AllocationCount(), before);
}

}  // namespace
}  // namespace mle::sim
