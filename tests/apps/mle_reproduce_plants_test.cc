// mle_reproduce on plants of other sizes and names than the paper's.

#include <cstddef>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"
#include "tests/apps/command_runner.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Element {
  int output;
  int input;
  TransferFunction dynamics;
};

TransferFunction FirstOrder(double gain, double time_constant, double delay) {
  return TransferFunction::FirstOrder(gain, time_constant, delay);
}

// Its JSON.
std::string Model(const std::vector<std::string>& outputs,
                  const std::vector<std::string>& inputs,
                  const std::vector<Element>& elements) {
  std::vector<OutputChannel> output_channels;
  for (const std::string& name : outputs)
    output_channels.push_back({name, "%"});
  std::vector<InputChannel> input_channels;
  for (const std::string& name : inputs) input_channels.push_back({name, "%"});
  ProcessModel model("test", "s", input_channels, output_channels);
  for (const auto& [output, input, dynamics] : elements) {
    model.element(output, input) = dynamics;
  }
  return FormatProcessModel(model);
}

nlohmann::json RunCase(const ScratchFolder& scratch, const std::string& model,
                       const std::string& plant,
                       const std::vector<std::string>& more) {
  std::vector<std::string> arguments = SmallRun(
      scratch / "out", {"--model=" + scratch.Write("model.json", model),
                        "--plants=aged:" + scratch.Write("plant.json", plant)});
  arguments.insert(arguments.end(), more.begin(), more.end());
  const report::ProcessResult result = RunTested(arguments);
  const nlohmann::json results = ParsedJson(scratch / "out/results.json");
  EXPECT_EQ(results["cases"].size(), 1u);
  EXPECT_EQ(results["cases"][0]["name"], "aged");
  // The certificate decides: 1 where a fit, at some λ, is not exact.
  const nlohmann::json& gap =
      results["cases"][0]["runs"][0]["max_relative_duality_gap"];
  EXPECT_EQ(result.exit_code, gap <= 1e-9 ? 0 : 1) << result.err;
  return results["cases"][0];
}

void ExpectShape(const nlohmann::json& rows, std::size_t outputs,
                 std::size_t inputs) {
  ASSERT_EQ(rows.size(), outputs);
  for (const nlohmann::json& row : rows) {
    ASSERT_EQ(row.size(), inputs);
    for (const nlohmann::json& entry : row) EXPECT_FALSE(entry.is_null());
  }
}

void ExpectCase(const nlohmann::json& result, std::size_t outputs,
                std::size_t inputs) {
  ASSERT_TRUE(result.is_object());
  const nlohmann::json& run = result["runs"][0];
  ExpectShape(run["static_gain_error"], outputs, inputs);
  ExpectShape(run["delay_impulse_peak"], outputs, inputs);
  ExpectShape(run["fopdt"], outputs, inputs);
  // The records show the change clearly: it is mostly corrected.
  EXPECT_LT(run["E_star"], 0.5 * result["E_initial"].get<double>());
}

TEST(MleReproducePlants, OneOutputOfSecondOrder) {
  const ScratchFolder scratch;
  const auto heater = [](double gain) {
    return Model({"temperature"}, {"power"},
                 {{0, 0, TransferFunction({gain}, {12.0, 7.0, 1.0}, 1.5)}});
  };
  const nlohmann::json result =
      RunCase(scratch, heater(2), heater(1.2), {"--selection=blocks"});
  ExpectCase(result, 1, 1);
}

TEST(MleReproducePlants, ThreeByThreeWithAbsentPairs) {
  const ScratchFolder scratch;
  const auto plant = [](double gain) {
    return Model({"a", "b", "c"}, {"u", "v", "w"},
                 {{0, 0, FirstOrder(gain, 4, 1)},
                  {0, 1, FirstOrder(0.5, 6, 2)},
                  {1, 1, FirstOrder(-3, 5, 1)},
                  {2, 2, FirstOrder(1.5, 3, 0)}});
  };
  const nlohmann::json result =
      RunCase(scratch, plant(2), plant(1.2), {"--selection=blocks"});
  ExpectCase(result, 3, 3);
  const auto responses = ParsedCsv(scratch / "out/step_response_aged.csv");
  EXPECT_EQ(responses[0].size(), 1u + 4u * 9u);
}

