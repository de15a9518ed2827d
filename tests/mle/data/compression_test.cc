#include "mle/data/compression.h"

#include <cmath>
#include <random>

#include "gtest/gtest.h"
#include "tests/mle/data/loop_records.h"

namespace mle {
namespace {

using testing::LoopRecord;
using Kind = Compression::Kind;

Compression Find(const Eigen::RowVectorXd& row, Holding own = Holding::kNever) {
  return FindCompression({SampleRow(row)}, own);
}

// What a swinging door keeps is found sample by sample, whatever it lets pass.
TEST(CompressionTest, FindsWhatASwingingDoorKept) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double deviation : {0.02, 0.04, 0.1}) {
      Eigen::RowVectorXd row = LoopRecord({.seed = seed}).outputs.row(0);
      const int kept = testing::Compress(deviation, row);
      const Compression found = Find(row);
      ASSERT_EQ(found.kind, Kind::kLinear) << deviation;
      EXPECT_NEAR(found.archived, kept, 0.02 * kept + 2) << deviation;
      EXPECT_EQ(found.samples, row.size());
    }
  }
}

// As printed with four decimals.
TEST(CompressionTest, FindsLinesThroughTheDigitsPrinted) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Eigen::RowVectorXd row = LoopRecord({.seed = seed}).outputs.row(1);
    row.array() += 50.0;
    const int kept = testing::Compress(0.04, row);
    testing::Quantise(1e-4, row);
    const Compression found = Find(row);
    ASSERT_EQ(found.kind, Kind::kLinear);
    EXPECT_NEAR(found.archived, kept, 0.05 * kept);
  }
}

TEST(CompressionTest, FindsWhatIsStoredInSinglePrecision) {
  Eigen::RowVectorXd row = LoopRecord().outputs.row(1);
  row.array() += 50.0;
  testing::Compress(0.04, row);
  for (double& value : row) value = static_cast<float>(value);
  EXPECT_EQ(Find(row).kind, Kind::kLinear);
}

// A smooth response has few archived samples, but their lines are exact.
TEST(CompressionTest, FindsLinesOfASmoothSignal) {
  Eigen::RowVectorXd row = LoopRecord({.noise = 0.0}).outputs.row(0);
  testing::Compress(0.002, row);
  EXPECT_EQ(Find(row).kind, Kind::kLinear);
}

// A long rest, in which samples are equal, is not held against it.
TEST(CompressionTest, FindsLinesBesideALongRest) {
  Eigen::RowVectorXd row = LoopRecord().outputs.row(0);
  testing::Compress(0.04, row);
  Eigen::RowVectorXd both(5 * row.size());
  both << Eigen::RowVectorXd::Constant(4 * row.size(), row(0)), row;
  EXPECT_EQ(Find(both).kind, Kind::kLinear);
}

TEST(CompressionTest, FindsHeldValues) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Eigen::RowVectorXd row = LoopRecord({.seed = seed}).outputs.row(0);
    const int kept = testing::Hold(0.04, row);
    const Compression found = Find(row);
    ASSERT_EQ(found.kind, Kind::kHeld);
    EXPECT_EQ(found.archived, kept);
  }
}

// An analyser reports every tenth sample.
TEST(CompressionTest, FindsAnAnalyser) {
  Eigen::RowVectorXd row = LoopRecord().outputs.row(0);
  for (Eigen::Index k = 0; k < row.size(); ++k) row(k) = row(k - k % 10);
  EXPECT_EQ(Find(row).kind, Kind::kHeld);
  EXPECT_EQ(Find(row).archived, row.size() / 10);
}

// A laboratory: a value every 48 samples or so, given with few digits.
TEST(CompressionTest, FindsRoundedValuesOfALaboratory) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.03);
  std::uniform_int_distribution<int> late(-3, 3);
  for (const int jitter : {0, 1}) {
    Eigen::RowVectorXd row(4800);
    double value = 5.0;
    int next = 20;
    int taken = 0;
    for (int k = 0; k < 4800; ++k) {
      if (k == next) {
        value = std::round(100.0 * (5.0 + noise(random))) / 100.0;
        next = 20 + 48 * ++taken + jitter * late(random);
      }
      row(k) = value;
    }
    const Compression found = Find(row);
    ASSERT_EQ(found.kind, Kind::kHeld);
    EXPECT_TRUE(found.is_sampled);
    EXPECT_LE(found.archived, taken);
    // Equal values are told from held ones where stamps are exact.
    EXPECT_GE(found.archived, jitter == 0 ? taken : 0.7 * taken);
  }
}

