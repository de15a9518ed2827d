#include "mle/maintain/means.h"

#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "mle/mle.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

// What a historian makes of a record: means over so many samples, stamped at
// their start, of outputs on lines between samples; of set points what holds
// there.
Record MeansOver(int samples, const Record& record) {
  Record means;
  means.sample_time = samples * record.sample_time;
  const Eigen::Index n = (record.samples() - 1) / samples;
  means.outputs.resize(record.num_outputs(), n);
  means.inputs.resize(record.num_inputs(), n);
  means.set_points.resize(record.num_outputs(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index from = k * samples;
    means.outputs.col(k) = 0.5 * (record.outputs.middleCols(from, samples) +
                                  record.outputs.middleCols(from + 1, samples))
                                     .rowwise()
                                     .mean();
    means.inputs.col(k) =
        record.inputs.middleCols(from, samples).rowwise().mean();
    means.set_points.col(k) = record.set_points.col(from);
  }
  return means;
}

// Every so many samples.
Record SamplesEvery(int samples, const Record& record) {
  Record sampled = MeansOver(samples, record);
  for (Eigen::Index k = 0; k < sampled.outputs.cols(); ++k) {
    sampled.outputs.col(k) = record.outputs.col(k * samples);
  }
  return sampled;
}

CorrectionResult CorrectedFrom(const Record& record) {
  CorrectOptions options;
  options.make_arx = false;
  options.threads = 1;
  auto result = CorrectFromRecords(TwoLoops(), {record}, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

bool SaysMeans(const CorrectionResult& result) {
  for (const Message& warning : result.warnings) {
    if (warning.text.find("All samples seem to be means over the 3 min") !=
        std::string::npos) {
      return true;
    }
  }
  return false;
}

constexpr int kSamples = 3;

// So little noise that half a sample shows.
Happening Long() {
  Happening happening;
  happening.noise = 0.005;
  happening.drift = 0.0025;
  happening.samples = 2400;
  return happening;
}

TEST(MeansTest, MeansOfAnUnagedPlantAreNoChange) {
  const CorrectionResult result =
      CorrectedFrom(MeansOver(kSamples, CloseLoops(TwoLoops(), 11, Long())));
  EXPECT_EQ(result.decision, Decision::kNoChange)
      << result.reasons.front().text;
  EXPECT_TRUE(SaysMeans(result));
  EXPECT_EQ(result.data.sample_time(), 0.5 * kSamples);
}

TEST(MeansTest, AnAgedGainIsFoundInMeans) {
  ProcessModel plant = TwoLoops();
  plant.element(1, 1) = TransferFunction::FirstOrder(0.9, 8.0, 1.0);
  const CorrectionResult result =
      CorrectedFrom(MeansOver(kSamples, CloseLoops(plant, 12, Long())));
  ASSERT_EQ(result.decision, Decision::kCorrected)
      << result.reasons.front().text;
  EXPECT_TRUE(SaysMeans(result));
  EXPECT_NEAR(result.model.element(1, 1).StaticGain(), 0.9, 0.06);
  EXPECT_NEAR(result.model.element(0, 0).StaticGain(), 2.0, 0.1);
}

TEST(MeansTest, SamplesAreNotTakenForMeans) {
  for (const double gain : {1.5, 0.9}) {
    ProcessModel plant = TwoLoops();
    plant.element(1, 1) = TransferFunction::FirstOrder(gain, 8.0, 1.0);
    const CorrectionResult result =
        CorrectedFrom(SamplesEvery(kSamples, CloseLoops(plant, 13, Long())));
    EXPECT_FALSE(SaysMeans(result));
    EXPECT_EQ(result.data.sample_time(), kSamples);
  }
}

TEST(MeansTest, WhatIsDeclaredIsNotAskedAgain) {
  RecordData data = UseAsWindows(
      {SamplesEvery(kSamples, CloseLoops(TwoLoops(), 14, Long()))});
  data.records = data.Records();
  data.report.sample_time = kSamples;
  EXPECT_TRUE(MayBeMeans(data));
  EXPECT_FALSE(MayBeMeans(AsMeans(data)));
  data.sampling.resize(2);
  EXPECT_TRUE(MayBeMeans(data));
  data.sampling[1].late_by = 1.0;
  EXPECT_FALSE(MayBeMeans(data));
}

// Inputs act over the time that the means are over; outputs stand in its
// middle.
TEST(MeansTest, TheMiddleIsASample) {
  RecordData data = UseAsWindows(
      {SamplesEvery(kSamples, CloseLoops(TwoLoops(), 15, Long()))});
  const Record before = data.windows.front().record;
  data.windows.front().changes = {{7, 0, 0.0, 1.0}};
  const RecordData means = AsMeans(data);
  const SetPointWindow& window = means.windows.front();
  ASSERT_EQ(window.record.samples(), 2 * before.samples());
  EXPECT_EQ(window.changes.front().sample, 14);
  EXPECT_EQ(window.record.sample_time, 0.5 * kSamples);
  for (int k = 0; k < before.samples(); ++k) {
    EXPECT_EQ(window.record.inputs.col(2 * k), before.inputs.col(k));
    EXPECT_EQ(window.record.inputs.col(2 * k + 1), before.inputs.col(k));
    EXPECT_TRUE(std::isnan(window.record.outputs(0, 2 * k)));
    EXPECT_EQ(window.record.outputs.col(2 * k + 1), before.outputs.col(k));
  }
  ASSERT_EQ(means.sampling.size(), 2U);
  EXPECT_EQ(means.sampling[1].average, kSamples);
}

}  // namespace
}  // namespace mle
