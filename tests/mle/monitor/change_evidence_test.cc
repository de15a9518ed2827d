#include "mle/monitor/change_evidence.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A positive definite matrix of the size of `scale`.
MatrixXd DrawInformation(int n, double scale, GaussianNoise& noise) {
  const MatrixXd root = noise.DrawMatrix(n, n + 2, 1.0);
  return scale / n * root * root.transpose();
}

// A batch of parameters `change` off what the scores are taken at.
ScoredBatch DrawBatch(int number, double scale, const VectorXd& change,
                      GaussianNoise& noise) {
  const auto n = static_cast<int>(change.size());
  ScoredBatch batch;
  batch.number = number;
  batch.information = DrawInformation(n, scale, noise);
  batch.score =
      batch.information * change +
      batch.information.llt().matrixL() * noise.DrawMatrix(n, 1, 1.0).col(0);
  return batch;
}

TEST(WeightOfBeginTest, WeightsAddUpToOne) {
  for (const int life : {64, 100, 3650}) {
    double sum = 0.0;
    for (int d = -10; d < life + 100; ++d) sum += WeightOfBegin(d, life);
    EXPECT_NEAR(sum, 1.0, 1e-12) << life;
  }
}

TEST(WeightOfBeginTest, LateBeginsWeighAsMuchAsEarlyOnes) {
  EXPECT_EQ(WeightOfBegin(64, 3650), WeightOfBegin(3584, 3650));
  EXPECT_EQ(WeightOfBegin(1, 3650), WeightOfBegin(3649, 3650));
  EXPECT_EQ(WeightOfBegin(3650, 3650), 0.0);
}

// The definition in the header by quadrature over θ and δ, for one parameter.
double RatioByQuadrature(double before_score, double before_information,
                         double score, double information, double least,
                         const WatchOptions& options) {
  const auto density = [](double x, double deviation) {
    return std::exp(-0.5 * x * x / (deviation * deviation)) /
           (deviation * std::sqrt(2.0 * M_PI));
  };
  const auto likelihood = [&](double change) {
    double sum = 0.0;
    constexpr double kStep = 1e-3;
    for (double theta = -0.4; theta <= 0.4; theta += kStep) {
      const double after = theta + change;
      sum += kStep * density(theta, options.model_error) *
             std::exp(theta * before_score -
                      0.5 * theta * theta * before_information + after * score -
                      0.5 * after * after * information);
    }
    return sum;
  };
  double mixture = 0.0;
  constexpr double kStep = 2e-3;
  for (double change = -2.0; change <= 2.0; change += kStep) {
    mixture += kStep * likelihood(change) * 0.5 *
               (density(change, options.change_deviation) +
                density(change, options.change_deviation / 6.0));
  }
  double null = 0.0;
  for (int i = -100; i <= 100; ++i) {
    null = std::max(null, likelihood(least * i / 100.0));
  }
  return mixture / null;
}

TEST(EvidenceOfTest, IsTheMixtureOfLikelihoodRatios) {
  const WatchOptions options;
  const VectorXd least = VectorXd::Constant(3, 0.01);
  // Independent parameters.
  std::vector<ScoredBatch> batches(2);
  batches[0] = {.number = 0,
                .length = 1,
                .score = VectorXd{{10.0, -5.0, 0.0}},
                .information = VectorXd{{400.0, 90.0, 25.0}}.asDiagonal()};
  batches[1] = {.number = 5,
                .length = 1,
                .score = VectorXd{{40.0, 3.0, -8.0}},
                .information = VectorXd{{300.0, 60.0, 100.0}}.asDiagonal()};
  double expected = 0.0;
  double begun = 0.0;
  for (int s = 0; s < 2; ++s) {
    double weight = 0.0;
    for (int d = s == 0 ? 0 : 1; d <= batches[s].number; ++d) {
      weight += WeightOfBegin(d, options.life);
    }
    begun += weight;
    for (int a = 0; a < 3; ++a) {
      const double score = batches[0].score(a);
      const double information = batches[0].information(a, a);
      expected +=
          weight / 3.0 *
          RatioByQuadrature(
              s == 0 ? 0.0 : score, s == 0 ? 0.0 : information,
              batches[1].score(a) + (s == 0 ? score : 0.0),
              batches[1].information(a, a) + (s == 0 ? information : 0.0),
              least(a), options);
    }
  }
  const ChangeEvidence evidence = EvidenceOf(batches, least, options);
  EXPECT_EQ(evidence.number, 5);
  // The accuracy of the quadrature.
  EXPECT_NEAR(evidence.log_output, std::log(expected + 1.0 - begun), 1e-5);
  // One element alone is the output.
  EXPECT_NEAR(evidence.log_elements[0], evidence.log_output, 1e-12);
}

