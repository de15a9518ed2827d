#include "mle/maintain/operator_mistakes.h"

#include <functional>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "tests/mle/data/loop_records.h"
#include "tests/mle/maintain/large_plant.h"

namespace mle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::LoopModel;
using testing::LoopOptions;
using testing::LoopRecord;
using Kind = OperatorMistake::Kind;

std::optional<OperatorMistake> Find(const Record& record,
                                    const ProcessModel& model = LoopModel()) {
  return *FindOperatorMistake(model, {record});
}

// Clean, with a drift, rounded.
std::vector<Record> Records() {
  std::vector<Record> records = {LoopRecord({.seed = 1}),
                                 LoopRecord({.walk = 0.003, .seed = 2}),
                                 LoopRecord({.seed = 3})};
  testing::Quantise(0.05, records.back().outputs);
  return records;
}

ProcessModel WithTimes(double factor) {
  ProcessModel model = LoopModel();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const TransferFunction& g = model.element(i, j);
      model.element(i, j) = TransferFunction::FirstOrder(
          g.StaticGain(), factor * g.TimeConstant(), factor * g.delay());
    }
  }
  return model;
}

TEST(OperatorMistakesTest, FindsExchangedTags) {
  for (Record record : Records()) {
    Record inputs = record;
    inputs.inputs.row(0).swap(inputs.inputs.row(1));
    auto mistake = Find(inputs);
    ASSERT_TRUE(mistake.has_value());
    EXPECT_EQ(mistake->kind, Kind::kExchanged);
    EXPECT_FALSE(mistake->outputs);
    EXPECT_THAT(mistake->channels, ElementsAre(0, 1));
    EXPECT_GT(mistake->log_likelihood, 50.0);
    EXPECT_THAT(mistake->Describe(LoopModel()), HasSubstr("u1 and u2"));

    record.outputs.row(0).swap(record.outputs.row(1));
    mistake = Find(record);
    ASSERT_TRUE(mistake.has_value());
    EXPECT_EQ(mistake->kind, Kind::kExchanged);
    EXPECT_TRUE(mistake->outputs);
  }
}

TEST(OperatorMistakesTest, FindsAReversedSign) {
  for (const Record& record : Records()) {
    for (int channel = 0; channel < 2; ++channel) {
      for (const bool output : {false, true}) {
        Record reversed = record;
        (output ? reversed.outputs : reversed.inputs).row(channel) *= -1.0;
        const auto mistake = Find(reversed);
        ASSERT_TRUE(mistake.has_value());
        EXPECT_EQ(mistake->kind, Kind::kSign);
        EXPECT_EQ(mistake->outputs, output);
        EXPECT_THAT(mistake->channels, ElementsAre(channel));
      }
    }
  }
}

TEST(OperatorMistakesTest, FindsAnotherUnit) {
  for (const Record& record : Records()) {
    for (const double factor : {100.0, 0.01, 60.0, 1.0 / 60.0, 1000.0, 1e-3}) {
      Record input = record;
      input.inputs.row(1) /= factor;
      auto mistake = Find(input);
      ASSERT_TRUE(mistake.has_value()) << factor;
      EXPECT_EQ(mistake->kind, Kind::kFactor);
      EXPECT_NEAR(mistake->factor / factor, 1.0, 1e-12);
      EXPECT_FALSE(mistake->outputs);
      EXPECT_THAT(mistake->channels, ElementsAre(1));

      Record output = record;
      output.outputs.row(0) *= factor;
      mistake = Find(output);
      ASSERT_TRUE(mistake.has_value()) << factor;
      EXPECT_NEAR(mistake->factor / factor, 1.0, 1e-12);
      EXPECT_TRUE(mistake->outputs);
      EXPECT_FALSE(mistake->ambiguous);
    }
  }
}

