#include "mle/maintain/steady_records.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "mle/maintain/correct.h"
#include "tests/mle/maintain/tank_records.h"

namespace mle {
namespace {

using testing::Tank;
using testing::TankRecord;

constexpr double kRestNoise = 0.02;

// A tank whose valve is moved a little every 20 samples, in noise.
Record TankAtRest(int samples, std::uint64_t seed) {
  Record record;
  record.sample_time = 0.5;
  record.inputs =
      GaussianNoise(seed, 1, kMeasurementNoise).DrawMatrix(1, samples, 0.1);
  for (int k = 0; k < samples; ++k) {
    record.inputs(0, k) = record.inputs(0, k - k % 20);
  }
  record.outputs = *SimulateResponse(Tank(1.0), 0.5, record.inputs) +
                   GaussianNoise(seed, 0, kMeasurementNoise)
                       .DrawMatrix(1, samples, kRestNoise);
  return record;
}

// The valve is shut from one sample to another, and the level runs away.
void ShutDown(int from, int to, Record& record) {
  double level = 0.0;
  for (int k = from; k < record.samples(); ++k) {
    if (k < to) record.inputs(0, k) = -5.0;
    level += ((k < to ? 8.0 : 0.0) - level) / 40.0;
    record.outputs(0, k) += level;
  }
}

SteadyRecords Divided(const std::vector<Record>& rest, double gain = 1.0) {
  absl::StatusOr<SteadyRecords> parts = FindSteadyRecords(Tank(gain), rest);
  EXPECT_TRUE(parts.ok()) << parts.status();
  return parts.ok() ? *std::move(parts) : SteadyRecords();
}

TEST(SteadyRecordsTest, NoiseDisturbancesAndAnAgedModelAreUsual) {
  const std::vector<std::function<void(Record&)>> usual = {
      [](Record&) {},
      // A step of 20 standard deviations, missing samples, a drift.
      [](Record& record) {
        record.outputs.rightCols(900).array() += 20.0 * kRestNoise;
      },
      [](Record& record) {
        record.outputs.middleCols(500, 400).setConstant(
            std::numeric_limits<double>::quiet_NaN());
      },
      [](Record& record) {
        for (int k = 0; k < record.samples(); ++k) {
          record.outputs(0, k) += 0.01 * k * kRestNoise;
        }
      }};
  for (const auto& change : usual) {
    for (const double gain : {1.0, 0.5, 2.0, -1.0}) {
      Record record = TankAtRest(2000, 1);
      change(record);
      const SteadyRecords parts = Divided({record, TankAtRest(100, 2)}, gain);
      EXPECT_TRUE(parts.left_out.empty());
      ASSERT_EQ(parts.usual.size(), 2);
      EXPECT_EQ(parts.usual[0].inputs, record.inputs);
    }
  }
}

// Of two records of a level the first inputs of one are far from balance: its
// residual is a ramp, of which nothing is left out.
TEST(SteadyRecordsTest, ALevelMayBeginOutOfBalance) {
  ProcessModel level("drum", "min", {{"feed", ""}}, {{"level", ""}});
  level.element(0, 0) = TransferFunction::Integrator(0.05, 0.0, 1.0);
  std::vector<Record> rest;
  for (const double first : {0.0, 3.0}) {
    Record record = TankAtRest(3000, 1);
    record.outputs = *SimulateResponse(level, 0.5, record.inputs);
    record.outputs += GaussianNoise(1, 2, kMeasurementNoise)
                          .DrawMatrix(1, record.samples(), kRestNoise);
    record.inputs(0, 0) += first;
    rest.push_back(record);
  }
  absl::StatusOr<SteadyRecords> parts = FindSteadyRecords(level, rest);
  ASSERT_TRUE(parts.ok()) << parts.status();
  EXPECT_TRUE(parts->left_out.empty());
  // A feed that is not measured.
  for (int k = 1500; k < 1600; ++k) rest[0].outputs(0, k) += 2.0 * (k - 1500);
  rest[0].outputs.rightCols(1400).array() += 200.0;
  parts = FindSteadyRecords(level, rest);
  ASSERT_TRUE(parts.ok()) << parts.status();
  EXPECT_EQ(parts->left_out.size(), 1);
}

// With the five settling times around it, and as one where it takes no longer
// than twenty.
TEST(SteadyRecordsTest, AShutdownIsLeftOut) {
  const double settling = SettlingTime(Tank(1.0));
  for (const int length : {300, 1000, 1400}) {
    Record record = TankAtRest(5000, 1);
    ShutDown(1500, 1500 + length, record);
    const SteadyRecords parts = Divided({TankAtRest(500, 2), record});
    const double end = 750.0 + length / 2.0;
    ASSERT_EQ(parts.left_out.size(), length / 2.0 < 20.0 * settling ? 1 : 2);
    EXPECT_NEAR(parts.left_out.front().first, 750.0 - 5.0 * settling, 60.0);
    EXPECT_GT(parts.left_out.back().second, end + 5.0 * settling);
    EXPECT_LT(parts.left_out.back().second, end + 5.0 * settling + 200.0);
    ASSERT_EQ(parts.usual.size(), parts.left_out.size() + 2);
    EXPECT_EQ(parts.usual[0].samples(), 500);
    int samples = 0;
    for (const Record& usual : parts.usual) {
      EXPECT_TRUE(usual.Validate().ok());
      samples += usual.samples();
    }
    for (const auto& [from, to] : parts.left_out) {
      samples += static_cast<int>(std::lround((to - from) / 0.5 + 1.0));
    }
    EXPECT_EQ(samples, 5500);
  }
}

// Too little to know what is usual, and nothing at all; no noise either.
TEST(SteadyRecordsTest, WithoutAMeasureNothingIsLeftOut) {
  Record record = TankAtRest(400, 1);
  ShutDown(200, 230, record);
  EXPECT_TRUE(Divided({record}).left_out.empty());
  EXPECT_TRUE(Divided({}).usual.empty());
  Record exact = TankAtRest(2000, 1);
  exact.inputs.setZero();
  exact.outputs.setZero();
  EXPECT_TRUE(Divided({exact}).left_out.empty());
  exact.outputs.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(Divided({exact}).left_out.empty());
}

// Weeks with a shutdown between two set-point changes, of which no window has
// anything: the aged gain is found as without it, and the result says when.
TEST(SteadyRecordsTest, AShutdownBetweenWindowsHidesNothing) {
  const ProcessModel plant = Tank(1.3);
  Record record = TankRecord(plant, kRestNoise, 1);
  Record rest = TankAtRest(6000, 3);
  const auto correct = [&](const Record& between) {
    const Record parts[] = {record, between, record};
    CorrectOptions options;
    options.threads = 1;
    Record all = JoinRecords(parts);
    all.start_time = 0.0;
    auto result = CorrectFromRecords(Tank(1.0), {all}, options);
    EXPECT_TRUE(result.ok()) << result.status();
    return *std::move(result);
  };
  rest.set_points = Eigen::MatrixXd::Zero(1, rest.samples());
  const CorrectionResult usual = correct(rest);
  ShutDown(5000, 5200, rest);
  const CorrectionResult shut_down = correct(rest);
  const auto notes = [](const CorrectionResult& result) {
    int count = 0;
    for (const Message& note : result.notes) {
      count += note.text.find("not operated as usual") != std::string::npos;
    }
    return count;
  };
  EXPECT_EQ(notes(usual), 0);
  EXPECT_EQ(notes(shut_down), 1);
  for (const CorrectionResult* result : {&usual, &shut_down}) {
    EXPECT_EQ(result->decision, Decision::kCorrected);
    EXPECT_NEAR(result->model.element(0, 0).StaticGain(), 1.3, 0.03);
  }
  EXPECT_LT(shut_down.estimate.setting.noise[0].inflation,
            1.5 * usual.estimate.setting.noise[0].inflation);
}

}  // namespace
}  // namespace mle
