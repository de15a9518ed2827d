#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kValidProcess[] = R"({
  "name": "column",
  "time_unit": "min",
  "inputs": [
    {"name": "reflux", "unit": "lb/min", "role": "manipulated"},
    {"name": "feed", "unit": "lb/min", "role": "disturbance"}
  ],
  "outputs": [{"name": "overhead", "unit": "wt%"}],
  "elements": [
    {"output": "overhead", "input": "reflux",
     "gain": 12.8, "time_constant": 16.7, "delay": 1},
    {"output": "overhead", "input": "feed",
     "numerator": [-4, 3.8], "denominator": [74.5, 29.9, 1], "delay": 8.1}
  ]
})";

// What is said of the valid file with `from` changed to `to`.
std::string ProcessMessageWith(const std::string& from, const std::string& to) {
  const std::string text = absl::StrReplaceAll(kValidProcess, {{from, to}});
  EXPECT_NE(text, kValidProcess) << from;
  const auto model = ParseProcessModel(text, "plant.json");
  EXPECT_FALSE(model.ok()) << text;
  EXPECT_TRUE(absl::IsInvalidArgument(model.status())) << model.status();
  return std::string(model.status().message());
}

void ExpectSame(const ProcessModel& a, const ProcessModel& b) {
  EXPECT_EQ(a.name(), b.name());
  EXPECT_TRUE(CheckSameChannels(a, "a", b, "b").ok());
  for (int j = 0; j < a.num_inputs(); ++j) {
    EXPECT_EQ(a.inputs()[j].unit, b.inputs()[j].unit);
    EXPECT_EQ(a.inputs()[j].role, b.inputs()[j].role);
    EXPECT_EQ(a.inputs()[j].sampling, b.inputs()[j].sampling);
  }
  for (int i = 0; i < a.num_outputs(); ++i) {
    EXPECT_EQ(a.outputs()[i].unit, b.outputs()[i].unit);
    for (int j = 0; j < a.num_inputs(); ++j) {
      EXPECT_EQ(a.element(i, j).numerator(), b.element(i, j).numerator());
      EXPECT_EQ(a.element(i, j).denominator(), b.element(i, j).denominator());
      EXPECT_EQ(a.element(i, j).delay(), b.element(i, j).delay());
    }
  }
}

TEST(ParseProcessModelTest, ReadsBothForms) {
  const auto model = ParseProcessModel(kValidProcess, "plant.json");
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->name(), "column");
  EXPECT_EQ(model->time_unit(), "min");
  EXPECT_EQ(model->inputs()[0].role, InputRole::kManipulated);
  EXPECT_EQ(model->inputs()[1].role, InputRole::kDisturbance);
  EXPECT_EQ(model->element(0, 0).TimeConstant(), 16.7);
  EXPECT_EQ(model->element(0, 0).delay(), 1.0);
  EXPECT_EQ(model->element(0, 1).StaticGain(), 3.8);
  EXPECT_EQ(model->element(0, 1).denominator().size(), 3u);
}

std::string WithIntegrator(const std::string& dynamics) {
  return absl::StrReplaceAll(
      kValidProcess, {{"\"gain\": 12.8, \"time_constant\": 16.7", dynamics}});
}

TEST(ParseProcessModelTest, ReadsIntegrators) {
  const auto g = [](const std::string& dynamics) {
    const auto model =
        ParseProcessModel(WithIntegrator(dynamics), "plant.json");
    EXPECT_TRUE(model.ok()) << model.status();
    if (!model.ok()) return TransferFunction();
    // And back.
    const auto again = ParseProcessModel(FormatProcessModel(*model), "again");
    EXPECT_TRUE(again.ok()) << again.status();
    if (again.ok()) ExpectSame(*model, *again);
    return model->element(0, 0);
  };
  const auto pure = g(R"("gain": -0.4, "integrating": true)");
  EXPECT_TRUE(pure.IsIntegrating());
  EXPECT_EQ(pure.StaticGain(), -0.4);
  EXPECT_EQ(pure.TimeConstant(), 0.0);
  const auto lag =
      g(R"("gain": -0.4, "time_constant": 3, "integrating": true)");
  EXPECT_TRUE(lag.IsIntegrating());
  EXPECT_EQ(lag.StaticGain(), -0.4);
  EXPECT_EQ(lag.TimeConstant(), 3.0);
  const auto rational =
      g(R"("numerator": [2, 6], "denominator": [5, 7, 2, 0])");
  EXPECT_TRUE(rational.IsIntegrating());
  EXPECT_EQ(rational.StaticGain(), 3.0);
  EXPECT_FALSE(g(R"("gain": 2, "time_constant": 3, "integrating": false)")
                   .IsIntegrating());
}

