#include "mle/explain/competition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

Competition Compete(const std::vector<Record>& records, int threads = 1) {
  ExplainOptions options;
  options.threads = threads;
  auto competition = Competition::Run(TwoLoops(), records, options);
  EXPECT_TRUE(competition.ok()) << competition.status();
  return *std::move(competition);
}

std::vector<OutputExplanation> Explained(const std::vector<Record>& records) {
  return Compete(records).outputs();
}

ProcessModel Aged(int output, int input, double gain, double lag,
                  double delay) {
  ProcessModel plant = TwoLoops();
  const TransferFunction& element = plant.element(output, input);
  plant.element(output, input) = TransferFunction::FirstOrder(
      gain * element.StaticGain(), lag * element.TimeConstant(),
      element.delay() + delay);
  return plant;
}

std::vector<std::string> Taken(const OutputExplanation& output) {
  std::vector<std::string> taken;
  for (const TakenExplanation& one : output.taken) {
    taken.emplace_back(TypeOf(one.explanation.kind).code);
  }
  return taken;
}

using Codes = std::vector<std::string>;

TEST(CompetitionTest, WhereNothingHappenedNothingWins) {
  int taken = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const OutputExplanation& output :
         Explained({CloseLoops(TwoLoops(), seed)})) {
      ASSERT_TRUE(output.judged()) << output.unjudged;
      EXPECT_TRUE(output.by_set_points);
      EXPECT_LT(output.left(), 4.0);
      taken += static_cast<int>(output.taken.size());
    }
  }
  // 40 outputs at 0.03 % each, if the exponential holds.
  EXPECT_LE(taken, 1);
}

// The parameter that aged, alone and by its size, in its output alone.
TEST(CompetitionTest, TheParameterThatAgedIsNamed) {
  struct Case {
    int output, input;
    double gain, lag, delay;
    const char* code;
    double theta;
  };
  const std::vector<Case> cases = {
      {0, 0, 0.6, 1.0, 0.0, "gain", std::log(0.6)},
      {1, 1, 1.0, 1.7, 0.0, "time_constant", std::log(1.7)},
      {0, 0, 1.0, 1.0, 3.0, "dead_time", 3.0 / 12.0},
      {1, 0, 1.6, 1.0, 0.0, "gain", std::log(1.6)},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.code);
    const Competition competition = Compete(
        {CloseLoops(Aged(c.output, c.input, c.gain, c.lag, c.delay), 7)});
    const OutputExplanation& output = competition.outputs()[c.output];
    ASSERT_EQ(Taken(output), Codes{c.code});
    EXPECT_EQ(output.taken[0].explanation.index, c.input);
    const double error = output.taken[0].standard_error;
    EXPECT_GT(error, 0.0);
    EXPECT_NEAR(output.taken[0].explanation.value, c.theta, 4.0 * error + 0.01);
    EXPECT_TRUE(competition.outputs()[1 - c.output].taken.empty());
    // On blocks held out, every horizon.
    ASSERT_EQ(output.held_out.size(), 4);
    for (const HorizonErrors& horizon : output.held_out) {
      EXPECT_LT(horizon.explained, 1.05 * horizon.initial);
    }
    EXPECT_LT(output.held_out.back().explained,
              0.7 * output.held_out.back().initial);
  }
}

TEST(CompetitionTest, WhatHappenedToTheRecordIsNoAgeing) {
  Happening bent;
  bent.output = [](int output, double z) {
    return output == 0 ? z + 0.25 * z * z : z;
  };
  EXPECT_EQ(Taken(Compete({CloseLoops(TwoLoops(), 3, bent)}).outputs()[0]),
            Codes{"curved_output"});
  Happening limited;
  double position = 0.0;
  limited.input = [&position](int input, double asked) {
    if (input != 0) return asked;
    position += std::clamp(asked - position, -0.02, 0.02);
    return position;
  };
  EXPECT_EQ(Taken(Explained({CloseLoops(TwoLoops(), 3, limited)})[0]),
            Codes{"rate_limit"});
}

// What no record shows, and follows a set point.
TEST(CompetitionTest, ALoadThatComesWithSetPointsIsNoAgeing) {
  Happening feed;
  feed.load = [](int input, const Eigen::Vector2d& set_points) {
    return input == 0 ? 0.4 * set_points[1] : 0.0;
  };
  const Competition competition = Compete({CloseLoops(TwoLoops(), 3, feed)});
  for (const OutputExplanation& output : competition.outputs()) {
    ASSERT_EQ(Taken(output), Codes{"load_with_set_points"});
    EXPECT_EQ(output.taken[0].explanation.index, 0);
  }
}

