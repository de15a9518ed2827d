#include "apps/serve/request.h"

#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "apps/serve/server.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/serve/client.h"

namespace mle::serve {
namespace {

using ::testing::Pair;
using ::testing::UnorderedElementsAre;

std::string HeadOf(const std::string& lines) {
  std::string head;
  for (const char c : lines) head += c == '\n' ? "\r\n" : std::string(1, c);
  return head + "\r\n";
}

TEST(ParseHeadTest, ReadsARequest) {
  const ParsedHead head =
      ParseHead({.method = "POST",
                 .target = "/a/b?x=1&y=%C3%A4+%26&x=2&z",
                 .version = "HTTP/1.1",
                 .headers = {{"hOsT", "localhost:80 "},
                             {"Origin", "http://localhost:80"},
                             {"Authorization", "Bearer t"},
                             {"X-Other", "?"},
                             {"Sec-Fetch-Site", "same-origin"},
                             {"Content-Type", "application/json"},
                             {"Content-Length", "12"}}});
  ASSERT_EQ(head.status, 200) << head.fault;
  const Request& request = head.request;
  EXPECT_EQ(request.method, "POST");
  EXPECT_EQ(request.path, "/a/b");
  EXPECT_THAT(
      request.query,
      UnorderedElementsAre(Pair("x", "2"), Pair("y", "ä &"), Pair("z", "")));
  EXPECT_EQ(request.host, "localhost:80");
  EXPECT_EQ(request.origin, "http://localhost:80");
  EXPECT_EQ(request.authorization, "Bearer t");
  EXPECT_EQ(request.fetch_site, "same-origin");
  EXPECT_EQ(request.content_type, "application/json");
  EXPECT_EQ(request.body_bytes, 12U);
}

// What a server answers to raw heads.
class RawHeadTest : public ::testing::Test {
 protected:
  RawHeadTest()
      : server_(*Server::Start({}, [](const Request& request) {
          return PlainResponse(200, request.host);
        })) {}
  int StatusOf(const std::string& head) const {
    return serve::StatusOf(Ask(server_->port(), head));
  }

  const std::unique_ptr<Server> server_;
};

struct Refused {
  std::string lines;
  int status;  // 0: the connection is closed without an answer
};

class RefusedHeadTest : public RawHeadTest,
                        public ::testing::WithParamInterface<Refused> {};

TEST_P(RefusedHeadTest, IsAnsweredWithItsStatus) {
  EXPECT_EQ(StatusOf(HeadOf(GetParam().lines)), GetParam().status);
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedHeadTest,
    ::testing::Values(
        Refused{"GET /\nHost: a\n", 400}, Refused{"NONSENSE\nHost: a\n", 0},
        Refused{"GET  / HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /  HTTP/1.1\nHost: a\n", 0},
        Refused{"GET / b HTTP/1.1\nHost: a\n", 0},
        Refused{"GET / HTTP/1.1 \nHost: a\n", 400},
        Refused{"GET\t/ HTTP/1.1\nHost: a\n", 400},
        Refused{"G@T / HTTP/1.1\nHost: a\n", 400},
        Refused{"GET http://a/ HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /\x01 HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /?a=%4 HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /?%xy HTTP/1.1\nHost: a\n", 400},
        Refused{"GET / HTTP/2.0\nHost: a\n", 505},
        Refused{"GET / HTTP/1.2\nHost: a\n", 505},
        Refused{"GET / FTP\nHost: a\n", 400},
        Refused{
            "GET /" + std::string(kMostTarget, 'a') + " HTTP/1.1\nHost: a\n",
            414},
        // No host, or two.
        Refused{"GET / HTTP/1.1\n", 400},
        Refused{"GET / HTTP/1.1\nHost:\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\nHost: b\n", 400},
        // Lines that two programs read differently.
        Refused{"GET / HTTP/1.1\nHost : a\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\nX : a\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\n b\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\nX: a\n b\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\rX: b\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\r\n", 400},
        Refused{std::string("GET / HTTP/1.1\nHost: a\0b\n", 25), 400},
        Refused{std::string("GET /\0a HTTP/1.1\nHost: a\n", 25), 400},
        Refused{std::string("GET / HTTP/1.1\nHost: a\n\0X: b\n", 30), 400},
        Refused{"GET / HTTP/1.1\nHost: a\nno colon\n", 400},
        // Bodies whose length is not plain.
        Refused{"POST / HTTP/1.1\nHost: a\nContent-Length: +1\n", 400},
        Refused{"POST / HTTP/1.1\nHost: a\nContent-Length: 1, 1\n", 400},
        Refused{"POST / HTTP/1.1\nHost: a\nContent-Length: 1\n"
                "Content-Length: 1\n",
                400},
        Refused{"POST / HTTP/1.1\nHost: a\nContent-Length: 99999\n", 413},
        Refused{"POST / HTTP/1.1\nHost: a\n"
                "Content-Length: 99999999999999999999\n",
                413},
        Refused{"POST / HTTP/1.1\nHost: a\nTransfer-Encoding: chunked\n", 411},
        Refused{"GET / HTTP/1.1\nHost: a\nContent-Length: 1\n", 400},
        Refused{"POST / HTTP/1.1\nHost: a\nExpect: 100-continue\n", 417}));

TEST_F(RawHeadTest, BlanksAroundAValueAreTheSenders) {
  for (const char* const host :
       {"Host:a", "Host: a", "Host:  a\t", "hOST:a "}) {
    EXPECT_EQ(
        BodyOf(Ask(server_->port(),
                   absl::StrCat("GET / HTTP/1.1\r\n", host, "\r\nX:\r\n\r\n"))),
        "a\n")
        << host;
  }
  EXPECT_EQ(StatusOf("GET / HTTP/1.0\r\n\r\n"), 200);
}

TEST_F(RawHeadTest, HeadersAreCounted) {
  std::string lines = "GET / HTTP/1.1\nHost: a\n";
  for (int i = 1; i < kMostHeaders; ++i) lines += "X: y\n";
  EXPECT_EQ(StatusOf(HeadOf(lines)), 200);
  EXPECT_EQ(StatusOf(HeadOf(lines + "X: y\n")), 431);
}

TEST_F(RawHeadTest, ALineFeedAloneEndsNoLine) {
  const std::string right = "GET / HTTP/1.1\r\nHost: a\r\nX: b\r\n\r\n";
  EXPECT_EQ(StatusOf(right), 200);
  for (std::size_t at = right.find('\r'); at != std::string::npos;
       at = right.find('\r', at + 1)) {
    std::string wrong = right;
    wrong.erase(at, 1);
    EXPECT_EQ(StatusOf(wrong), 400) << at;
    // Made up for by a blank.
    wrong.insert(wrong.find("Host: ") + 6, " ");
    EXPECT_EQ(StatusOf(wrong), 400) << at;
  }
}

TEST(ParseFormTest, ReadsFieldsOrNothing) {
  EXPECT_THAT(ParseForm("who=Ann+B&note=a%3Db&&").value(),
              UnorderedElementsAre(Pair("who", "Ann B"), Pair("note", "a=b")));
  EXPECT_FALSE(ParseForm("a=%").has_value());
  EXPECT_FALSE(ParseForm("a=%-1").has_value());
}

}  // namespace
}  // namespace mle::serve