TEST(ParseProcessModelTest, IntegratorsOfNoFormAreErrors) {
  const auto message = [](const std::string& dynamics) {
    const auto model =
        ParseProcessModel(WithIntegrator(dynamics), "plant.json");
    EXPECT_TRUE(absl::IsInvalidArgument(model.status())) << dynamics;
    return std::string(model.status().message());
  };
  EXPECT_THAT(message(R"("numerator": [1], "denominator": [2, 1, 0],
                         "integrating": true)"),
              AllOf(HasSubstr("elements[0]"), HasSubstr("ends with 0")));
  EXPECT_THAT(message(R"("gain": 2, "integrating": false)"),
              HasSubstr("has gain"));
  EXPECT_THAT(message(R"("gain": 2, "integrating": 1)"),
              HasSubstr("integrating"));
  EXPECT_THAT(message(R"("gain": 2, "time_constant": -1,
                         "integrating": true)"),
              HasSubstr("time_constant"));
  EXPECT_THAT(message(R"("numerator": [1], "denominator": [1, 0, 0])"),
              HasSubstr("more than one pole at s = 0"));
}

TEST(ParseProcessModelTest, AbsentPairIsZero) {
  const auto model = ParseProcessModel(
      R"({"name": "", "time_unit": "s", "inputs": [{"name": "u", "unit": ""}],
          "outputs": [{"name": "y", "unit": ""}], "elements": []})",
      "plant.json");
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_TRUE(model->element(0, 0).IsZero());
}

TEST(ParseProcessModelTest, SyntaxErrorsNameFileLineAndColumn) {
  // The comma missing after "column", seen at the next key.
  EXPECT_THAT(ProcessMessageWith("\"column\",", "\"column\""),
              StartsWith("plant.json: line 3, column"));
  EXPECT_THAT(ProcessMessageWith("12.8", "12.8.1"),
              StartsWith("plant.json: line 11, column"));
  EXPECT_THAT(ProcessMessageWith("12.8", "NaN"), HasSubstr("line 11, column"));
  EXPECT_THAT(ProcessMessageWith("12.8", "Infinity"),
              HasSubstr("line 11, column"));
  EXPECT_THAT(ProcessMessageWith("12.8", "1e999"),
              AllOf(HasSubstr("line 11, column"), HasSubstr("1e999"),
                    HasSubstr("out of range")));
  for (const char* text : {"", " ", "{", "[1, 2", "\"\xff\"", "{}x", "nul"}) {
    EXPECT_THAT(
        std::string(ParseProcessModel(text, "plant.json").status().message()),
        StartsWith("plant.json: line 1, column"))
        << text;
  }
}

TEST(ParseProcessModelTest, UnknownKeysAreNamedWithTheirPlace) {
  EXPECT_THAT(ProcessMessageWith("\"gain\"", "\"gian\""),
              AllOf(StartsWith("plant.json: elements[0]: unknown key \"gian\""),
                    HasSubstr("output, input, delay, gain")));
  EXPECT_THAT(ProcessMessageWith("\"role\": \"dist", "\"rôle\": \"dist"),
              AllOf(HasSubstr("inputs[1]"), HasSubstr("name, unit, role")));
  EXPECT_THAT(
      ProcessMessageWith("\"name\": \"column\"", "\"title\": \"column\""),
      HasSubstr("plant.json: unknown key \"title\""));
}

TEST(ParseProcessModelTest, MissingKeysAreNamed) {
  EXPECT_THAT(ProcessMessageWith(", \"delay\": 1}", "}"),
              HasSubstr("elements[0]: key \"delay\" is missing"));
  EXPECT_THAT(ProcessMessageWith(", \"unit\": \"wt%\"", ""),
              HasSubstr("outputs[0]: key \"unit\" is missing"));
  EXPECT_THAT(ProcessMessageWith("\"time_unit\": \"min\",", ""),
              HasSubstr("key \"time_unit\" is missing"));
}