TEST(OperatorMistakesTest, FindsFahrenheit) {
  Record record = LoopRecord();
  record.outputs.row(1) = record.outputs.row(1).array() * 1.8 + 32.0;
  const auto mistake = Find(record);
  ASSERT_TRUE(mistake.has_value());
  EXPECT_EQ(mistake->factor, 1.8);
  EXPECT_THAT(mistake->Describe(LoopModel()), HasSubstr("Fahrenheit"));
}

TEST(OperatorMistakesTest, FindsMistakesInLargePlants) {
  const ProcessModel model = testing::LargeModel();
  const Record record = testing::LargeRecord();
  EXPECT_FALSE(Find(record, model).has_value());
  Record exchanged = record;
  exchanged.inputs.row(3).swap(exchanged.inputs.row(29));
  auto mistake = Find(exchanged, model);
  ASSERT_TRUE(mistake.has_value());
  EXPECT_EQ(mistake->kind, Kind::kExchanged);
  EXPECT_FALSE(mistake->outputs);
  EXPECT_THAT(mistake->channels, ElementsAre(3, 29));
  exchanged = record;
  exchanged.outputs.row(2).swap(exchanged.outputs.row(14));
  mistake = Find(exchanged, model);
  ASSERT_TRUE(mistake.has_value());
  EXPECT_TRUE(mistake->outputs);
  EXPECT_THAT(mistake->channels, ElementsAre(2, 14));
  Record reversed = record;
  reversed.inputs.row(11) *= -1.0;
  mistake = Find(reversed, model);
  ASSERT_TRUE(mistake.has_value());
  EXPECT_EQ(mistake->kind, Kind::kSign);
  EXPECT_THAT(mistake->channels, ElementsAre(11));
}

// All inputs in fractions are one mistake.
TEST(OperatorMistakesTest, JoinsChannels) {
  Record record = LoopRecord();
  record.inputs /= 100.0;
  const auto mistake = Find(record);
  ASSERT_TRUE(mistake.has_value());
  EXPECT_EQ(mistake->channels.size(), 2u);
}

TEST(OperatorMistakesTest, FindsAnotherTimeUnit) {
  for (const Record& record : Records()) {
    for (const double factor : {60.0, 1.0 / 60.0}) {
      const auto mistake = Find(record, WithTimes(factor));
      ASSERT_TRUE(mistake.has_value()) << factor;
      EXPECT_EQ(mistake->kind, Kind::kTimeUnit);
      EXPECT_NEAR(mistake->factor * factor, 1.0, 1e-12);
    }
  }
}

TEST(OperatorMistakesTest, LeavesRightModels) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    for (const double noise : {0.0, 0.02, 0.3}) {
      for (const double walk : {0.0, 0.003, 0.05}) {
        for (const double quantum : {0.0, 0.05}) {
          Record record =
              LoopRecord({.noise = noise, .walk = walk, .seed = seed});
          if (quantum > 0.0) testing::Quantise(quantum, record.outputs);
          EXPECT_FALSE(Find(record).has_value()) << noise << " " << walk;
        }
      }
    }
  }
}

struct Ageing {
  std::string name;
  std::function<void(int i, int j, double& gain, double& time, double& delay)>
      change;
};

TEST(OperatorMistakesTest, LeavesAgedPlants) {
  const std::vector<Ageing> all = {
      {"gain halved",
       [](int i, int j, double& K, double&, double&) {
         if (i == 0 && j == 0) K *= 0.5;
       }},
      {"column doubled",
       [](int, int j, double& K, double&, double&) {
         if (j == 1) K *= 2.0;
       }},
      {"column halved",
       [](int, int j, double& K, double&, double&) {
         if (j == 0) K *= 0.5;
       }},
      {"all halved", [](int, int, double& K, double&, double&) { K *= 0.5; }},
      {"dead times", [](int, int, double&, double&, double& L) { L *= 1.5; }},
      {"slower", [](int, int, double&, double& T, double&) { T *= 2.0; }},
      {"a sign",
       [](int i, int j, double& K, double&, double&) {
         if (i == 1 && j == 0) K *= -1.0;
       }},
      {"all of it", [](int i, int j, double& K, double& T, double& L) {
         if (i == 0) K *= 0.6;
         if (j == 0) T *= 1.5;
         if (i == j) L *= 2.0;
       }}};
  for (const Ageing& ageing : all) {
    ProcessModel aged = LoopModel();
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        double gain = aged.element(i, j).StaticGain();
        double time = aged.element(i, j).TimeConstant();
        double delay = aged.element(i, j).delay();
        ageing.change(i, j, gain, time, delay);
        aged.element(i, j) = TransferFunction::FirstOrder(gain, time, delay);
      }
    }
    for (unsigned seed = 1; seed <= 4; ++seed) {
      for (const double walk : {0.0, 0.01}) {
        const Record record = LoopRecord(aged, {.walk = walk, .seed = seed},
                                         StaticGains(LoopModel()));
        EXPECT_FALSE(Find(record).has_value()) << ageing.name;
      }
    }
  }
}