// Late samples of an input are one clock, not two dead times; an output's too.
TEST(CompetitionTest, AClockOfATagIsOneExplanation) {
  Happening quiet;
  quiet.drift = 0.002;
  quiet.noise = 0.01;
  Record record = CloseLoops(TwoLoops(), 5, quiet);
  const Eigen::Index n = record.inputs.cols();
  const Eigen::RowVectorXd valve = record.inputs.row(0);
  record.inputs.row(0).head(n - 3) = valve.tail(n - 3);
  const Competition by_input = Compete({record});
  for (const OutputExplanation& output : by_input.outputs()) {
    EXPECT_EQ(Taken(output), Codes{"input_clock"});
  }
  EXPECT_NEAR(by_input.ClockOf(0, 0), 3.0, 0.3);
  EXPECT_NEAR(by_input.ClockOf(1, 0), 3.0, 0.3);
  EXPECT_EQ(by_input.ClockOf(0, 1), 0.0);

  record = CloseLoops(TwoLoops(), 5, quiet);
  const Eigen::RowVectorXd level = record.outputs.row(0);
  record.outputs.row(0).tail(n - 3) = level.head(n - 3);
  const Competition by_output = Compete({record});
  EXPECT_EQ(Taken(by_output.outputs()[0]), Codes{"output_clock"});
  EXPECT_NEAR(by_output.ClockOf(0, 0), 3.0, 0.3);
  EXPECT_TRUE(by_output.outputs()[1].taken.empty());
}

// Averages shift the only element of an output by half a sample, as its clock
// would; ageing by more.
TEST(CompetitionTest, TheOnlyDeadTimeIsAClockUpToASample) {
  ProcessModel model = TwoLoops();
  model.element(0, 1) = TransferFunction::FirstOrder(0.0, 14.0, 3.0);
  model.element(1, 0) = TransferFunction::FirstOrder(0.0, 12.0, 4.0);
  Happening quiet;
  quiet.drift = 0.002;
  quiet.noise = 0.005;
  for (const auto& [later, code] :
       {std::pair(0.5, "output_clock"), std::pair(-0.5, "output_clock"),
        std::pair(2.0, "dead_time")}) {
    SCOPED_TRACE(later);
    ProcessModel plant = model;
    plant.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 2.0 + later);
    const Competition competition = *Competition::Run(
        model, {CloseLoops(plant, 5, quiet)}, ExplainOptions());
    ASSERT_EQ(Taken(competition.outputs()[0]), Codes{code});
    const bool is_clock = later < 2.0;
    EXPECT_NEAR(competition.ClockOf(0, 0), is_clock ? later : 0.0, 0.15);
    EXPECT_NEAR(competition.Explained(0, 0).delay, is_clock ? 2.0 : 2.0 + later,
                0.15);
  }
}

// What is known of the averages is no reason to look for another explanation.
TEST(CompetitionTest, KnownAveragesAreTakenOffWhatIsLeft) {
  const Record record = CloseLoops(TwoLoops(), 5);
  ExplainOptions options;
  const OutputExplanation plain =
      Competition::Run(TwoLoops(), {record}, options)->outputs()[0];
  EXPECT_EQ(plain.averaging, 0.0);
  options.averages = {8.0, 0.0};
  const Competition known = *Competition::Run(TwoLoops(), {record}, options);
  EXPECT_GT(known.outputs()[0].averaging, 0.0);
  EXPECT_EQ(known.outputs()[0].remaining, plain.remaining);
  EXPECT_LT(known.outputs()[0].left(), plain.left());
  EXPECT_EQ(known.outputs()[1].averaging, 0.0);
}

// Every eighth sample of the first output, up to `late` samples early or late.
Record MeasuredNowAndThen(Record record, int late, unsigned seed) {
  std::mt19937_64 random(1000 + seed);
  std::uniform_int_distribution<int> error(-late, late);
  const Eigen::RowVectorXd all = record.outputs.row(0);
  record.outputs.row(0).setConstant(std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index k = 8; k + 8 < all.size(); k += 8) {
    record.outputs(0, k) = all(k + error(random));
  }
  return record;
}

// What set points drive is larger by what random errors of stamps make of it,
// which is no reason to look for another explanation. What is said of it is its
// order, rather less than more: half of it with these records.
TEST(CompetitionTest, ErrorsOfStampsAreOfTheOrderThatIsSaid) {
  constexpr int kErrors = 2;  // samples, at most: √2 of standard deviation
  double more = 0.0;
  double said = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Record record = CloseLoops(TwoLoops(), seed);
    ExplainOptions options;
    options.most = 1;
    options.stamp_errors = {std::sqrt(2.0) * record.sample_time, 0.0};
    const auto output = [&](int late) {
      return Competition::Run(TwoLoops(),
                              {MeasuredNowAndThen(record, late, seed)}, options)
          ->outputs()[0];
    };
    const OutputExplanation exact = output(0);
    const OutputExplanation off = output(kErrors);
    more += off.energy - exact.energy;
    said += off.stamps;
    EXPECT_LT(off.left(), off.remaining / off.chance);
  }
  EXPECT_GT(said, 0.0);
  EXPECT_GT(more, 0.7 * said);
  EXPECT_LT(more, 3.5 * said);
}

