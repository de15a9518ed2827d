#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/watch/database.h"
#include "apps/watch/report.h"
#include "apps/watch/site.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "tests/apps/watch/watched_site.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;
using ::testing::Pair;
using ::testing::SizeIs;

constexpr char kToken[] = "0123456789abcdef";

class RoutesTest : public ::testing::Test {
 protected:
  RoutesTest() {
    absl::StatusOr<std::unique_ptr<Site>> site =
        Site::Open({.list = files_.List(),
                    .state = files_.StatePath(),
                    .folder = files_.folder(),
                    .can_acknowledge = true});
    EXPECT_TRUE(site.ok()) << site.status();
    site_ = *std::move(site);
    EXPECT_TRUE(site_->Refresh(nullptr).ok());
  }

  static serve::Request Request(const std::string& method,
                                const std::string& target) {
    return serve::ParseHead({.method = method,
                             .target = target,
                             .version = "HTTP/1.1",
                             .headers = {{"Host", "localhost:80"}}})
        .request;
  }
  serve::Response Get(const std::string& target) {
    return Answer(*site_, access_, Request("GET", target));
  }
  nlohmann::json GetJson(const std::string& target) {
    const serve::Response response = Get(target);
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.content_type, "application/json");
    return nlohmann::json::parse(*response.body);
  }
  serve::Response Post(const std::string& id, const std::string& body,
                       const std::string& token = kToken) {
    serve::Request request = Request(
        "POST", absl::StrCat("/api/v1/alarms/", id, "/acknowledgement"));
    request.authorization = absl::StrCat("Bearer ", token);
    request.body = body;
    return Answer(*site_, access_, request);
  }
  serve::Response PostForm(const std::string& body,
                           const std::string& origin = "http://localhost:80") {
    serve::Request request = Request("POST", "/acknowledge");
    request.content_type = "application/x-www-form-urlencoded";
    request.origin = origin;
    request.body = body;
    return Answer(*site_, access_, request);
  }
  bool IsAcknowledged() {
    State state = files_.OpenState();
    const absl::StatusOr<Watch> watch = state.Load("a 1", 1);
    return watch.ok() && watch->alarms.at(0).acknowledged.has_value();
  }

  WatchedSite files_;
  std::unique_ptr<Site> site_;
  serve::Access access_ = {.token = kToken};
};

TEST_F(RoutesTest, PagesShowWhatTheStateHas) {
  for (const char* path : {"/", "/index.html"}) {
    const std::string page = *Get(path).body;
    // Those with alarms first.
    EXPECT_LT(page.find("controller-a_201.html"),
              page.find("controller-b.html"));
    EXPECT_THAT(page, HasSubstr("No run has looked at it yet."));
  }
  EXPECT_THAT(*Get("/controller-a_201.html").body,
              AllOf(HasSubstr("Trend"), HasSubstr("<form method=\"post\"")));
  EXPECT_THAT(*Get("/alarms.html").body, HasSubstr("01234567"));
  EXPECT_EQ(Get("/controller-d.html").status, 404);
  EXPECT_EQ(Get("/nothing").status, 404);
}

TEST_F(RoutesTest, HostileNamesAreText) {
  for (const char* path :
       {"/", "/alarms.html", "/controller-a_201.html", "/controller-b.html"}) {
    EXPECT_THAT(*Get(path).body, Not(HasSubstr("<b data-injected"))) << path;
  }
  EXPECT_EQ(GetJson("/api/v1/controllers/a_201")["elements"][0]["output"],
            kHostileTag);
  EXPECT_THAT(*Get("/metrics").body,
              HasSubstr("mle_watch_element_health{controller=\"a 1\","
                        "output=\"<b data-injected=1>\\\"'&\\\\</script>"
                        "<script>x</script>\",input=\"steam\"} "));
}

TEST_F(RoutesTest, LabelsKeepLinesAndQuotes) {
  EXPECT_EQ(EscapeLabel("a\\b\"c\nd\xff"), "a\\\\b\\\"c d\xEF\xBF\xBD");
}