// Three outputs and twelve inputs that move in three directions, all elements
// with the same lag and dead time: much of what an aged gain does looks like
// two inputs exchanged.
struct WidePlant {
  ProcessModel model;
  Record record;  // with one gain 40 % up
};

WidePlant MakeWidePlant(unsigned seed) {
  constexpr int kOutputs = 3;
  constexpr int kInputs = 12;
  constexpr int kDirections = 3;
  constexpr int kSamples = 1500;
  WidePlant wide = {.model = testing::NumberedChannels(kOutputs, kInputs),
                    .record = {}};
  for (int e = 0; e < 6 * kOutputs; ++e) {
    wide.model.element(e % kOutputs, (5 * e + e / kInputs) % kInputs) =
        TransferFunction::FirstOrder(
            (e % 2 == 0 ? 1.0 : -1.0) * (1.0 + 0.1 * (e % 7)), 5.0, 2.0);
  }
  std::mt19937_64 source(seed);
  std::normal_distribution<double> normal;
  ProcessModel plant = wide.model;
  const auto aged = static_cast<int>(source() % kOutputs);
  int by = 0;
  do {
    by = static_cast<int>(source() % kInputs);
  } while (plant.element(aged, by).IsZero());
  plant.element(aged, by) = TransferFunction::FirstOrder(
      1.4 * plant.element(aged, by).StaticGain(), 5.0, 2.0);
  Eigen::MatrixXd directions(kInputs, kDirections);
  for (double& value : directions.reshaped()) value = normal(source);
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(kDirections, kSamples);
  for (int d = 0; d < kDirections; ++d) {
    for (int k = 1; k < kSamples; ++k) {
      moves(d, k) = source() % 50 == 0 ? normal(source) : moves(d, k - 1);
    }
  }
  wide.record.sample_time = 1.0;
  wide.record.inputs = directions * moves;
  for (double& u : wide.record.inputs.reshaped()) u += 0.02 * normal(source);
  wide.record.outputs = *SimulateResponse(plant, 1.0, wide.record.inputs);
  for (double& y : wide.record.outputs.reshaped()) y += 0.2 * normal(source);
  return wide;
}

TEST(OperatorMistakesTest, LeavesAgedPlantsWhoseInputsMoveTogether) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const WidePlant wide = MakeWidePlant(seed);
    EXPECT_FALSE(Find(wide.record, wide.model).has_value()) << seed;
  }
}

TEST(OperatorMistakesTest, FindsExchangedTagsOfAgedPlants) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    WidePlant wide = MakeWidePlant(seed);
    wide.record.inputs.row(2).swap(wide.record.inputs.row(7));
    const auto mistake = Find(wide.record, wide.model);
    ASSERT_TRUE(mistake.has_value()) << seed;
    EXPECT_EQ(mistake->kind, Kind::kExchanged);
    EXPECT_THAT(mistake->channels, ElementsAre(2, 7)) << seed;
  }
}

