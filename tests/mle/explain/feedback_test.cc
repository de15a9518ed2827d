#include "mle/explain/feedback.h"

#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "mle/explain/competition.h"
#include "mle/explain/instruments.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

// The records with inputs that are held at random levels, whatever the outputs
// do: an experiment in open loop.
Record OpenLoops(const ProcessModel& plant, unsigned seed) {
  std::mt19937_64 random(1000 + seed);
  std::uniform_real_distribution<double> level(-1.0, 1.0);
  std::uniform_int_distribution<int> length(5, 40);
  std::vector<std::vector<double>> asked(2);
  for (auto& of_input : asked) {
    while (of_input.size() < 1600) {
      of_input.insert(of_input.end(), length(random), level(random));
    }
  }
  std::vector<std::size_t> at(2, 0);
  Happening happening;
  happening.input = [&](int j, double) { return asked[j][at[j]++]; };
  Record record = CloseLoops(plant, seed, happening);
  for (int k = 0; k < record.samples(); ++k) {
    for (int j = 0; j < 2; ++j) record.inputs(j, k) = asked[j][k];
  }
  record.set_points.setZero();
  return record;
}

double Probability(const std::vector<Record>& records, int i) {
  const auto output = ExplainedOutput::Create(TwoLoops(), records, i);
  EXPECT_TRUE(output.ok()) << output.status();
  const auto instruments = Instruments::Create(TwoLoops(), *output);
  EXPECT_TRUE(instruments.ok()) << instruments.status();
  const auto probability =
      FeedbackPValue(*output, instruments->Undriven(output->Residual({})));
  EXPECT_TRUE(probability.has_value());
  return probability.value_or(-1.0);
}

// Of 80 probabilities that are uniform one in five is below 0.2, ± 4.5 %.
TEST(FeedbackTest, WithoutFeedbackTheProbabilityIsUniform) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(3.0, 13.0, 2.0);
  int low = 0;
  int least = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const std::vector<Record> records = {OpenLoops(plant, seed)};
    for (int i = 0; i < 2; ++i) {
      const double p = Probability(records, i);
      low += p < 0.2 ? 1 : 0;
      least += p < 0.01 ? 1 : 0;
    }
  }
  EXPECT_GE(low, 5);
  EXPECT_LE(low, 30);
  EXPECT_LE(least, 4);
}

TEST(FeedbackTest, ControllersThatAnswerAreSeen) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::vector<Record> records = {CloseLoops(TwoLoops(), seed)};
    records[0].set_points.setZero();
    for (int i = 0; i < 2; ++i) EXPECT_LT(Probability(records, i), 1e-3);
  }
}

OutputExplanation FirstOutput(const Record& record, bool expected) {
  ExplainOptions options;
  options.expected.setConstant(2, 2, expected);
  const auto competition = Competition::Run(TwoLoops(), {record}, options);
  EXPECT_TRUE(competition.ok()) << competition.status();
  return competition->outputs()[0];
}

// One hypothesis needs less evidence than the best of a table.
TEST(FeedbackTest, WithoutFeedbackWhatIsExpectedNeedsLittleEvidence) {
  ProcessModel plant = TwoLoops();
  plant.element(0, 0) = TransferFunction::FirstOrder(2.08, 10.0, 2.0);
  const Record record = OpenLoops(plant, 3);
  const OutputExplanation alone = FirstOutput(record, false);
  ASSERT_TRUE(alone.open_loop());
  EXPECT_TRUE(alone.taken.empty() || alone.together);
  ASSERT_TRUE(alone.next.has_value());
  EXPECT_GT(alone.next->evidence, 3.0);
  const OutputExplanation expected = FirstOutput(record, true);
  ASSERT_EQ(expected.taken.size(), 1u);
  EXPECT_EQ(expected.taken[0].explanation.kind, ExplanationKind::kGain);
  EXPECT_EQ(expected.taken[0].explanation.index, 0);

  // Of set points it is asked for as ever.
  const Record loops = CloseLoops(plant, 3);
  EXPECT_EQ(FirstOutput(loops, true).taken.size(),
            FirstOutput(loops, false).taken.size());
}

TEST(FeedbackTest, TooFewRowsAreNotTested) {
  Happening happening;
  happening.samples = 20;
  const std::vector<Record> records = {CloseLoops(TwoLoops(), 1, happening)};
  const auto output = ExplainedOutput::Create(TwoLoops(), records, 0);
  ASSERT_TRUE(output.ok()) << output.status();
  EXPECT_FALSE(FeedbackPValue(*output, output->Residual({})).has_value());
}

}  // namespace
}  // namespace mle