TEST_F(RoutesTest, EachMetricIsDescribedOnceAndHasNumbers) {
  const std::string text = *Get("/metrics").body;
  EXPECT_EQ(Get("/metrics").content_type,
            "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_THAT(text, HasSubstr("mle_watch_up 1\n"));
  EXPECT_THAT(text, HasSubstr("mle_watch_status{controller=\"a 1\","
                              "status=\"aged\"} 1\n"));
  EXPECT_THAT(text, HasSubstr("mle_watch_status{controller=\"b\","
                              "status=\"aged\"} 0\n"));
  EXPECT_THAT(text, HasSubstr("mle_watch_alarms{controller=\"a 1\","
                              "acknowledged=\"false\"} 1\n"));
  // What has not been looked at has no health.
  EXPECT_THAT(text, HasSubstr("mle_watch_health{controller=\"b\"} "));
  EXPECT_THAT(text, Not(HasSubstr("mle_watch_health{controller=\"c\"} ")));
  EXPECT_EQ(text.back(), '\n');
}

TEST_F(RoutesTest, ProgramsGetJson) {
  EXPECT_THAT(GetJson("/watch.json")["controllers"], SizeIs(3));
  const nlohmann::json all = GetJson("/api/v1/controllers")["controllers"];
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[1]["id"], "a_201");
  EXPECT_EQ(all[1]["open_alarms"], 1);
  EXPECT_EQ(all[0]["open_alarms"], 0);
  const nlohmann::json aged =
      GetJson("/api/v1/controllers?status=aged")["controllers"];
  ASSERT_THAT(aged, SizeIs(1));
  EXPECT_EQ(aged[0]["name"], "a 1");
  EXPECT_THAT(GetJson("/api/v1/controllers?search=B")["controllers"],
              SizeIs(1));
  const nlohmann::json one = GetJson("/api/v1/controllers/a_201");
  EXPECT_EQ(one["alarms"][0]["id"], kAlarmId);
  EXPECT_TRUE(one["alarms"][0]["acknowledged"].is_null());
  EXPECT_EQ(Get("/api/v1/controllers/x").status, 404);
  EXPECT_EQ(Get("/api/v1/").status, 404);
}

TEST_F(RoutesTest, HistoriesAreCutByDays) {
  const nlohmann::json history =
      GetJson("/api/v1/controllers/a_201/history")["history"];
  ASSERT_THAT(history, SizeIs(3));
  EXPECT_EQ(history[0]["time"], "2026-02-17T00:00:00Z");
  EXPECT_GT(history[0]["health"], history[2]["health"]);
  EXPECT_THAT(GetJson("/api/v1/controllers/a_201/history?from=2026-02-17&"
                      "to=2026-02-17")["history"],
              SizeIs(1));
  for (const char* bad : {"from=yesterday", "to=2026-02-30", "from=2026-2-1",
                          "from=2026-02-17T00:00:00"}) {
    EXPECT_EQ(
        Get(absl::StrCat("/api/v1/controllers/a_201/history?", bad)).status,
        400)
        << bad;
  }
}

TEST_F(RoutesTest, FilesOfCorrectionsAndNoOthers) {
  const serve::Response report = Get("/proposals/b/2026-01-01/report.html");
  EXPECT_EQ(report.status, 200);
  EXPECT_EQ(report.file_bytes, 8U);
  EXPECT_EQ(report.content_type, "text/html; charset=utf-8");
  std::filesystem::create_symlink("/etc/passwd",
                                  files_.folder() + "/proposals/b/link.txt");
  std::filesystem::create_directory_symlink("/etc",
                                            files_.folder() + "/proposals/etc");
  std::ofstream(files_.folder() + "/proposals/b/.hidden") << "x";
  for (const char* path :
       {"/proposals/", "/proposals/b", "/proposals/b/2026-01-01",
        "/proposals/b/2026-01-01/", "/proposals/../state.sqlite",
        "/proposals/b/../../state.sqlite", "/proposals/%2e%2e/state.sqlite",
        "/proposals//etc/passwd", "/proposals/b/link.txt",
        "/proposals/etc/passwd", "/proposals/b/.hidden", "/../controllers.json",
        "/state.sqlite", "/proposals/a/b/c/d/e/f"}) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
}