// A load that the controller answers is no change of the model, however large:
// inputs move with it, set points do not.
TEST(CompetitionTest, FeedbackFromADisturbanceIsNotAgeing) {
  Happening loaded;
  loaded.drift = 0.08;
  int taken = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const OutputExplanation& output :
         Explained({CloseLoops(TwoLoops(), seed, loaded)})) {
      taken += static_cast<int>(output.taken.size());
    }
  }
  EXPECT_LE(taken, 1);
}

TEST(CompetitionTest, UnitsChangeNothing) {
  const Record record = CloseLoops(Aged(0, 0, 0.7, 1.0, 0.0), 2);
  const Competition plain = Compete({record});
  ProcessModel scaled_model = TwoLoops();
  Record scaled = record;
  scaled.outputs.row(0) *= 1000.0;
  scaled.set_points.row(0) *= 1000.0;
  scaled.outputs.row(0).array() += 300.0;
  scaled.set_points.row(0).array() += 300.0;
  for (int j = 0; j < 2; ++j) {
    const TransferFunction& element = scaled_model.element(0, j);
    scaled_model.element(0, j) = TransferFunction::FirstOrder(
        1000.0 * element.StaticGain(), element.TimeConstant(), element.delay());
  }
  const auto other = Competition::Run(scaled_model, {scaled}, {});
  ASSERT_TRUE(other.ok()) << other.status();
  const OutputExplanation& a = plain.outputs()[0];
  const OutputExplanation& b = other->outputs()[0];
  ASSERT_EQ(Taken(a), Taken(b));
  EXPECT_NEAR(a.taken[0].explanation.value, b.taken[0].explanation.value, 1e-6);
  EXPECT_NEAR(a.left(), b.left(), 1e-6 * (1.0 + a.left()));
}

TEST(CompetitionTest, ThreadsChangeNoBit) {
  const std::vector<Record> records = {
      CloseLoops(Aged(1, 1, 1.5, 1.0, 1.0), 4)};
  const Competition one = Compete(records, 1);
  const Competition four = Compete(records, 4);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(one.outputs()[i].remaining, four.outputs()[i].remaining);
    ASSERT_EQ(one.outputs()[i].taken.size(), four.outputs()[i].taken.size());
  }
}

// Missing samples, in a block and here and there, and several records.
TEST(CompetitionTest, GapsAndSeveralRecords) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Happening half;
  half.samples = 800;
  std::vector<Record> records = {
      CloseLoops(Aged(0, 0, 0.6, 1.0, 0.0), 1, half),
      CloseLoops(Aged(0, 0, 0.6, 1.0, 0.0), 2, half)};
  records[0].outputs.row(0).segment(300, 60).setConstant(nan);
  for (int k = 5; k < 800; k += 7) records[1].outputs(0, k) = nan;
  records[1].inputs.row(1).segment(200, 30).setConstant(nan);
  const Competition competition = Compete(records);
  EXPECT_EQ(Taken(competition.outputs()[0]), Codes{"gain"});
  EXPECT_NEAR(competition.Explained(0, 0).gain, 1.2, 0.1);
}

// Together they look like a smaller change; apart each shows its own.
TEST(CompetitionTest, WhatChangedBetweenRecordsIsNoGainOfBoth) {
  Happening half;
  half.samples = 800;
  const std::vector<Record> records = {
      CloseLoops(TwoLoops(), 1, half),
      CloseLoops(Aged(0, 0, 0.5, 1.0, 0.0), 2, half)};
  const Competition competition = Compete(records);
  const OutputExplanation& output = competition.outputs()[0];
  const Codes taken = Taken(output);
  EXPECT_NE(std::find(taken.begin(), taken.end(), "change_during_record"),
            taken.end());
  EXPECT_LT(output.left(), 4.0);
  // What holds at the end.
  EXPECT_NEAR(competition.Explained(0, 0).gain, 1.0, 0.15);
  const double error = std::sqrt(competition.Covariance(0, 0)(0, 0));
  EXPECT_NEAR(competition.Explained(0, 0).gain, 1.0, 4.0 * error);
  EXPECT_GT(error, 0.0);
}

