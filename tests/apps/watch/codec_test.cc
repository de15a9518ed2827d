#include "apps/watch/codec.h"

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::watch {
namespace {

StoredBatch AnyBatch() {
  StoredBatch stored;
  stored.batch.score = Eigen::VectorXd{{1.5, -2.0, 0.1}};
  stored.batch.information =
      Eigen::MatrixXd{{4.0, 1.0, 0.5}, {1.0, 3.0, 0.2}, {0.5, 0.2, 2.0}};
  stored.evidence.log_output = 1.25;
  stored.evidence.log_elements = {-0.5};
  return stored;
}

// All of the bytes.
absl::StatusOr<StoredBatch> ReadBack(const std::string& bytes) {
  std::string_view rest = bytes;
  absl::StatusOr<StoredBatch> read = TakeBatch(rest);
  EXPECT_TRUE(rest.empty());
  return read;
}

void ExpectNear(const ScorePart& read, const ScorePart& written) {
  // 11 bits for the largest beside a pivot.
  EXPECT_LT((read.score - written.score).norm(), 1e-3 * written.score.norm());
  EXPECT_LT((read.information - written.information).norm(),
            1e-3 * written.information.norm());
}

TEST(CodecTest, BatchesAreReadBack) {
  const StoredBatch stored = AnyBatch();
  const std::string bytes = EncodeBatch(stored);
  const auto read = ReadBack(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectNear({read->batch.score, read->batch.information},
             {stored.batch.score, stored.batch.information});
  EXPECT_FALSE(read->batch.largest.has_value());
  EXPECT_EQ(read->evidence.log_output, 1.25);
  EXPECT_EQ(read->evidence.log_elements, (std::vector<double>{-0.5}));
  // What was read once does not change any more.
  EXPECT_EQ(EncodeBatch(*read), bytes);
}

TEST(CodecTest, TheLargestChangeIsReadBack) {
  StoredBatch stored = AnyBatch();
  stored.batch.largest = {0.7 * stored.batch.score,
                          0.5 * stored.batch.information};
  const std::string bytes = EncodeBatch(stored);
  const auto read = ReadBack(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_TRUE(read->batch.largest.has_value());
  ExpectNear(*read->batch.largest, *stored.batch.largest);
  EXPECT_EQ(EncodeBatch(*read), bytes);
}

TEST(CodecTest, RoundingIsThatOfTheState) {
  StoredBatch stored = AnyBatch();
  RoundAsKept(stored.batch);
  const auto read = ReadBack(EncodeBatch(stored));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->batch.score, stored.batch.score);
  EXPECT_EQ(read->batch.information, stored.batch.information);
}

// Checksums of the state rest on it: whatever the scores are, what was rounded
// is read back exactly, and is the same bytes again.
TEST(CodecTest, WhatIsRoundedIsReadBackExactly) {
  for (const double pivot : {1.0, 1e-4, 3.2e-5, 3e-5, 1e-5, 0.0}) {
    StoredBatch stored = AnyBatch();
    // L, in whose last row little is left.
    const Eigen::MatrixXd factor{
        {2.0, 0.0, 0.0}, {0.3, 1.0, 0.0}, {0.5, 0.7, pivot}};
    stored.batch.information = factor * factor.transpose();
    stored.batch.score = factor * Eigen::VectorXd{{0.3, -1.0, 2.0}};
    stored.batch.largest = {0.5 * stored.batch.score,
                            0.25 * stored.batch.information};
    RoundAsKept(stored.batch);
    const std::string bytes = EncodeBatch(stored);
    const auto read = ReadBack(bytes);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->batch.score, stored.batch.score) << pivot;
    EXPECT_EQ(read->batch.information, stored.batch.information) << pivot;
    EXPECT_EQ(read->batch.largest->score, stored.batch.largest->score);
    EXPECT_EQ(EncodeBatch(*read), bytes) << pivot;
  }
}

TEST(CodecTest, EvidenceIsKeptInHundredthsAndNeverMoreThanItWas) {
  const ChangeEvidence kept = AsKept({.number = 3,
                                      .log_output = 5.2999,
                                      .log_elements = {-0.001, 400.003, -1e9}});
  EXPECT_EQ(kept.number, 3);
  EXPECT_EQ(kept.log_output, 5.29);
  EXPECT_EQ(kept.log_elements, (std::vector<double>{-0.01, 400.0, -1e6}));
  for (int hundredths = -1000; hundredths < 1000; ++hundredths) {
    StoredBatch stored = AnyBatch();
    stored.evidence = AsKept({.log_output = hundredths / 100.0,
                              .log_elements = {hundredths / 100.0}});
    EXPECT_EQ(stored.evidence.log_output, hundredths / 100.0);
    const std::string bytes = EncodeBatch(stored);
    EXPECT_EQ(ReadBack(bytes)->evidence.log_output, hundredths / 100.0);
  }
}

// In single precision anything can be written.
TEST(CodecTest, ScoresThatAreNoNumbersAreDamage) {
  for (const double value : {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    StoredBatch stored = AnyBatch();
    stored.batch.score(1) = value;
    std::string bytes = EncodeBatch(stored);
    std::string_view rest = bytes;
    EXPECT_FALSE(TakeBatch(rest).ok());
    stored = AnyBatch();
    stored.batch.largest = {stored.batch.score, stored.batch.information};
    stored.batch.largest->information(2, 2) = value;
    bytes = EncodeBatch(stored);
    rest = bytes;
    EXPECT_FALSE(TakeBatch(rest).ok());
  }
}

TEST(CodecTest, ScoresOfAllOutputsAreReadBack) {
  Watch watch;
  watch.outputs.resize(4);
  watch.outputs[1][8] = watch.outputs[2][8] = AnyBatch();
  watch.outputs[1][8].batch.length = 64;
  watch.outputs[3][9] = AnyBatch();
  EXPECT_EQ(EncodeScores(watch, 7), "");
  Watch read;
  ASSERT_TRUE(DecodeScores(EncodeScores(watch, 8), 8, read).ok());
  ASSERT_EQ(read.outputs.size(), 4U);
  EXPECT_TRUE(read.outputs[0].empty());
  EXPECT_EQ(read.outputs[1].at(8).batch.length, 64);
  EXPECT_EQ(read.outputs[1].at(8).evidence.number, 71);
  EXPECT_EQ(read.outputs[2].at(8).batch.number, 8);
  EXPECT_EQ(read.outputs[2].at(8).batch.length, 1);
  EXPECT_TRUE(read.outputs[3].empty());
  EXPECT_EQ(EncodeScores(read, 8), EncodeScores(watch, 8));
}

TEST(CodecTest, DaysOfABlockAreReadBack) {
  Watch watch;
  // 64 · 312 and the day before, and the last of its block.
  watch.days[19968] = {"sixteen bytes...", BatchState::kUsed, ""};
  watch.days[20031] = {std::string("\0x", 2), BatchState::kCannotTell,
                       std::string(20'000, 'r')};
  watch.days[19967] = {"", BatchState::kNothingMoved, "of another block"};
  EXPECT_EQ(BlockOf(19968), 312);
  EXPECT_EQ(BlockOf(20031), 312);
  EXPECT_EQ(BlockOf(19967), 311);
  EXPECT_EQ(BlockOf(-1), -1);
  EXPECT_EQ(BlockOf(-64), -1);
  EXPECT_EQ(BlockOf(-65), -2);
  EXPECT_EQ(EncodeDays(watch, 313), "");
  Watch read;
  ASSERT_TRUE(DecodeDays(EncodeDays(watch, 312), 312, read).ok());
  EXPECT_EQ(read.days.size(), 2U);
  ASSERT_TRUE(DecodeDays(EncodeDays(watch, 311), 311, read).ok());
  EXPECT_EQ(read.days, watch.days);
}

TEST(CodecTest, DamageIsFound) {
  Watch watch;
  watch.outputs = {{{5, AnyBatch()}}};
  const std::string bytes = EncodeScores(watch, 5);
  for (const std::string& damaged :
       {bytes.substr(1), bytes + "x", bytes.substr(0, bytes.size() - 1),
        std::string("\x04") + bytes, bytes.substr(0, 2),
        std::string("\x01\x03\x07") + bytes.substr(3),
        std::string("\x01\x04") + bytes.substr(2),
        std::string("\x01\xff\xff\xff\xff") + bytes.substr(2)}) {
    Watch read;
    EXPECT_EQ(DecodeScores(damaged, 5, read).code(),
              absl::StatusCode::kDataLoss);
  }
  watch.days[70] = {"checksum", BatchState::kUsed, "reason"};
  const std::string days = EncodeDays(watch, 1);
  for (const std::string& damaged :
       {days.substr(0, days.size() - 1), days + "x", days.substr(0, 1),
        std::string("\x40") + days.substr(1),
        days.substr(0, 1) + "\x07" + days.substr(2)}) {
    Watch read;
    EXPECT_EQ(DecodeDays(damaged, 1, read).code(), absl::StatusCode::kDataLoss);
  }
}

TEST(CodecTest, CovariancesAreRoundedToWhatIsKept) {
  WatchReference reference;
  reference.outputs.resize(1);
  reference.outputs[0].covariances = {1.0123456789, -0.0000004};
  RoundAsKept(reference);
  EXPECT_EQ(reference.outputs[0].covariances,
            (std::vector<double>{1.012346, 0.0}));
}

TEST(CodecTest, ReferencesAreReadBack) {
  WatchReference reference;
  OutputReference output;
  output.noise.variance = 0.1234567890123;
  output.noise.ratio = 1e-3;
  output.noise.colour_ratio = 0.5;
  output.noise.colour_pole = 0.9;
  output.noise.colour_damping = 1.5;
  output.deviation = 0.98;
  output.covariances = {1.0, 0.1, -0.05};
  reference.outputs = {output};
  reference.low = Eigen::VectorXd{{-1.0, 2.0}};
  reference.high = Eigen::VectorXd{{1.0, 3.0}};
  const std::string earlier = EncodeReference(reference);
  EXPECT_TRUE(DecodeReference(earlier)->operation.empty());
  EXPECT_EQ(EncodeReference(*DecodeReference(earlier)), earlier);
  reference.operation = {{.changes = 0.7, .change_size = 1.5},
                         {.squared_error = 0.25}};
  const auto read = DecodeReference(EncodeReference(reference));
  ASSERT_TRUE(read.ok()) << read.status();
  const OutputReference& found = read->outputs.front();
  EXPECT_EQ(found.noise.variance, output.noise.variance);
  EXPECT_EQ(found.noise.ratio, output.noise.ratio);
  EXPECT_EQ(found.noise.offset, output.noise.offset);
  EXPECT_EQ(found.noise.colour_ratio, output.noise.colour_ratio);
  EXPECT_EQ(found.noise.colour_pole, output.noise.colour_pole);
  EXPECT_EQ(found.noise.colour_damping, output.noise.colour_damping);
  EXPECT_EQ(found.deviation, output.deviation);
  EXPECT_EQ(found.covariances, output.covariances);
  EXPECT_EQ(read->low, reference.low);
  EXPECT_EQ(read->high, reference.high);
  ASSERT_EQ(read->operation.size(), 2U);
  EXPECT_EQ(read->operation[0].changes, 0.7);
  EXPECT_EQ(read->operation[0].change_size, 1.5);
  EXPECT_FALSE(read->operation[0].squared_error.has_value());
  EXPECT_EQ(read->operation[1].squared_error, 0.25);
  EXPECT_EQ(DecodeReference("{}").status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace mle::watch
