#include "mle/monitor/record_jump.h"

#include <limits>

#include "gtest/gtest.h"
#include "tests/mle/monitor/watched_tank.h"

namespace mle {
namespace {

constexpr int kAt = 200;

class RecordJumpTest : public ::testing::Test {
 protected:
  RecordJumpTest()
      : model_(TankModel()),
        record_(SimulateTankDay(model_, {.seed = 4}, 20).record) {}

  std::optional<int> Found() const {
    const auto found = FindRecordJump(model_, record_,
                                      Eigen::VectorXd::Constant(2, kTankNoise));
    EXPECT_TRUE(found.ok()) << found.status();
    return *found;
  }
  void Add(int output, double size, int samples) {
    record_.outputs.row(output).segment(kAt, samples).array() += size;
  }

  const ProcessModel model_;
  Record record_;
};

TEST_F(RecordJumpTest, APlantThatAnswersDoesNotJump) {
  EXPECT_EQ(Found(), std::nullopt);
  // As it ages neither.
  ProcessModel aged = model_;
  aged.element(0, 0) = TransferFunction::FirstOrder(1.0, 20.0, 10.0);
  record_ = SimulateTankDay(aged, {.seed = 4}, 20).record;
  EXPECT_EQ(Found(), std::nullopt);
}

TEST_F(RecordJumpTest, AllOutputsAtOnceAreARecordThatHasChanged) {
  const int rest = record_.samples() - kAt;
  Add(0, 1.0, rest);
  // A disturbance of one output.
  EXPECT_EQ(Found(), std::nullopt);
  Add(1, -1.0, rest);
  EXPECT_EQ(Found(), kAt);
  // Behind a gap, too.
  record_.outputs.middleCols(kAt - 10, 10)
      .setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(Found(), kAt);
}

TEST_F(RecordJumpTest, OutliersReturn) {
  Add(0, 3.0, 1);
  Add(1, 3.0, 1);
  EXPECT_EQ(Found(), std::nullopt);
}

TEST_F(RecordJumpTest, WhatIsWithinTheNoiseIsNoJump) {
  Add(0, 6.0 * kTankNoise, record_.samples() - kAt);
  Add(1, 6.0 * kTankNoise, record_.samples() - kAt);
  EXPECT_EQ(Found(), std::nullopt);
}

}  // namespace
}  // namespace mle