TEST(ParseProcessModelTest, RepeatedKeysAreNamedWithTheirPlace) {
  EXPECT_THAT(
      ProcessMessageWith("\"delay\": 8.1", "\"delay\": 8.1, \"delay\": 8.2"),
      HasSubstr("elements[1]: key \"delay\" is duplicated"));
  EXPECT_THAT(ProcessMessageWith("\"name\": \"column\"",
                                 "\"name\": \"column\", \"name\": \"column\""),
              HasSubstr("plant.json: key \"name\" is duplicated"));
}

TEST(ParseProcessModelTest, EitherFormWhole) {
  EXPECT_THAT(ProcessMessageWith("\"gain\": 12.8, ", ""),
              AllOf(HasSubstr("elements[0]"), HasSubstr("has time_constant")));
  EXPECT_THAT(ProcessMessageWith("\"gain\": 12.8, ",
                                 "\"gain\": 12.8, \"numerator\": [1], "),
              HasSubstr("has gain, time_constant, numerator"));
  EXPECT_THAT(
      ProcessMessageWith("\"gain\": 12.8, \"time_constant\": 16.7, ", ""),
      HasSubstr("has none of them"));
}

TEST(ParseProcessModelTest, WrongTypesAreNamed) {
  EXPECT_THAT(ProcessMessageWith("12.8", "\"12.8\""),
              HasSubstr("elements[0].gain: must be a number, is the string "
                        "\"12.8\""));
  EXPECT_THAT(ProcessMessageWith("12.8", "null"), HasSubstr("is null"));
  EXPECT_THAT(ProcessMessageWith("[-4, 3.8]", "[-4, true]"),
              HasSubstr("elements[1].numerator[1]: must be a number, is true"));
  EXPECT_THAT(ProcessMessageWith("[-4, 3.8]", "[]"),
              HasSubstr("numerator: is an empty list"));
  EXPECT_THAT(ProcessMessageWith("[-4, 3.8]", "3"),
              HasSubstr("numerator: must be a list, is the number 3"));
  EXPECT_THAT(ProcessMessageWith("\"min\"", "60"),
              HasSubstr("time_unit: must be a string, is the number 60"));
  EXPECT_THAT(
      ProcessMessageWith("[{\"name\": \"overhead\", \"unit\": \"wt%\"}]",
                         "\"overhead\""),
      HasSubstr("outputs: must be a list, is the string"));
  EXPECT_THAT(
      ProcessMessageWith("[{\"name\": \"overhead\", \"unit\": \"wt%\"}]",
                         "[\"overhead\"]"),
      HasSubstr("outputs[0]: must be an object"));
  EXPECT_THAT(
      std::string(ParseProcessModel("[1]", "plant.json").status().message()),
      HasSubstr("must be an object, is an array"));
}

TEST(ParseProcessModelTest, ValuesOutOfRangeAreNamed) {
  EXPECT_THAT(ProcessMessageWith("16.7", "0"),
              HasSubstr("elements[0].time_constant: must be a number > 0, is "
                        "the number 0"));
  EXPECT_THAT(ProcessMessageWith("16.7", "-16.7"),
              HasSubstr("is the number -16.7"));
  EXPECT_THAT(ProcessMessageWith("8.1", "-8.1"),
              HasSubstr("elements[1]: delay is -8.1"));
  EXPECT_THAT(ProcessMessageWith("[74.5, 29.9, 1]", "[74.5, 0, 0]"),
              HasSubstr("elements[1]: denominator"));
  EXPECT_THAT(ProcessMessageWith("[-4, 3.8]", "[1, 2, 3, 4]"),
              HasSubstr("proper"));
  EXPECT_THAT(ProcessMessageWith("\"disturbance\"", "\"nuisance\""),
              HasSubstr("inputs[1].role: is \"nuisance\""));
}