TEST_F(RoutesTest, EveryAnswerIsGuarded) {
  for (const char* path : {"/", "/metrics", "/watch.json", "/nothing",
                           "/proposals/b/2026-01-01/report.html"}) {
    const auto headers = Get(path).headers;
    EXPECT_THAT(headers, Contains(Pair("X-Content-Type-Options", "nosniff")));
    EXPECT_THAT(headers, Contains(Pair("X-Frame-Options", "DENY")));
    EXPECT_THAT(headers, Contains(Pair("Content-Security-Policy",
                                       AllOf(HasSubstr("default-src 'none'"),
                                             HasSubstr("frame-ancestors "
                                                       "'none'")))));
    EXPECT_THAT(headers, Not(Contains(Key("Access-Control-Allow-Origin"))));
  }
}

TEST_F(RoutesTest, OtherNamesOfTheServerAreRefused) {
  serve::Request request = Request("GET", "/watch.json");
  request.host = "attacker.example";
  EXPECT_EQ(Answer(*site_, access_, request).status, 403);
  access_.host_names = {"attacker.example"};
  EXPECT_EQ(Answer(*site_, access_, request).status, 200);
}

TEST_F(RoutesTest, OtherMethodsAreRefused) {
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "TRACE"}) {
    const serve::Response response =
        Answer(*site_, access_, Request(method, "/"));
    EXPECT_EQ(response.status, 405);
    EXPECT_THAT(response.headers, Contains(Key("Allow")));
  }
  EXPECT_EQ(Answer(*site_, access_, Request("HEAD", "/")).status, 200);
}

TEST_F(RoutesTest, AnAlarmIsAcknowledgedWithTheToken) {
  const serve::Response response =
      Post(kAlarmId, R"({"who": " Ann\n<b>", "note": "valve"})");
  EXPECT_EQ(response.status, 200);
  EXPECT_TRUE(IsAcknowledged());
  // At once, wherever it is shown.
  const nlohmann::json made =
      GetJson("/api/v1/alarms")["alarms"][0]["acknowledged"];
  EXPECT_EQ(made["who"], "Ann <b>");
  EXPECT_EQ(made["note"], "valve");
  EXPECT_THAT(GetJson("/api/v1/alarms?open=true")["alarms"], SizeIs(0));
  EXPECT_THAT(*Get("/").body, HasSubstr("acknowledged by Ann &lt;b&gt; at "));
  EXPECT_THAT(
      *Get("/controller-a_201.html").body,
      AllOf(HasSubstr("by Ann &lt;b&gt; at "), Not(HasSubstr("<form"))));
  EXPECT_THAT(*Get("/metrics").body,
              HasSubstr("mle_watch_alarms{controller=\"a 1\","
                        "acknowledged=\"true\"} 1\n"));
  EXPECT_EQ(Post(kAlarmId, R"({"who": "Bob"})").status, 409);
}

TEST_F(RoutesTest, WhatIsWrongWithAnAcknowledgementIsSaid) {
  EXPECT_EQ(Post(kAlarmId, R"({"who": "Ann"})", "0123456789abcdeX").status,
            401);
  EXPECT_EQ(Post(kAlarmId, R"({"who": "Ann"})", "").status, 401);
  EXPECT_EQ(Post("0000", R"({"who": "Ann"})").status, 404);
  for (const char* body : {"", "[", "[]", R"({"note": "x"})", R"({"who": 1})",
                           R"({"who": " "})"}) {
    EXPECT_EQ(Post(kAlarmId, body).status, 400) << body;
  }
  EXPECT_EQ(
      Post(kAlarmId, absl::StrCat(R"({"who": ")", std::string(300, 'a'), "\"}"))
          .status,
      400);
  EXPECT_FALSE(IsAcknowledged());
}

TEST_F(RoutesTest, WithoutATokenNothingChanges) {
  access_.token = "";
  EXPECT_EQ(Post(kAlarmId, R"({"who": "Ann"})", "").status, 403);
  EXPECT_EQ(PostForm(absl::StrCat("who=Ann&token=&alarm=", kAlarmId)).status,
            403);
  EXPECT_FALSE(IsAcknowledged());
}

