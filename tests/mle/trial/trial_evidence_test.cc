#include "mle/trial/trial_evidence.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

// The mean of E over all sequences of values that are drawn evenly from
// `values`: exact, not sampled.
double MeanEvidence(const std::vector<double>& values, int responses,
                    double expected) {
  double sum = 0.0;
  int count = 0;
  std::vector<std::size_t> drawn(static_cast<std::size_t>(responses), 0);
  for (;;) {
    TrialEvidence evidence;
    for (const std::size_t i : drawn) evidence.Add(values[i], expected);
    sum += std::exp(evidence.log());
    ++count;
    std::size_t place = 0;
    while (place < drawn.size() && ++drawn[place] == values.size()) {
      drawn[place++] = 0;
    }
    if (place == drawn.size()) return sum / count;
  }
}

// What the level rests on: E has a mean of at most 1 where nothing is better,
// for symmetric differences of variance 1 whose fourth moment is 1 (a coin), 4
// (the largest allowed: ± 2 on a quarter of the responses), and for a mean
// below 0.
TEST(TrialEvidenceTest, IsExpectedToStayAtOneWhereNothingIsBetter) {
  for (const double expected : {0.5, 2.0, 10.0}) {
    for (const int responses : {1, 2, 5}) {
      EXPECT_LE(MeanEvidence({-1.0, 1.0}, responses, expected), 1.0 + 1e-12);
      EXPECT_LE(MeanEvidence({-2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0},
                             responses, expected),
                1.0 + 1e-12);
      EXPECT_LE(MeanEvidence({-3.0, -1.0}, responses, expected), 1.0);
    }
  }
}

TEST(TrialEvidenceTest, OneResponseIsNotEnoughTwoClearOnesAre) {
  TrialEvidence evidence;
  EXPECT_EQ(evidence.log(), 0.0);
  evidence.Add(1e6, 8.0);
  EXPECT_LT(evidence.log(), std::log(100.0));
  evidence.Add(4.0, 8.0);
  EXPECT_GT(evidence.log(), std::log(100.0));
}

TEST(TrialEvidenceTest, OneDisturbedResponseDoesNotEndIt) {
  TrialEvidence evidence;
  evidence.Add(-50.0, 8.0);
  EXPECT_LT(evidence.log(), 0.0);
  for (int n = 0; n < 5; ++n) evidence.Add(4.0, 8.0);
  EXPECT_GT(evidence.log(), std::log(100.0));
}

// Responses in which nothing is expected of the models are not bet on.
TEST(TrialEvidenceTest, WhatCannotTellChangesNothing) {
  TrialEvidence evidence;
  for (int n = 0; n < 20; ++n) evidence.Add(n % 2 == 0 ? 3.0 : -3.0, 0.0);
  EXPECT_NEAR(evidence.log(), 0.0, 1e-12);
}

}  // namespace
}  // namespace mle
