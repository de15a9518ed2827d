// What the order of channels and their units must do to what mle_correct
// writes: nothing to the model of the plant.

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/data/record_csv.h"
#include "mle/model/process_model.h"
#include "tests/apps/correct_runs.h"

namespace mle {
namespace {

using nlohmann::json;

// What the heater's model has become: a gain and a dead time.
Heater Aged() {
  Heater aged;
  aged.first.gain = 1.2;
  aged.third.delay = 3.0;
  return aged;
}

struct HeaterFiles {
  HeaterFiles()
      : model(scratch.Write("model.json", HeaterJson(Heater()))),
        plant(scratch.Write("plant.json", HeaterJson(Aged()))),
        data(SimulateHeater(scratch, "run.csv", model, plant)) {}

  json Run(const std::string& name, const std::string& with_model,
           const std::string& with_data) const {
    return Correct(CorrectionFlags(with_model, with_data, scratch / name),
                   scratch / name);
  }

  const ScratchFolder scratch;
  const std::string model, plant, data;
};

// The same pair in two results, the second with a gain `factor` times that of
// the first. The fits end where a step is below 1e-6 or so of a parameter.
void ExpectSamePair(const json& a, const json& b, double factor) {
  EXPECT_EQ(a["aged"], b["aged"]);
  const auto expect_near = [&](const char* parameter, double scale) {
    const double expected = scale * a["fopdt"][parameter].get<double>();
    EXPECT_NEAR(b["fopdt"][parameter].get<double>(), expected,
                1e-4 * std::abs(expected))
        << parameter;
  };
  expect_near("gain", factor);
  expect_near("time_constant", 1.0);
  expect_near("delay", 1.0);
}

void ExpectSameDecision(const json& a, const json& b) {
  EXPECT_EQ(a["decision"], "corrected");
  EXPECT_EQ(b["decision"], a["decision"]);
  // Not what was proved by simulation: its draws belong to channels by number.
  EXPECT_NEAR(b["test_of_no_change"]["statistic"].get<double>(),
              a["test_of_no_change"]["statistic"],
              1e-4 * a["test_of_no_change"]["statistic"].get<double>());
}

TEST(MleCorrectMetamorphicTest, TheOrderOfChannelsDoesNotMatter) {
  const HeaterFiles files;
  json turned = json::parse(HeaterJson(Heater()));
  for (const char* const list : {"inputs", "outputs", "elements"}) {
    std::reverse(turned[list].begin(), turned[list].end());
  }
  const std::string turned_model =
      files.scratch.Write("turned.json", turned.dump());
  const json before = files.Run("before", files.model, files.data);
  // The record's columns have names, and may stay where they are.
  const json after = files.Run("after", turned_model, files.data);
  ExpectSameDecision(before, after);
  for (const char* const output : {"y1", "y2"}) {
    for (const char* const input : {"u1", "u2"}) {
      SCOPED_TRACE(absl::StrCat(output, " ← ", input));
      ExpectSamePair(ElementOf(before, output, input),
                     ElementOf(after, output, input), 1.0);
    }
  }
}

// Degrees become millidegrees, per cent of a valve become parts of one.
TEST(MleCorrectMetamorphicTest, UnitsScaleTheGainsAlone) {
  const HeaterFiles files;
  const double output_scale[] = {1000.0, 1.0};
  const double input_scale[] = {0.01, 1.0};
  Heater heater;
  heater.first.gain *= output_scale[0] / input_scale[0];
  heater.second.gain *= output_scale[0] / input_scale[1];
  heater.third.gain *= output_scale[1] / input_scale[0];
  heater.fourth.gain *= output_scale[1] / input_scale[1];
  const std::string scaled_model =
      files.scratch.Write("scaled.json", HeaterJson(heater));

  const absl::StatusOr<ProcessModel> model = ReadProcessModel(files.model);
  ASSERT_TRUE(model.ok()) << model.status();
  auto import = ImportHistorian({files.data}, *model, {.max_gap = 0.0});
  ASSERT_TRUE(import.ok()) << import.status();
  Record* const record = &import->records.at(0);
  for (int i = 0; i < 2; ++i) {
    record->outputs.row(i) *= output_scale[i];
    record->set_points.row(i) *= output_scale[i];
    record->inputs.row(i) *= input_scale[i];
  }
  const std::string scaled_data = files.scratch / "scaled.csv";
  ASSERT_TRUE(WriteRecordCsv(scaled_data, *record, *model).ok());

  const json before = files.Run("before", files.model, files.data);
  const json after = files.Run("after", scaled_model, scaled_data);
  ExpectSameDecision(before, after);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const std::string output = absl::StrCat("y", i + 1);
      const std::string input = absl::StrCat("u", j + 1);
      SCOPED_TRACE(absl::StrCat(output, " ← ", input));
      ExpectSamePair(ElementOf(before, output, input),
                     ElementOf(after, output, input),
                     output_scale[i] / input_scale[j]);
    }
  }
}

}  // namespace
}  // namespace mle