TEST(EvidenceOfTest, IsOneWithoutBatches) {
  EXPECT_EQ(EvidenceOf({}, VectorXd(), WatchOptions()).log_output, 0.0);
}

// One batch of many that shows a change is no evidence, two are.
TEST(ConfirmedEvidenceOfTest, ASingleBatchIsNoEvidence) {
  const WatchOptions options;
  const VectorXd least = VectorXd::Zero(3);
  GaussianNoise noise(3, kRunStream);
  std::vector<ScoredBatch> batches;
  for (int number = 0; number < 20; ++number) {
    batches.push_back(DrawBatch(number, 1000.0, VectorXd::Zero(3), noise));
  }
  const VectorXd change{{0.0, 1.0, 0.0}};
  const auto disturbed = [&](int number) {
    batches[number].score += batches[number].information * change;
  };
  disturbed(19);
  EXPECT_GT(EvidenceOf(batches, least, options).log_output, 8.0);
  const ChangeEvidence one = ConfirmedEvidenceOf(batches, least, options);
  EXPECT_LT(one.log_output, 1.0);
  EXPECT_LT(one.log_elements[0], 1.0);
  disturbed(18);
  const ChangeEvidence two = ConfirmedEvidenceOf(batches, least, options);
  EXPECT_GT(two.log_output, 5.0);
  EXPECT_GT(two.log_elements[0], 5.0);
  // Never more than all of it; of nothing nothing.
  EXPECT_LE(two.log_output, EvidenceOf(batches, least, options).log_output);
  EXPECT_EQ(ConfirmedEvidenceOf({}, least, options).log_output, 0.0);
}

// Both in nine parameters that are correlated, with a change in one.
TEST(ElementEvidenceOfTest, IsThatOfTheElementAmongAll) {
  const WatchOptions options;
  const VectorXd least = VectorXd::Constant(9, 0.005);
  GaussianNoise noise(4, kRunStream);
  std::vector<ScoredBatch> batches;
  for (int number = 0; number < 12; ++number) {
    const MatrixXd sensitivities = noise.DrawMatrix(9, 30, 100.0);
    ScoredBatch batch{.number = number,
                      .length = 1,
                      .score = sensitivities * noise.DrawMatrix(30, 1, 1.0),
                      .information = sensitivities * sensitivities.transpose()};
    if (number > 6) batch.score += 0.1 * batch.information.col(4);
    batches.push_back(std::move(batch));
  }
  const ChangeEvidence all = EvidenceOf(batches, least, options);
  const ChangeEvidence confirmed = ConfirmedEvidenceOf(batches, least, options);
  for (int e = 0; e < 3; ++e) {
    EXPECT_EQ(ElementEvidenceOf(batches, e, least, options),
              all.log_elements[e]);
    EXPECT_EQ(ConfirmedElementEvidenceOf(batches, e, least, options),
              confirmed.log_elements[e]);
  }
  EXPECT_LT(confirmed.log_elements[1], all.log_elements[1] - 0.1);
  EXPECT_EQ(ElementEvidenceOf({}, 0, least, options), 0.0);
  EXPECT_EQ(ConfirmedElementEvidenceOf({}, 0, least, options), 0.0);
}