TEST(ExplanationTest, AChangeDuringTheRecordsHoldsAtTheirEndOrIsOver) {
  const auto at_end = [](int part) {
    return GainAtEnd({{.kind = ExplanationKind::kChangeDuringRecord,
                       .index = 1,
                       .value = -0.5,
                       .part = part}},
                     1);
  };
  for (const int part : {0, 4, 5, 6, 7}) EXPECT_EQ(at_end(part), 0.5) << part;
  for (const int part : {1, 2, 3}) EXPECT_EQ(at_end(part), 1.0) << part;
  EXPECT_EQ(GainAtEnd({}, 1), 1.0);
  EXPECT_EQ(ShareOfChange(0, 0.25), 0.25);
  EXPECT_EQ(ShareOfChange(2, 0.24), 0.0);
  EXPECT_EQ(ShareOfChange(2, 0.26), 1.0);
  EXPECT_EQ(ShareOfChange(6, 0.49), 0.0);
  EXPECT_EQ(ShareOfChange(6, 0.51), 1.0);
}

TEST(ExplanationTest, ALargeChangeOfAnElementIsImprobable) {
  for (const ExplanationKind kind :
       {ExplanationKind::kGain, ExplanationKind::kTimeConstant,
        ExplanationKind::kDeadTime}) {
    EXPECT_EQ(PriorCost({kind, 0, 0.0}), 0.0);
    EXPECT_EQ(PriorCost({kind, 0, 0.5}), 0.0);
    EXPECT_NEAR(PriorCost({kind, 0, 0.72}), 0.22, 1e-12);
    EXPECT_NEAR(PriorCost({kind, 1, -1.2}), 1.5, 1e-12);
  }
  EXPECT_EQ(PriorCost({ExplanationKind::kCurvedInput, 0, 1.2}), 0.0);
  EXPECT_EQ(PriorCost({ExplanationKind::kRateLimit, 0, 3.0}), 0.0);
}

TEST(CompetitionTest, WithoutAnythingThatMovesThereIsNoJudge) {
  Record record = CloseLoops(TwoLoops(), 1);
  record.set_points.setConstant(1.0);
  record.inputs.setConstant(2.0);
  for (const OutputExplanation& output : Explained({record})) {
    EXPECT_FALSE(output.judged());
    EXPECT_TRUE(output.taken.empty());
  }
  record.outputs.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(Compete({record}).outputs()[0].judged());
}

// Exact records: nothing is left to chance, and nothing is NaN.
TEST(CompetitionTest, ExactRecordsAreNoNaN) {
  Happening exact;
  exact.noise = 0.0;
  exact.drift = 0.0;
  const Competition same = Compete({CloseLoops(TwoLoops(), 1, exact)});
  for (const OutputExplanation& output : same.outputs()) {
    EXPECT_TRUE(output.taken.empty());
    EXPECT_TRUE(std::isfinite(output.left()));
  }
  const Competition aged =
      Compete({CloseLoops(Aged(0, 0, 0.6, 1.0, 0.0), 1, exact)});
  EXPECT_NEAR(aged.Explained(0, 0).gain, 1.2, 0.01);
  ASSERT_FALSE(aged.outputs()[0].held_out.empty());
  for (const HorizonErrors& error : aged.outputs()[0].held_out) {
    EXPECT_TRUE(std::isfinite(error.deviations));
    EXPECT_GT(error.deviations, 1.5);
  }
}

TEST(CompetitionTest, OtherModelsAreJudgedByWhatTheyLeave) {
  const ProcessModel plant = Aged(0, 0, 0.6, 1.0, 0.0);
  const std::vector<Record> records = {CloseLoops(plant, 6)};
  const Competition competition = Compete(records);
  const OutputExplanation& output = competition.outputs()[0];
  const Competition::Energies right = competition.EnergiesOf(0, plant);
  EXPECT_LT(right.remaining, output.remaining + 3.0 * output.unit);
  EXPECT_GT(right.difference, output.required * output.unit);
  const Competition::Energies same = competition.EnergiesOf(0, TwoLoops());
  EXPECT_NEAR(same.remaining, output.energy, 1e-9 * output.energy);
  EXPECT_NEAR(same.difference, 0.0, 1e-9 * output.energy);
}

TEST(ExplainOptionsTest, NameTheFieldThatIsWrong) {
  ExplainOptions options;
  options.evidence = 0.0;
  EXPECT_EQ(options.Validate().message(),
            "explain.evidence = 0: it must be finite and greater than 0");
  options = {};
  options.most = 0;
  EXPECT_EQ(options.Validate().message(),
            "explain.most = 0: it must be at least 1");
}

}  // namespace
}  // namespace mle
