// The page of a real run in a real browser: every figure is there, nothing is
// asked for from outside, no message on the console, nothing faint or
// overlapping.

#include <string>
#include <utility>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/correct_runs.h"
#include "tests/apps/report/browser.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Screens of 900 and 844 pixels before a fold is opened, where a page promises
// how many it takes; and what its badge says.
struct Promise {
  std::string badge;
  double screens_at_1440 = 1e9;
  double screens_at_390 = 1e9;
};

void ExpectPromise(const Promise& promise, int width,
                   const nlohmann::json& found) {
  if (promise.badge.empty()) return;
  EXPECT_EQ(found["badge"], promise.badge);
  EXPECT_GT(found["folds"], 5);
  EXPECT_EQ(found["open"], 0);
  EXPECT_LE(found["overflow_folded"], 0) << "at " << width;
  EXPECT_EQ(found["faint_folded"], nlohmann::json::array());
  if (width >= 1440) {
    EXPECT_EQ(found["cut"], 0) << "at " << width;
    EXPECT_EQ(found["cut_open"], 0) << "at " << width;
    EXPECT_LE(found["height"].get<double>() / 900.0, promise.screens_at_1440);
  }
  if (width <= 390) {
    EXPECT_LE(found["height"].get<double>() / 844.0, promise.screens_at_390);
  }
  EXPECT_THAT(found["copied"]["text"].get<std::string>(),
              HasSubstr("output\tinput\tgain\t"));
  EXPECT_NE(found["copied"]["says"], "Copy the table");
}

void ExpectReadable(const std::string& path, const std::string& name,
                    int panels, const Promise& promise = {}) {
  const std::string html = Content(path);
  EXPECT_LE(html.size(), 1'000'000U);
  for (const auto& [width, mode] : {std::pair(390, report::Mode::kLight),
                                    {768, report::Mode::kLight},
                                    {1440, report::Mode::kLight},
                                    {1440, report::Mode::kDark},
                                    {1920, report::Mode::kLight}}) {
    const report::BrowserVisit visit =
        report::VisitPage(html, width, name, mode);
    ASSERT_EQ(visit.error, "");
    EXPECT_EQ(visit.found["dark"], mode == report::Mode::kDark);
    EXPECT_THAT(visit.console, IsEmpty());
    EXPECT_EQ(visit.found["panels"], panels);
    EXPECT_EQ(visit.found["requests"], nlohmann::json::array());
    EXPECT_EQ(visit.found["injected"], 0);
    EXPECT_LE(visit.found["overflow"], 0) << "at " << width;
    EXPECT_EQ(visit.found["faint"], nlohmann::json::array());
    EXPECT_EQ(visit.found["overlapping"], nlohmann::json::array());
    ExpectPromise(promise, width, visit.found);
  }
}

#ifdef MLE_SIMULATE_COMMAND
TEST(ReportPageTest, OfACorrection) {
  if (!report::HasBrowser()) GTEST_SKIP() << "chromium is not installed";
  const ScratchFolder scratch;
  Heater aged;
  aged.first.gain = 1.0;
  const std::string model = scratch.Write("model.json", HeaterJson(Heater()));
  const std::string plant = scratch.Write("plant.json", HeaterJson(aged));
  const std::string data = SimulateHeater(scratch, "run.csv", model, plant);
  Correct(CorrectionFlags(model, data, scratch / "out",
                          {"--figures=true", "--truth=" + plant}),
          scratch / "out");
  // The response that has changed, two set points followed, step responses of
  // four pairs, records of four channels, predictions of two outputs, two
  // autocorrelations and four cross-correlations.
  ExpectReadable(scratch / "out/report.html", "correction", 19,
                 {"corrected", 5.0, 10.0});
}
#else
TEST(ReportPageTest, OfAReproduction) {
  if (!report::HasBrowser()) GTEST_SKIP() << "chromium is not installed";
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