// Ageing turns no sign, and does not hide that one is turned.
TEST(OperatorMistakesTest, FindsAReversedSignOfAnAgedPlant) {
  ProcessModel model("one", "min", {{"u", ""}}, {{"y", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 15.0, 1.0);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Record record = LoopRecord({.noise = 0.005, .seed = seed});
    record.inputs = record.inputs.row(0).eval();
    record.set_points = record.set_points.row(0).eval();
    for (const auto& [gain, time, delay] :
         {std::tuple(1.3, 15.0, 1.0), std::tuple(0.8, 25.0, 2.0),
          std::tuple(3.5, 10.0, 1.0)}) {
      ProcessModel aged = model;
      aged.element(0, 0) = TransferFunction::FirstOrder(gain, time, delay);
      record.outputs = *SimulateResponse(aged, 0.25, record.inputs) +
                       0.02 * Eigen::MatrixXd::Random(1, record.samples());
      EXPECT_FALSE(Find(record, model).has_value()) << gain << " " << seed;
      Record reversed = record;
      reversed.inputs *= -1.0;
      const auto mistake = Find(reversed, model);
      ASSERT_TRUE(mistake.has_value()) << gain << " " << seed;
      EXPECT_EQ(mistake->kind, Kind::kSign);
      EXPECT_EQ(mistake->factor, -1.0);
    }
  }
}

// The tag of one unit is hardly typed for one of another, nor are what is moved
// and what is only measured taken for each other: only where that explains
// most.
TEST(OperatorMistakesTest, SwapsOfOtherUnitsAndRolesMustExplainMore) {
  ProcessModel aged = LoopModel();
  aged.element(0, 0) = TransferFunction::FirstOrder(1.3, 15.0, 1.0);
  aged.element(1, 1) = TransferFunction::FirstOrder(-2.2, 12.0, 2.0);
  Record record;
  const auto find = [&](std::vector<InputChannel> inputs) {
    ProcessModel model("loops", "min", std::move(inputs),
                       LoopModel().outputs());
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j)
        model.element(i, j) = LoopModel().element(i, j);
    }
    const auto mistake = Find(record, model);
    return mistake.has_value() && mistake->kind == Kind::kExchanged;
  };
  for (const bool is_aged : {false, true}) {
    record =
        is_aged ? LoopRecord(aged, {}, StaticGains(LoopModel())) : LoopRecord();
    record.inputs.row(0).swap(record.inputs.row(1));
    EXPECT_TRUE(find({{"u1", "kW"}, {"u2", "kW"}}));
    EXPECT_EQ(find({{"u1", "kW"}, {"u2", "W/m2"}}), !is_aged);
    EXPECT_EQ(find({{"u1", "kW"}, {"u2", "kW", InputRole::kDisturbance}}),
              !is_aged);
  }
}

// An element that is a poor guess has better likelihoods with many wrong tags.
TEST(OperatorMistakesTest, ASwapThatLeavesThePoorFitIsNotTold) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Record record = LoopRecord({.walk = 0.01, .seed = seed});
    for (const double guess : {-0.3, 0.1, 8.0}) {
      for (int j = 0; j < 2; ++j) {
        ProcessModel model = LoopModel();
        for (int i = 0; i < 2; ++i) {
          const TransferFunction& g = model.element(i, j);
          model.element(i, j) = TransferFunction::FirstOrder(
              guess * g.StaticGain(), 4.0 * g.TimeConstant(), g.delay());
        }
        const auto mistake = Find(record, model);
        EXPECT_FALSE(mistake.has_value() && mistake->kind == Kind::kExchanged)
            << guess << " " << j << " " << seed;
      }
    }
  }
}