TEST_F(RoutesTest, AFormOfThePageAcknowledges) {
  const std::string body =
      absl::StrCat("who=Ann&note=a+b&token=", kToken, "&alarm=", kAlarmId);
  // Not from another site, even with the token.
  EXPECT_EQ(PostForm(body, "https://attacker.example").status, 403);
  EXPECT_EQ(PostForm(body, "null").status, 403);
  EXPECT_EQ(PostForm(absl::StrCat("who=Ann&token=x&alarm=", kAlarmId)).status,
            401);
  EXPECT_EQ(PostForm("who=%").status, 400);
  EXPECT_FALSE(IsAcknowledged());
  const serve::Response response = PostForm(body);
  EXPECT_EQ(response.status, 303);
  EXPECT_THAT(response.headers,
              Contains(Pair("Location", "/controller-a_201.html")));
  EXPECT_TRUE(IsAcknowledged());
}

TEST_F(RoutesTest, WhatOthersWriteIsShown) {
  State state = files_.OpenState();
  Watch watch = WatchedSite::MakeWatch("c", false);
  ASSERT_TRUE(state.Save(watch).ok());
  while (GetJson("/api/v1/controllers")["controllers"][2]["status"] !=
         "healthy") {
    absl::SleepFor(absl::Milliseconds(5));
    EXPECT_TRUE(site_->Refresh(nullptr).ok());
  }
  EXPECT_EQ(GetJson("/api/v1/controllers/c")["status"], "healthy");
}

// Outlooks of those that have not changed are not computed again, by any number
// of threads.
TEST_F(RoutesTest, WhatIsReadAnewIsWhatIsReadFirst) {
  State state = files_.OpenState();
  absl::StatusOr<Watch> watch = state.Load("b", 1);
  ASSERT_TRUE(watch.ok()) << watch.status();
  // Enough for a trend.
  for (int day = 3; day < 40; ++day) {
    watch->days[watch->first + day] = {"x", BatchState::kUsed, ""};
    StoredBatch& stored = watch->outputs[0][day] = watch->outputs[0].at(2);
    stored.batch.number = stored.evidence.number = day;
  }
  ASSERT_TRUE(state.Save(*watch).ok());
  const auto before = site_->snapshot();
  while (site_->snapshot() == before) {
    absl::SleepFor(absl::Milliseconds(5));
    EXPECT_TRUE(site_->Refresh(nullptr).ok());
  }
  for (const int threads : {1, 3}) {
    const absl::StatusOr<std::unique_ptr<Site>> anew =
        Site::Open({.list = files_.List(),
                    .state = files_.StatePath(),
                    .folder = files_.folder(),
                    .threads = threads});
    ASSERT_TRUE(anew.ok()) << anew.status();
    ASSERT_TRUE((*anew)->Refresh(nullptr).ok());
    EXPECT_EQ(*site_->snapshot()->watch_json, *(*anew)->snapshot()->watch_json);
    EXPECT_EQ(*site_->snapshot()->overview, *(*anew)->snapshot()->overview);
  }
}

TEST_F(RoutesTest, ADamagedControllerIsShownBesideTheOthers) {
  const auto database = Database::Open(files_.StatePath());
  ASSERT_TRUE(database.ok());
  ASSERT_TRUE((*database)
                  ->Execute("UPDATE day SET number = number + 1000 WHERE watch "
                            "= (SELECT id FROM watch WHERE controller = 'b')")
                  .ok());
  absl::StatusOr<std::unique_ptr<Site>> site = Site::Open(
      {.list = files_.List(), .state = files_.StatePath(), .folder = "."});
  ASSERT_TRUE(site.ok()) << site.status();
  site_ = *std::move(site);
  ASSERT_TRUE(site_->Refresh(nullptr).ok());
  const nlohmann::json all = GetJson("/watch.json")["controllers"];
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[0]["status"], "failed");
  EXPECT_THAT(std::string(all[0]["sentence"]), HasSubstr("is damaged"));
  EXPECT_EQ(all[1]["status"], "aged");
  EXPECT_THAT(*Get("/controller-b.html").body, HasSubstr("is damaged"));
}

