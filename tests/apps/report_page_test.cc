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

using ::testing::IsEmpty;

void ExpectReadable(const std::string& path, const std::string& name,
                    int panels) {
  const std::string html = Content(path);
  EXPECT_LE(html.size(), 1'000'000U);
  for (const auto& [width, mode] : {std::pair(375, report::Mode::kLight),
                                    {1024, report::Mode::kLight},
                                    {1024, report::Mode::kDark},
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
  // Step responses of four pairs, their map, records of four channels,
  // predictions of two outputs, two autocorrelations and four
  // cross-correlations.
  ExpectReadable(scratch / "out/report.html", "correction", 17);
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