TEST(CompressionTest, LeavesCleanAndDriftingSignals) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double noise : {0.001, 0.02, 0.3}) {
      for (const double walk : {0.0, 0.01}) {
        const Record record =
            LoopRecord({.noise = noise, .walk = walk, .seed = seed});
        for (int i = 0; i < 2; ++i) {
          EXPECT_EQ(Find(record.outputs.row(i)).kind, Kind::kNone);
          EXPECT_EQ(Find(record.inputs.row(i), Holding::kByItself).kind,
                    Kind::kNone);
          EXPECT_EQ(Find(record.set_points.row(i), Holding::kByItself).kind,
                    Kind::kNone);
        }
      }
    }
  }
}

// Simulated without noise: exponentials between the controller's moves, fast or
// slow, every sample or every hundredth.
TEST(CompressionTest, LeavesSmoothSignals) {
  for (const int period : {1, 5, 20, 100}) {
    for (const double slow : {0.1, 1.0, 10.0}) {
      ProcessModel plant = testing::LoopModel();
      for (int i = 0; i < 2; ++i) {
        const TransferFunction& g = plant.element(i, i);
        plant.element(i, i) = TransferFunction::FirstOrder(
            g.StaticGain(), slow * g.TimeConstant(), g.delay());
      }
      Record record = LoopRecord(plant, {.noise = 0.0, .period = period},
                                 StaticGains(plant));
      for (const double quantum : {0.0, 1e-6, 1e-4, 1e-2}) {
        if (quantum > 0.0) testing::Quantise(quantum, record.outputs);
        for (int i = 0; i < 2; ++i) {
          EXPECT_EQ(Find(record.outputs.row(i)).kind, Kind::kNone)
              << period << " " << slow << " " << quantum;
        }
      }
    }
  }
}

// The response of a very slow plant to a staircase: straight to within the
// digits printed, with a bend at every step, but never back.
TEST(CompressionTest, LeavesSlowResponsesAsPrinted) {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(2000);
  for (int k = 1; k < 2000; ++k) row(k) = row(k - 1) + 0.00234567 * (k / 20);
  testing::Quantise(1e-4, row);
  EXPECT_EQ(Find(row).kind, Kind::kNone);
}

// At rest most of its values are those before; six moves show the period.
TEST(CompressionTest, FindsALaboratoryAtRest) {
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0.0, 0.004);
  std::uniform_int_distribution<int> late(-8, 8);
  Eigen::RowVectorXd row(5760);
  double level = 2.0;
  double value = level;
  int taken = 0;
  int next = 20;
  for (int k = 0; k < row.size(); ++k) {
    const double target = (k / 960) % 2 == 0 ? 2.0 : 2.3;
    level += (target - level) / 36.0;
    if (k == next) {
      value = std::round(100.0 * (level + noise(random))) / 100.0;
      next = 20 + 48 * ++taken + late(random);
    }
    row(k) = value;
  }
  const Compression found = Find(row);
  ASSERT_EQ(found.kind, Kind::kHeld);
  EXPECT_TRUE(found.is_sampled);
  EXPECT_GE(found.archived, 0.4 * taken);
}

TEST(CompressionTest, LeavesRoundedSignals) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const double quantum : {0.001, 0.01, 0.02, 0.05, 0.2}) {
      Record record = LoopRecord({.seed = seed});
      record.outputs.array() += 54.7;
      testing::Quantise(quantum, record.outputs);
      for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(Find(record.outputs.row(i)).kind, Kind::kNone) << quantum;
      }
    }
  }
}

TEST(CompressionTest, LeavesWhatIsConstantOrMissing) {
  EXPECT_EQ(Find(Eigen::RowVectorXd::Constant(500, 3.0)).kind, Kind::kNone);
  EXPECT_EQ(Find(Eigen::RowVectorXd::Constant(500, std::nan(""))).kind,
            Kind::kNone);
  EXPECT_EQ(Find(Eigen::RowVectorXd()).ArchivedShare(), 1.0);
}

}  // namespace
}  // namespace mle