TEST(OperatorMistakesTest, NamesTheLinesThatCorrectIt) {
  const ProcessModel model = LoopModel();
  const OperatorMistake swapped = {.channels = {0, 1}};
  EXPECT_EQ(swapped.Describe(model),
            "The tags of u1 and u2 seem to be swapped.");
  std::vector<TagMapping> tags = {
      {"FC1.OP", "u1", 1.0, 0.0, "tags.csv, line 2"},
      {"FC2.OP", "u2", 1.0, 0.0, "tags.csv, line 3"},
      {"TI1.PV", "y1", 1.0, 0.0, "tags.csv, line 4"}};
  EXPECT_THAT(swapped.Describe(model, tags),
              HasSubstr("Correct it with tags.csv, line 2: FC1.OP,u2; "
                        "tags.csv, line 3: FC2.OP,u1."));
  for (TagMapping& tag : tags) tag.place.clear();
  EXPECT_THAT(swapped.Describe(model, tags),
              HasSubstr("Correct it with tags = "
                        "'FC1.OP=u2,FC2.OP=u1,TI1.PV=y1'."));
  EXPECT_THAT(swapped.Describe(model, {{"u1", "u1"}, {"u2", "u2"}}),
              HasSubstr("tags = 'u1=u2,u2=u1'."));
  const OperatorMistake per_cent = {
      .kind = Kind::kFactor, .channels = {1}, .factor = 0.01};
  EXPECT_THAT(
      per_cent.Describe(model, {{"FC2.OP", "u2", 2.0, 1.0, "t, line 3"}}),
      HasSubstr("t, line 3: FC2.OP,u2,0.02,0.01."));
  const OperatorMistake fahrenheit = {
      .kind = Kind::kFactor, .outputs = true, .channels = {0}, .factor = 1.8};
  EXPECT_THAT(fahrenheit.Describe(
                  model, {{"TI1.PV", "y1"}, {"TIC1.SP", "y1_setpoint"}}),
              HasSubstr("tags = 'TI1.PV=y1*0.555556-17.7778,"
                        "TIC1.SP=y1_setpoint*0.555556-17.7778'."));
  const OperatorMistake sign = {
      .kind = Kind::kSign, .channels = {0}, .factor = -1.0};
  EXPECT_THAT(sign.Describe(model, {{"FC1.OP", "u1"}}),
              HasSubstr("tags = 'FC1.OP=u1*-1'."));
  const OperatorMistake hours = {.kind = Kind::kTimeUnit, .factor = 60.0};
  EXPECT_THAT(hours.Describe(model),
              HasSubstr("Correct it with \"time_unit\": \"h\" in the model, or "
                        "with number_unit = s where"));
}

// One element: the number decides.
TEST(OperatorMistakesTest, OfOneElementOnlyTheNumberTells) {
  ProcessModel model("one", "min", {{"u", ""}}, {{"y", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 15.0, 1.0);
  Record record = LoopRecord({.noise = 0.005});
  record.outputs = *SimulateResponse(model, 0.25, record.inputs.row(0)) +
                   0.005 * Eigen::MatrixXd::Random(1, record.samples());
  record.inputs = record.inputs.row(0).eval();
  record.set_points = record.set_points.row(0).eval();
  for (const double factor : {-1.0, 60.0, 0.01}) {
    Record other = record;
    other.inputs /= factor;
    const auto mistake = Find(other, model);
    ASSERT_TRUE(mistake.has_value()) << factor;
    EXPECT_NEAR(mistake->factor, factor, 1e-12);
    EXPECT_TRUE(mistake->ambiguous);
  }
  for (const double factor : {1.0, 0.5, 1.8, 2.0, 5.0, 30.0}) {
    Record other = record;
    other.inputs /= factor;
    EXPECT_FALSE(Find(other, model).has_value()) << factor;
  }
}

TEST(OperatorMistakesTest, ADeadSensorIsNoMistake) {
  Record record = LoopRecord();
  record.outputs.row(0).setConstant(3.0);
  EXPECT_FALSE(Find(record).has_value());
  record.outputs.row(1).setConstant(3.0);
  EXPECT_FALSE(Find(record).has_value());
}

TEST(OperatorMistakesTest, ShortRecordsAreNotExamined) {
  EXPECT_FALSE(Find(LoopRecord({.samples = 80})).has_value());
}

}  // namespace
}  // namespace mle