TEST_F(RoutesTest, AListThatCannotBeReadLeavesWhatWasThere) {
  std::ofstream(files_.List()) << "{";
  while (site_->snapshot()->fault.empty()) {
    absl::SleepFor(absl::Milliseconds(5));
    EXPECT_TRUE(site_->Refresh(nullptr).ok());
  }
  EXPECT_THAT(GetJson("/api/v1/controllers")["controllers"], SizeIs(3));
  EXPECT_THAT(*Get("/metrics").body, HasSubstr("mle_watch_up 0\n"));
  EXPECT_THAT(*Get("/").body, HasSubstr("This is what was read before: "));
}

TEST_F(RoutesTest, BeforeTheFirstReadingItIsSaid) {
  const absl::StatusOr<std::unique_ptr<Site>> site = Site::Open(
      {.list = files_.List(), .state = files_.StatePath(), .folder = "."});
  ASSERT_TRUE(site.ok()) << site.status();
  const serve::Response early = Answer(**site, access_, Request("GET", "/"));
  EXPECT_EQ(early.status, 503);
  EXPECT_THAT(early.headers, Contains(Key("Retry-After")));
  ASSERT_TRUE((*site)->Refresh(nullptr).ok());
  EXPECT_EQ(Answer(**site, access_, Request("GET", "/")).status, 200);
}

TEST_F(RoutesTest, AListThatCannotBeReadAtFirstIsAnError) {
  std::ofstream(files_.List()) << "{";
  const absl::StatusOr<std::unique_ptr<Site>> site = Site::Open(
      {.list = files_.List(), .state = files_.StatePath(), .folder = "."});
  ASSERT_TRUE(site.ok()) << site.status();
  EXPECT_FALSE((*site)->Refresh(nullptr).ok());
}

// A reading has begun before the alarm is acknowledged, and ends after it.
TEST_F(RoutesTest, WhatWasReadLastIsShown) {
  absl::StatusOr<std::unique_ptr<Site>> site =
      Site::Open({.list = files_.List(),
                  .state = files_.StatePath(),
                  .folder = ".",
                  .threads = 1});
  ASSERT_TRUE(site.ok()) << site.status();
  site_ = *std::move(site);
  ASSERT_TRUE(site_->Refresh(nullptr).ok());
  State state = files_.OpenState();
  absl::StatusOr<Watch> watch = state.Load("c", 1);
  ASSERT_TRUE(watch.ok()) << watch.status();
  watch->news = "changed";
  ASSERT_TRUE(state.Save(*watch).ok());
  int asked = 0;  // before "b", "a 1" and "c"
  ASSERT_TRUE(site_
                  ->Refresh([&] {
                    if (++asked == 3) {
                      EXPECT_TRUE(
                          site_->Acknowledge(kAlarmId, {.who = "Ann"}).ok());
                    }
                    return false;
                  })
                  .ok());
  ASSERT_EQ(asked, 3);
  EXPECT_EQ(GetJson("/api/v1/alarms?open=true")["alarms"].size(), 0u);
}

TEST_F(RoutesTest, AStateThatIsReplacedIsSaid) {
  const std::string state = files_.StatePath();
  std::filesystem::copy_file(state, state + ".copy");
  std::filesystem::rename(state + ".copy", state);
  EXPECT_THAT(
      std::string(site_->Acknowledge(kAlarmId, {.who = "Ann"}).message()),
      HasSubstr("removed or replaced"));
  std::filesystem::remove(state);
  EXPECT_EQ(Post(kAlarmId, R"({"who": "Ann"})").status, 503);
  while (site_->snapshot()->fault.empty()) {
    ASSERT_TRUE(site_->Refresh(nullptr).ok());
  }
  EXPECT_THAT(site_->snapshot()->fault, HasSubstr("removed or replaced"));
  EXPECT_THAT(GetJson("/api/v1/controllers")["controllers"], SizeIs(3));
}

}  // namespace
}  // namespace mle::watch
