// The page of a real run in a real browser: every figure is there, nothing is
// asked for from outside, no message on the console, nothing faint or
// overlapping.

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/apps/correct_runs.h"
#include "tests/apps/readable_page.h"
#include "tests/apps/report/browser.h"

namespace mle {
namespace {

#ifdef MLE_SIMULATE_COMMAND
// Seven outputs and inputs with the tags and units of a plant; each output
// hangs on two inputs. The first gain is multiplied by `factor`.
std::string SevenBySeven(double factor) {
  nlohmann::json model = {{"name", "Fractionator of unit 7"},
                          {"time_unit", "min"},
                          {"inputs", nlohmann::json::array()},
                          {"outputs", nlohmann::json::array()},
                          {"elements", nlohmann::json::array()}};
  const auto output = [](int i) { return absl::StrCat("TIC10", i, ".PV"); };
  const auto input = [](int j) { return absl::StrCat("FIC20", j, ".OP"); };
  for (int i = 0; i < 7; ++i) {
    model["outputs"].push_back({{"name", output(i)}, {"unit", "°C"}});
    model["inputs"].push_back({{"name", input(i)}, {"unit", "t/h"}});
    for (const int j : {i, (i + 1) % 7}) {
      const double gain = i == j ? 1.2 : -0.4;
      model["elements"].push_back({{"output", output(i)},
                                   {"input", input(j)},
                                   {"gain", i + j == 0 ? factor * gain : gain},
                                   {"time_constant", 4 + i},
                                   {"delay", 1}});
    }
  }
  return model.dump();
}

TEST(ReportPageTest, OfAPlantWithSevenOutputs) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const ScratchFolder scratch;
  const std::string model = scratch.Write("model.json", SevenBySeven(1.0));
  const std::string plant = scratch.Write("plant.json", SevenBySeven(0.6));
  std::string set_points = "--setpoints=";
  for (int i = 0; i < 7; ++i) {
    absl::StrAppend(&set_points, i > 0 ? "," : "", "TIC10", i,
                    ".PV:", 150 * (i + 1), ":1");
  }
  const std::string data = SimulateHeater(
      scratch, "run.csv", model, plant,
      {set_points, "--duration=1250", "--sample_time=1", "--control_period=2",
       "--prediction_horizon=20", "--control_horizon=3", "--output_weight=1",
       "--move_weight=1", "--noise_variance=1e-4"});
  Correct(CorrectionFlags(model, data, scratch / "out",
                          {"--figures=true", "--control_period=2",
                           "--prediction_horizon=20", "--control_horizon=3",
                           "--output_weight=1", "--move_weight=1"}),
          scratch / "out");
  const std::string page = scratch / "out/report.html";
  // The response that has changed, six of seven set points followed, fourteen
  // step responses and records, seven predictions and autocorrelations, and 49
  // cross-correlations.
  ExpectReadable(page, "seven", 98,
                 {.badge = "corrected",
                  .copies = "output\tinput\tgain\t",
                  .least_folds = 6});
  EXPECT_THAT(Content(page),
              ::testing::HasSubstr("6 set points whose control error changes"));
  ExpectFitsPaper(page, "seven_paper");
}

TEST(ReportPageTest, OfRecordsThatCannotTell) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const HeaterExample heater(WithHalvedGain(), {"--setpoints=y1:60:1"});
  heater.Run(
      {"--figures=true", "--estimator=arx", "--conversion_samples=20000"}, 1);
  const std::string page = heater.out + "/report.html";
  // Step responses and records of four, predictions and autocorrelations of
  // two, and four cross-correlations.
  ExpectReadable(page, "cannot_tell", 17,
                 {.badge = "cannot tell", .least_folds = 6});
  ExpectFitsPaper(page, "cannot_tell_paper");
  // The estimate is shown, and that nothing is written of it.
  EXPECT_THAT(Content(page),
              ::testing::ContainsRegex("gain × 0\\.[45][^<]*: not validated"));
}

TEST(ReportPageTest, OfACorrection) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const ScratchFolder scratch;
  Heater aged;
  aged.first.gain = 1.0;
  const std::string model = scratch.Write("model.json", HeaterJson(Heater()));
  const std::string plant = scratch.Write("plant.json", HeaterJson(aged));
  const std::string data = SimulateHeater(scratch, "run.csv", model, plant);
  Correct(CorrectionFlags(
              model, data, scratch / "out",
              {"--figures=true", "--truth=" + plant, "--control_period=0.5"}),
          scratch / "out");
  // The response that has changed, two set points followed, step responses of
  // four pairs, records of four channels, predictions of two outputs, two
  // autocorrelations and four cross-correlations.
  ExpectReadable(scratch / "out/report.html", "correction", 19,
                 {.badge = "corrected",
                  .copies = "output\tinput\tgain\t",
                  .least_folds = 6});
}
#else
TEST(ReportPageTest, OfAReproduction) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const ScratchFolder scratch;
  const report::ProcessResult run =
      RunTested(SmallRun(scratch / "out", {"--figures=true", "--cases=gain"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // Two of the overview, E over λ, step and impulse responses of four pairs,
  // and two outputs in each of two set-point changes.
  ExpectReadable(scratch / "out/report.html", "reproduction", 15);
}
#endif

}  // namespace
}  // namespace mle
