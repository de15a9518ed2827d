// The overview of a thousand controllers in a real browser.

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/serve/server.h"
#include "apps/watch/report.h"
#include "apps/watch/site.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/report/browser.h"
#include "tests/apps/watch/watched_site.h"

namespace mle::watch {
namespace {

using report::Mode;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kListed = 1000;

// A tenth has aged, of which half is acknowledged; a twentieth cannot be read.
class Site1000 {
 public:
  Site1000() {
    for (int i = 0; i < kListed; ++i) {
      const bool is_aged = i % 10 == 3;
      watches_.push_back(WatchedSite::MakeWatch("", is_aged));
      Watch& watch = watches_.back();
      if (is_aged && i % 20 == 3) {
        watch.alarms[0].acknowledged = {.who = "Ann", .at = 1'770'000'000};
      }
      Report report;
      report.name = absl::StrFormat("unit %02d:FIC-%03d", i / 50, i);
      report.watch = &watch;
      report.status = is_aged       ? Status::kAged
                      : i % 20 == 7 ? Status::kFailed
                                    : Status::kHealthy;
      report.health = is_aged ? 0.02 : 0.98 - 1e-4 * i;
      report.last_day = 20'500;
      report.used_days = i;
      report.sentence =
          is_aged ? absl::StrCat("The model of ", kHostileTag,
                                 " has aged. Most likely (97 %) it is level ← "
                                 "steam: its gain has changed by −9.8 ± 1.2 %, "
                                 "since about 2026-01-26.")
          : report.status == Status::kFailed
              ? "records: cannot read /var/lib/historian/unit/folder"
              : "No evidence of ageing in 112 days with changes of set points.";
      reports_.push_back(std::move(report));
    }
  }
  const std::vector<Report>& reports() const { return reports_; }

 private:
  std::deque<Watch> watches_;
  std::vector<Report> reports_;
};

class OverviewBrowserTest : public ::testing::TestWithParam<Mode> {};

TEST_P(OverviewBrowserTest, AThousandRowsAreSortedAndFiltered) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const Site1000 site;
  // In the dark other colours are looked at, which no width changes.
  const std::vector<int> widths = GetParam() == Mode::kDark
                                      ? std::vector<int>{1440}
                                      : std::vector<int>{390, 1440};
  for (const report::BrowserVisit& visit :
       report::VisitPage(FormatOverview(site.reports()), widths,
                         "watch_overview", GetParam())) {
    ASSERT_EQ(visit.error, "");
    EXPECT_THAT(visit.console, IsEmpty());
    const nlohmann::json& found = visit.found;
    EXPECT_EQ(found["injected"], 0);
    EXPECT_LE(found["overflow"], 0);
    EXPECT_EQ(found["faint"], nlohmann::json::array());
    EXPECT_EQ(found["unreachable"], nlohmann::json::array());
    EXPECT_EQ(found["requests"], nlohmann::json::array());
    const nlohmann::json& table = found["filtered"];
    EXPECT_EQ(table["rows"], kListed);
    EXPECT_EQ(table["shown"], kListed);
    // Alarms that nobody has acknowledged come first.
    EXPECT_EQ(table["first"], "unit 00:FIC-013");
    EXPECT_EQ(table["searched"]["shown"], 1);
    EXPECT_EQ(table["searched"]["says"], "1 of 1,000");
    EXPECT_EQ(table["nothing"]["shown"], 0);
    EXPECT_EQ(table["cleared"]["shown"], kListed);
    EXPECT_THAT(table["choices"],
                ElementsAre("all", "aged", "failed", "healthy"));
    EXPECT_EQ(table["chosen"]["shown"], 100);
    EXPECT_EQ(table["all"]["shown"], kListed);
    EXPECT_EQ(table["ascending"], "unit 00:FIC-000");
    EXPECT_EQ(table["descending"], "unit 19:FIC-999");
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, OverviewBrowserTest,
                         ::testing::Values(Mode::kLight, Mode::kDark),
                         [](const auto& test) {
                           return test.param == Mode::kDark ? "Dark" : "Light";
                         });

TEST(ServedPagesBrowserTest, TheirScriptsAreThoseThatThePolicyAllows) {
  if (!report::HasBrowser()) GTEST_SKIP() << "no browser is installed";
  const WatchedSite files;
  auto site = Site::Open({.list = files.List(),
                          .state = files.StatePath(),
                          .folder = files.folder(),
                          .can_acknowledge = true});
  ASSERT_TRUE(site.ok()) << site.status();
  ASSERT_TRUE((*site)->Refresh([] { return false; }).ok());
  const serve::Access access = {.token = "0123456789abcdef"};
  const auto server =
      serve::Server::Start({}, [&](const serve::Request& request) {
        return Answer(**site, access, request);
      });
  ASSERT_TRUE(server.ok());
  for (const char* path : {"", "alarms.html", "controller-a_201.html"}) {
    const report::BrowserVisit visit = report::LoadUrl(
        absl::StrCat("http://127.0.0.1:", (*server)->port(), "/", path),
        "watch_served");
    EXPECT_EQ(visit.error, "");
    EXPECT_THAT(visit.console, IsEmpty()) << path;
    EXPECT_THAT(visit.found["dom"].get<std::string>(), HasSubstr("</main>"));
  }
}

}  // namespace
}  // namespace mle::watch
