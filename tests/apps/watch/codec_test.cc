#include "apps/watch/codec.h"

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

void ExpectNear(const ScorePart& read, const ScorePart& written) {
  // 15 bits for the largest of a row.
  EXPECT_LT((read.score - written.score).norm(), 1e-4 * written.score.norm());
  EXPECT_LT((read.information - written.information).norm(),
            1e-4 * written.information.norm());
}

TEST(CodecTest, BatchesAreReadBack) {
  const StoredBatch stored = AnyBatch();
  const std::string bytes = EncodeBatch(stored);
  const auto read = DecodeBatch(bytes);
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
  const auto read = DecodeBatch(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_TRUE(read->batch.largest.has_value());
  ExpectNear(*read->batch.largest, *stored.batch.largest);
  EXPECT_EQ(EncodeBatch(*read), bytes);
}

TEST(CodecTest, RoundingIsThatOfTheState) {
  StoredBatch stored = AnyBatch();
  RoundAsKept(stored.batch);
  const auto read = DecodeBatch(EncodeBatch(stored));
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
    const auto read = DecodeBatch(bytes);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->batch.score, stored.batch.score) << pivot;
    EXPECT_EQ(read->batch.information, stored.batch.information) << pivot;
    EXPECT_EQ(read->batch.largest->score, stored.batch.largest->score);
    EXPECT_EQ(EncodeBatch(*read), bytes) << pivot;
  }
}

// As version 2 of the state has them: n, and all in single precision.
TEST(CodecTest, OlderScoresAreRead) {
  std::string bytes(1, 3);
  for (const float value :
       {1.5F, -2.0F, 0.1F, 4.0F, 1.0F, 3.0F, 0.5F, 0.2F, 2.0F, 1.25F, -0.5F}) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  const auto read = DecodeBatch(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  const StoredBatch any = AnyBatch();
  EXPECT_LT((read->batch.score - any.batch.score).norm(), 1e-7);
  EXPECT_LT((read->batch.information - any.batch.information).norm(), 1e-6);
  EXPECT_EQ(read->evidence.log_output, 1.25);
}

TEST(CodecTest, DamageIsFound) {
  const std::string bytes = EncodeBatch(AnyBatch());
  for (const std::string& damaged :
       {std::string(), bytes.substr(1), bytes + "x",
        bytes.substr(0, bytes.size() - 1), std::string("\x04") + bytes,
        bytes.substr(0, 2)}) {
    EXPECT_EQ(DecodeBatch(damaged).status().code(),
              absl::StatusCode::kDataLoss);
  }
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
