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

TEST(CodecTest, BatchesAreReadBackToSinglePrecision) {
  const StoredBatch stored = AnyBatch();
  const std::string bytes = EncodeBatch(stored);
  const auto read = DecodeBatch(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_LT((read->batch.score - stored.batch.score).norm(), 1e-7);
  EXPECT_LT((read->batch.information - stored.batch.information).norm(), 1e-6);
  EXPECT_EQ(read->evidence.log_output, 1.25);
  EXPECT_EQ(read->evidence.log_elements, (std::vector<double>{-0.5}));
  // What was read once does not change any more.
  EXPECT_EQ(EncodeBatch(*read), bytes);
}

TEST(CodecTest, RoundingIsThatOfTheState) {
  BatchOutput output;
  output.score = AnyBatch().batch.score;
  output.information = AnyBatch().batch.information;
  output = AsKept(std::move(output));
  StoredBatch stored = AnyBatch();
  stored.batch.score = output.score;
  stored.batch.information = output.information;
  const auto read = DecodeBatch(EncodeBatch(stored));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->batch.score, output.score);
  EXPECT_EQ(read->batch.information, output.information);
}

TEST(CodecTest, DamageIsFound) {
  const std::string bytes = EncodeBatch(AnyBatch());
  for (const std::string& damaged :
       {std::string(), bytes.substr(1), bytes + "x",
        bytes.substr(0, bytes.size() - 1), std::string("\x04") + bytes}) {
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
  EXPECT_EQ(DecodeReference("{}").status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace mle::watch
