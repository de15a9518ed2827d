#include "tests/apps/readable_page.h"

#include <cstddef>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/report/browser.h"

namespace mle {
namespace {

using ::testing::IsEmpty;
using ::testing::StartsWith;

void ExpectPromise(const PagePromise& promise, int width,
                   const nlohmann::json& found) {
  if (promise.badge.empty()) return;
  EXPECT_EQ(found["badge"], promise.badge);
  EXPECT_GE(found["folds"], promise.least_folds);
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
  if (promise.copies.empty()) return;
  EXPECT_THAT(found["copied"]["text"].get<std::string>(),
              StartsWith(promise.copies));
  EXPECT_NE(found["copied"]["says"], "Copy the table");
}

}  // namespace

void ExpectReadable(const std::string& path, const std::string& name,
                    int panels, const PagePromise& promise) {
  const std::string html = Content(path);
  EXPECT_LE(html.size(), 1'000'000U);
  const std::vector<int> widths = {390, 768, 1440, 1920};
  const auto light = report::VisitPage(html, widths, name);
  const auto dark = report::VisitPage(html, {1440}, name, report::Mode::kDark);
  for (std::size_t i = 0; i <= widths.size(); ++i) {
    const bool is_dark = i == widths.size();
    const int width = is_dark ? 1440 : widths[i];
    const report::BrowserVisit& visit = is_dark ? dark.front() : light[i];
    ASSERT_EQ(visit.error, "");
    EXPECT_FALSE(visit.other_picture) << name << " at " << width;
    EXPECT_EQ(visit.found["dark"], is_dark);
    EXPECT_THAT(visit.console, IsEmpty());
    EXPECT_EQ(visit.found["panels"], panels);
    EXPECT_EQ(visit.found["requests"], nlohmann::json::array());
    EXPECT_EQ(visit.found["injected"], 0);
    EXPECT_LE(visit.found["overflow"], 0) << "at " << width;
    EXPECT_EQ(visit.found["faint"], nlohmann::json::array());
    EXPECT_EQ(visit.found["overlapping"], nlohmann::json::array());
    EXPECT_EQ(visit.found["unreachable"], nlohmann::json::array());
    ExpectPromise(promise, width, visit.found);
  }
}

void ExpectFitsPaper(const std::string& path, const std::string& name) {
  // A4 less its margins, at 96 pixels an inch.
  constexpr int kPaper = 672;
  const std::string html = absl::StrReplaceAll(
      Content(path),
      {{"@media print", "@media all"}, {"@media screen", "@media tty"}});
  const report::BrowserVisit visit =
      report::VisitPage(html, {kPaper}, name).front();
  ASSERT_EQ(visit.error, "");
  EXPECT_LE(visit.found["overflow_folded"], 0);
  EXPECT_LE(visit.found["overflow"], 0);
  EXPECT_EQ(visit.found["faint"], nlohmann::json::array());
}

}  // namespace mle
