#include <cstring>
#include <limits>
#include <string>

#include "apps/watch/state.h"
#include "gtest/gtest.h"

namespace mle::watch {
namespace {

StoredBatch AnyBatch() {
  StoredBatch stored;
  stored.batch.number = 8;
  stored.batch.length = 64;
  stored.batch.score = Eigen::VectorXd{{1.5, -2.0, 0.1}};
  stored.batch.information =
      Eigen::MatrixXd{{4.0, 1.0, 0.5}, {1.0, 3.0, 0.2}, {0.5, 0.2, 2.0 / 3.0}};
  stored.evidence.log_output = 1.25;
  stored.evidence.log_elements = {-1.0 / 3.0};
  return stored;
}

std::string WithNumber(std::string bytes, std::size_t place, double number) {
  std::memcpy(bytes.data() + place * sizeof(number), &number, sizeof(number));
  return bytes;
}

// What is computed from the state, and checksums, rest on it.
TEST(CodecTest, BatchesComeBackToTheBit) {
  StoredBatch stored = AnyBatch();
  for (const bool has_largest : {false, true}) {
    if (has_largest) {
      stored.batch.largest = {stored.batch.score / 7.0,
                              stored.batch.information / 7.0};
    }
    const auto read = DecodeBatch(EncodeBatch(stored), 8, 64);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->batch.number, 8);
    EXPECT_EQ(read->batch.length, 64);
    EXPECT_EQ(read->batch.score, stored.batch.score);
    EXPECT_EQ(read->batch.information, stored.batch.information);
    ASSERT_EQ(read->batch.largest.has_value(), has_largest);
    if (has_largest) {
      EXPECT_EQ(read->batch.largest->score, stored.batch.largest->score);
      EXPECT_EQ(read->batch.largest->information,
                stored.batch.largest->information);
    }
    EXPECT_EQ(read->evidence.number, 71);
    EXPECT_EQ(read->evidence.log_output, stored.evidence.log_output);
    EXPECT_EQ(read->evidence.log_elements, stored.evidence.log_elements);
  }
}

TEST(CodecTest, DamageIsFound) {
  const std::string bytes = EncodeBatch(AnyBatch());
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const std::string& damaged :
       {std::string(), bytes.substr(1), bytes.substr(8), bytes + "x",
        bytes + std::string(8, '\0'), bytes.substr(0, bytes.size() - 8),
        WithNumber(bytes, 0, 4.0), WithNumber(bytes, 0, 3.5),
        WithNumber(bytes, 0, 0.0), WithNumber(bytes, 0, -3.0),
        WithNumber(bytes, 0, 1e300), WithNumber(bytes, 0, kNan),
        WithNumber(bytes, 1, 1.0), WithNumber(bytes, 1, -1.0),
        // Scores and evidence that are not numbers.
        WithNumber(bytes, 2, kNan), WithNumber(bytes, 7, kInfinity),
        WithNumber(bytes, 11, kNan), WithNumber(bytes, 12, kNan)}) {
    EXPECT_EQ(DecodeBatch(damaged, 5, 1).status().code(),
              absl::StatusCode::kDataLoss);
  }
  EXPECT_TRUE(DecodeBatch(bytes, 5, 1).ok());
  EXPECT_FALSE(DecodeBatch(bytes, -1, 1).ok());
  EXPECT_FALSE(DecodeBatch(bytes, 5, 0).ok());
}

TEST(CodecTest, ReferencesAreReadBack) {
  WatchReference reference;
  OutputReference output;
  output.noise.variance = 0.1234567890123;
  output.noise.ratio = 1e-3;
  output.noise.ar_ratio = 0.5;
  output.noise.ar_pole = 0.9;
  output.noise.ar_damping = 1.5;
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
  EXPECT_EQ(found.noise.ar_ratio, output.noise.ar_ratio);
  EXPECT_EQ(found.noise.ar_pole, output.noise.ar_pole);
  EXPECT_EQ(found.noise.ar_damping, output.noise.ar_damping);
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