TEST(ParseProcessModelTest, ChannelsMustBeKnownAndDistinct) {
  EXPECT_THAT(ProcessMessageWith("\"input\": \"feed\"", "\"input\": \"fede\""),
              AllOf(HasSubstr("elements[1].input: \"fede\" is unknown"),
                    HasSubstr("\"reflux\", \"feed\"")));
  EXPECT_THAT(
      ProcessMessageWith("\"input\": \"feed\"", "\"input\": \"reflux\""),
      AllOf(HasSubstr("elements[1]"), HasSubstr("is duplicated")));
  EXPECT_THAT(
      ProcessMessageWith("{\"name\": \"feed\"", "{\"name\": \"overhead\""),
      HasSubstr("is used already"));
  EXPECT_THAT(ProcessMessageWith("{\"name\": \"feed\"", "{\"name\": \"\""),
              HasSubstr("inputs[1]: name is empty"));
}

TEST(ParseProcessModelTest, HostileTextIsAnError) {
  const std::string deep(2'000'000, '[');
  EXPECT_THAT(std::string(ParseProcessModel(deep, "x").status().message()),
              HasSubstr("nested deeper"));
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_FALSE(ParseProcessModel(objects, "x").ok());
  EXPECT_THAT(std::string(ParseProcessModel(std::string(20 << 20, ' '), "x")
                              .status()
                              .message()),
              HasSubstr("bytes"));
  // A model of 1000 × 1000 pairs from a small file.
  std::string inputs;
  std::string outputs;
  for (int i = 0; i < 1000; ++i) {
    absl::StrAppend(&inputs, i ? "," : "", "{\"name\":\"u", i,
                    "\",\"unit\":\"\"}");
    absl::StrAppend(&outputs, i ? "," : "", "{\"name\":\"y", i,
                    "\",\"unit\":\"\"}");
  }
  EXPECT_THAT(
      std::string(
          ParseProcessModel("{\"name\":\"\",\"time_unit\":\"s\",\"inputs\":[" +
                                inputs + "],\"outputs\":[" + outputs +
                                "],\"elements\":[]}",
                            "x")
              .status()
              .message()),
      HasSubstr("pairs"));
}

TEST(ParseProcessModelTest, NoPrefixOrBrokenByteCrashes) {
  const std::string valid = kValidProcess;
  for (std::size_t n = 0; n < valid.size(); ++n) {
    EXPECT_FALSE(ParseProcessModel(valid.substr(0, n), "x").ok()) << n;
  }
  std::mt19937 engine(5);
  int errors = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::string text = valid;
    text[engine() % text.size()] = static_cast<char>(engine() % 256);
    const auto model = ParseProcessModel(text, "x");
    if (model.ok()) {
      EXPECT_TRUE(model->Validate().ok()) << text;
    } else {
      EXPECT_THAT(std::string(model.status().message()), StartsWith("x: "));
      ++errors;
    }
  }
  EXPECT_GT(errors, 500);
}

TEST(FormatProcessModelTest, ComesBackToTheLastBit) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int trial = 0; trial < 50; ++trial) {
    ProcessModel model(
        "a \"quoted\" name, with \\ and \n and µ", "min",
        {{"u1", "°C"},
         {"u2", "", InputRole::kDisturbance, {.late_by = -uniform(engine)}},
         {"u3", "m³"}},
        {{"y1", "%", {.period = 240.0, .held = true, .late_by = 15.0}},
         {"y2", "%", {.average = 5.0, .stamped_at_end = trial % 2 == 0}}});
    model.element(0, 0) = TransferFunction::FirstOrder(
        std::exp(200 * uniform(engine) - 100), uniform(engine) / 3.0,
        uniform(engine) * 1e-7);
    model.element(0, 2) = TransferFunction::FirstOrder(
        -uniform(engine), std::exp(100 * uniform(engine)), 0.0);
    model.element(1, 1) = TransferFunction(
        {uniform(engine) - 0.5, uniform(engine)},
        {uniform(engine), uniform(engine), uniform(engine)}, 1.0 / 3.0);
    model.element(1, 2) =
        TransferFunction({uniform(engine)}, {uniform(engine), 3.0}, 0.1);
    const std::string text = FormatProcessModel(model);
    const auto back = ParseProcessModel(text, "back");
    ASSERT_TRUE(back.ok()) << back.status() << text;
    ExpectSame(model, *back);
    EXPECT_EQ(FormatProcessModel(*back), text);
  }
}