// Two changes of one batch confirm each other.
TEST(ConfirmedEvidenceOfTest, OfABatchTheLargestChangeIsLeftOut) {
  const WatchOptions options;
  const VectorXd least = VectorXd::Zero(3);
  GaussianNoise noise(3, kRunStream);
  std::vector<ScoredBatch> batches;
  for (int number = 0; number < 20; ++number) {
    batches.push_back(DrawBatch(number, 1000.0, VectorXd::Zero(3), noise));
  }
  const VectorXd change{{0.0, 1.0, 0.0}};
  ScoredBatch& last = batches.back();
  last.score += last.information * change;
  // A third of its information has a third of the change, or all of it.
  ScorePart part = {last.score / 3.0, last.information / 3.0};
  last.largest = part;
  EXPECT_GT(ConfirmedEvidenceOf(batches, least, options).log_output, 8.0);
  part.score = last.score;
  last.largest = part;
  EXPECT_LT(ConfirmedEvidenceOf(batches, least, options).log_output, 1.0);
  // Blocks forget it.
  const std::vector<ScoredBatch> merged = MergeOld(batches, 200);
  EXPECT_FALSE(merged.back().largest.has_value());
}

// Looked at after every batch of a life, E reaches 1/ε with a probability of ε
// at most.
TEST(EvidenceOfTest, NeverReachesItsLevelTooOften) {
  WatchOptions options;
  options.life = 64;
  constexpr int kLives = 400;
  constexpr double kLevel = 0.1;
  const VectorXd least = VectorXd::Zero(6);
  int outputs = 0;
  int elements = 0;
  for (int life = 0; life < kLives; ++life) {
    GaussianNoise noise(7, kRunStream + life);
    const VectorXd error = noise.DrawMatrix(6, 1, options.model_error).col(0);
    std::vector<ScoredBatch> batches;
    double output = 0.0;
    double element = 0.0;
    for (int b = 0; b < options.life; ++b) {
      batches.push_back(DrawBatch(b, 2000.0, error, noise));
      const ChangeEvidence evidence = EvidenceOf(batches, least, options);
      output = std::max(output, evidence.log_output);
      element = std::max(element, evidence.log_elements[1]);
    }
    outputs += output >= -std::log(kLevel) ? 1 : 0;
    elements += element >= -std::log(kLevel) ? 1 : 0;
  }
  // Three standard deviations of the share.
  const double most = kLives * (kLevel + 3.0 * std::sqrt(kLevel / kLives));
  EXPECT_LE(outputs, most);
  EXPECT_LE(elements, most);
}

class ChangedElementTest : public ::testing::Test {
 protected:
  // Forty batches, the gain of the first of two elements 20 % off from 20 on.
  std::vector<ScoredBatch> Batches(std::uint64_t seed) const {
    GaussianNoise noise(seed, kRunStream);
    std::vector<ScoredBatch> batches;
    for (int b = 0; b < 40; ++b) {
      VectorXd change = VectorXd::Zero(6);
      if (b >= 20) change(0) = -0.2;
      batches.push_back(DrawBatch(b, 300.0, change, noise));
    }
    return batches;
  }

  const WatchOptions options_ = {};
  const VectorXd least_ = VectorXd::Constant(6, 0.005);
};

TEST_F(ChangedElementTest, IsFoundAndDescribed) {
  const std::vector<ScoredBatch> batches = Batches(3);
  const ChangeEvidence evidence = EvidenceOf(batches, least_, options_);
  EXPECT_GT(evidence.log_output, std::log(1000.0));
  EXPECT_GT(evidence.log_elements[0], std::log(1000.0));
  const LikelyChange likely = ExplainEvidence(batches, least_, options_);
  EXPECT_EQ(likely.element, 0);
  EXPECT_EQ(likely.parameter, 0);
  EXPECT_GT(likely.probability, 0.9);
  EXPECT_NEAR(likely.change, -0.2, 4.0 * likely.error);
  EXPECT_NEAR(likely.begin, 20, 3);
}