// The controller moves the three inputs almost along a plane, so that their
// columns are nearly dependent.
TEST(MleReproducePlants, MoreInputsThanOutputs) {
  const ScratchFolder scratch;
  const auto plant = [](double gain) {
    return Model({"a", "b"}, {"u", "v", "w"},
                 {{0, 0, FirstOrder(gain, 4, 1)},
                  {0, 1, FirstOrder(0.5, 6, 2)},
                  {1, 1, FirstOrder(-3, 5, 1)},
                  {1, 2, FirstOrder(1, 7, 1)}});
  };
  ExpectCase(RunCase(scratch, plant(2), plant(1), {"--selection=blocks"}), 2,
             3);
}

TEST(MleReproducePlants, MoreOutputsThanInputs) {
  const ScratchFolder scratch;
  const auto plant = [](double gain) {
    return Model({"a", "b", "c"}, {"u", "v"},
                 {{0, 0, FirstOrder(gain, 4, 1)},
                  {1, 1, FirstOrder(-3, 5, 1)},
                  {2, 0, FirstOrder(1, 7, 1)}});
  };
  ExpectCase(RunCase(scratch, plant(2), plant(1), {"--selection=blocks"}), 3,
             2);
}

TEST(MleReproducePlants, NamesOfAnyKind) {
  const ScratchFolder scratch;
  const std::vector<std::string> outputs = {"Kopf, °C", "Sumpf \"x_D\""};
  const std::vector<std::string> inputs = {"Rücklauf <b>&amp;", "蒸気"};
  const auto plant = [&](double gain) {
    return Model(outputs, inputs,
                 {{0, 0, FirstOrder(gain, 4, 1)},
                  {0, 1, FirstOrder(0.5, 6, 2)},
                  {1, 0, FirstOrder(0.7, 6, 2)},
                  {1, 1, FirstOrder(-3, 5, 1)}});
  };
  const nlohmann::json result =
      RunCase(scratch, plant(2), plant(1.2), {"--figures=true", "--seeds=2"});
  ExpectCase(result, 2, 2);
  const auto responses = ParsedCsv(scratch / "out/step_response_aged.csv");
  ASSERT_EQ(responses[0].size(), 17u);
  EXPECT_EQ(responses[0][1], "Kopf, °C/Rücklauf <b>&amp; initial");
  EXPECT_EQ(responses[0][4], "Sumpf \"x_D\"/蒸気 initial");
  for (const auto& line : responses) EXPECT_EQ(line.size(), 17u);
  const std::string page = Content(scratch / "out/report.html");
  EXPECT_THAT(page, HasSubstr("Rücklauf &lt;b&gt;&amp;amp;"));
  EXPECT_THAT(page, Not(HasSubstr("Rücklauf <b>")));
}

// A plant of the user's own is not the paper's, whatever it is called.
TEST(MleReproducePlants, ThePapersFiguresStayWithThePapersCases) {
  const ScratchFolder scratch;
  const std::string model = MLE_SOURCE_FOLDER "/configs/wood_berry.json";
  const std::string aged = MLE_SOURCE_FOLDER "/configs/wood_berry_gain.json";
  const report::ProcessResult own = RunTested(
      SmallRun(scratch / "own", {"--model=" + model, "--plants=gain:" + aged}));
  const report::ProcessResult papers =
      RunTested(SmallRun(scratch / "paper", {"--cases=gain"}));
  ASSERT_EQ(own.exit_code, 0) << own.err;
  ASSERT_EQ(papers.exit_code, 0) << papers.err;
  EXPECT_THAT(papers.out, HasSubstr("0.0933"));
  EXPECT_THAT(own.out, Not(HasSubstr("0.0933")));
  EXPECT_EQ(Content(scratch / "own/results.json"),
            Content(scratch / "paper/results.json"));
}

}  // namespace
}  // namespace mle