TEST(FormatProcessModelTest, WritesFirstOrderElementsByGainAndTimeConstant) {
  ProcessModel model("m", "s", {{"u", ""}, {"v", ""}}, {{"y", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(0.1, 16.7, 3.0);
  const std::string text = FormatProcessModel(model);
  EXPECT_THAT(text, HasSubstr(R"({"output": "y", "input": "u", "gain": 0.1, )"
                              R"("time_constant": 16.7, "delay": 3})"));
  EXPECT_THAT(text, Not(HasSubstr("\"input\": \"v\"")));  // Zero: left out.
  EXPECT_THAT(text, Not(HasSubstr("numerator")));
  EXPECT_THAT(text, Not(HasSubstr("role")));
}

TEST(ParseProcessModelTest, SamplingIsReadAndChecked) {
  const auto parse = [](const std::string& of_input,
                        const std::string& of_output) {
    return ParseProcessModel(
        absl::StrCat(
            R"({"name": "m", "time_unit": "min", "inputs": [{"name": )",
            R"("u", "unit": "", "sampling": )", of_input,
            R"(}], "outputs": [{"name": "y", "unit": "", )", R"("sampling": )",
            of_output, R"(}], "elements": []})"),
        "plant.json");
  };
  const auto model =
      parse(R"({"average": 5, "stamp": "start"})",
            R"({"period": 240, "held": true, "late_by": -3, "average": 10,
          "stamp": "end"})");
  ASSERT_TRUE(model.ok()) << model.status();
  const Sampling& input = model->inputs()[0].sampling;
  EXPECT_EQ(input.InputLate(), 0.0);
  const Sampling& output = model->outputs()[0].sampling;
  EXPECT_EQ(output.period, 240.0);
  EXPECT_TRUE(output.held);
  EXPECT_EQ(output.OutputLate(), 2.0);
  const auto message = [&](const std::string& of_input,
                           const std::string& of_output) {
    return std::string(parse(of_input, of_output).status().message());
  };
  EXPECT_THAT(message(R"({"period": 5})", "{}"),
              AllOf(HasSubstr("inputs[0].sampling"), HasSubstr("period")));
  EXPECT_THAT(message("{}", R"({"held": true})"),
              AllOf(HasSubstr("outputs[0].sampling"),
                    HasSubstr("held without period")));
  EXPECT_THAT(message("{}", R"({"average": 5})"), HasSubstr("together"));
  EXPECT_THAT(message("{}", R"({"average": 5, "stamp": "middle"})"),
              HasSubstr("stamp: is \"middle\", must be \"start\" or \"end\""));
  EXPECT_THAT(message("{}", R"({"average": -5, "stamp": "end"})"),
              HasSubstr("outputs[0].sampling.average"));
  EXPECT_THAT(message("{}", R"({"late": 5})"), HasSubstr("late_by"));
}

TEST(ReadProcessModelTest, ReadsTheConfigs) {
  for (const char* name :
       {"wood_berry", "wood_berry_gain", "wood_berry_delay"}) {
    const auto model = ReadProcessModel(std::string(MLE_CONFIGS_FOLDER) + "/" +
                                        name + ".json");
    ASSERT_TRUE(model.ok()) << model.status();
    EXPECT_EQ(model->num_inputs(), 2);
    EXPECT_EQ(model->element(0, 1).StaticGain(), -18.9);
  }
}

TEST(ReadProcessModelTest, MissingFileIsNotFound) {
  const absl::Status status = ReadProcessModel("absent.json").status();
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("absent.json"));
}

TEST(WriteProcessModelTest, WritesWhatIsReadAndRefusesTheInvalid) {
  const ScratchFolder folder;
  const std::string path = folder / "model.json";
  ProcessModel model = *ParseProcessModel(kValidProcess, "valid");
  ASSERT_TRUE(WriteProcessModel(model, path).ok());
  ExpectSame(model, *ReadProcessModel(path));
  model.element(0, 0).set_delay(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(std::string(WriteProcessModel(model, path).message()),
              AllOf(HasSubstr(path), HasSubstr("delay is nan")));
  EXPECT_TRUE(ReadProcessModel(path).ok());  // The old file stays.
}

}  // namespace
}  // namespace mle