TEST_F(ChangedElementTest, IsNotBlamedOnOthers) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const std::vector<ScoredBatch> batches = Batches(seed);
    for (std::size_t b = 20; b <= batches.size(); b += 4) {
      const std::vector<ScoredBatch> until(batches.begin(),
                                           batches.begin() + b);
      EXPECT_LT(EvidenceOf(until, least_, options_).log_elements[1],
                std::log(20.0))
          << seed << ", " << b;
    }
  }
}

TEST_F(ChangedElementTest, WhatIsNoChangeIsNotFound) {
  const std::vector<ScoredBatch> batches = Batches(3);
  const VectorXd least = VectorXd::Constant(6, 0.3);
  EXPECT_LT(EvidenceOf(batches, least, options_).log_output, std::log(10.0));
}

TEST(MergeOldTest, SumsStayAndRecentBatchesDo) {
  GaussianNoise noise(1, kRunStream);
  std::vector<ScoredBatch> batches;
  for (int b = 3; b < 700; ++b) {
    batches.push_back(DrawBatch(b, 10.0, VectorXd::Zero(3), noise));
  }
  const std::vector<ScoredBatch> merged = MergeOld(batches, 699);
  // 72 to 135 days, and blocks.
  EXPECT_LT(merged.size(), 140);
  VectorXd score = VectorXd::Zero(3);
  int next = 0;
  for (const ScoredBatch& batch : merged) {
    EXPECT_GE(batch.number, next);
    next = batch.number + batch.length;
    score += batch.score;
    if (batch.number > 699 - 64) {
      EXPECT_EQ(batch.length, 1);
    }
  }
  for (const ScoredBatch& batch : batches) score -= batch.score;
  EXPECT_LT(score.norm(), 1e-9);
}

TEST(MergeOldTest, DoesNotDependOnWhenItIsDone) {
  GaussianNoise noise(1, kRunStream);
  std::vector<ScoredBatch> at_once;
  std::vector<ScoredBatch> daily;
  for (int b = 0; b < 700; b += 2) {
    at_once.push_back(DrawBatch(b, 10.0, VectorXd::Zero(3), noise));
    daily.push_back(at_once.back());
    daily = MergeOld(daily, b);
  }
  at_once = MergeOld(at_once, 698);
  ASSERT_EQ(daily.size(), at_once.size());
  for (std::size_t b = 0; b < daily.size(); ++b) {
    EXPECT_EQ(daily[b].number, at_once[b].number);
    EXPECT_EQ(daily[b].length, at_once[b].length);
    EXPECT_LT((daily[b].score - at_once[b].score).norm(), 1e-9);
  }
}

TEST(ExplainEvidenceTest, OneElementIsCertainAndNoneIsNot) {
  const std::vector<ScoredBatch> batches = {
      {.number = 0,
       .score = VectorXd::Zero(3),
       .information = MatrixXd::Identity(3, 3)}};
  EXPECT_EQ(ExplainEvidence({}, VectorXd::Zero(3), WatchOptions()).probability,
            0.0);
  EXPECT_EQ(
      ExplainEvidence(batches, VectorXd::Zero(3), WatchOptions()).probability,
      1.0);
}

TEST(HealthOfTest, IsOneHalfWhereAnAlarmIsRaised) {
  EXPECT_DOUBLE_EQ(HealthOf(std::log(80.0), 1.0 / 80.0), 0.5);
  EXPECT_NEAR(HealthOf(0.0, 0.0125), 1.0 / 1.0125, 1e-15);
  EXPECT_EQ(HealthOf(1e6, 0.0125), 0.0);
}

}  // namespace
}  // namespace mle
