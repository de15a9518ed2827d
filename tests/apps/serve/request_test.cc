#include "apps/serve/request.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::serve {
namespace {

using ::testing::Pair;
using ::testing::UnorderedElementsAre;

// With the end of each line.
ParsedHead Parse(const std::string& lines) {
  std::string head;
  for (const char c : lines) head += c == '\n' ? "\r\n" : std::string(1, c);
  return ParseHead(head + "\r\n");
}

TEST(ParseHeadTest, ReadsARequest) {
  const ParsedHead head = Parse(
      "POST /a/b?x=1&y=%C3%A4+%26&x=2&z HTTP/1.1\nhOsT: localhost:80 \n"
      "Origin: http://localhost:80\nAuthorization: Bearer t\nX-Other: ?\n"
      "Sec-Fetch-Site: same-origin\nContent-Type: application/json\n"
      "Content-Length: 12\n");
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
  EXPECT_TRUE(request.keep_alive);
}

TEST(ParseHeadTest, ConnectionsAreKeptAsTheVersionSays) {
  EXPECT_TRUE(Parse("GET / HTTP/1.1\nHost: a\n").request.keep_alive);
  EXPECT_FALSE(Parse("GET / HTTP/1.1\nHost: a\nConnection: x, Close\n")
                   .request.keep_alive);
  EXPECT_FALSE(Parse("GET / HTTP/1.0\nHost: a\n").request.keep_alive);
  EXPECT_TRUE(
      Parse("GET / HTTP/1.0\nConnection: keep-alive\n").request.keep_alive);
}

struct Refused {
  std::string lines;
  int status;
};

class RefusedHeadTest : public ::testing::TestWithParam<Refused> {};

TEST_P(RefusedHeadTest, IsAnsweredWithItsStatus) {
  const ParsedHead head = Parse(GetParam().lines);
  EXPECT_EQ(head.status, GetParam().status);
  EXPECT_NE(head.fault, "");
}

INSTANTIATE_TEST_SUITE_P(
    All, RefusedHeadTest,
    ::testing::Values(
        Refused{"\n", 400}, Refused{"GET /\nHost: a\n", 400},
        Refused{"GET  / HTTP/1.1\nHost: a\n", 400},
        Refused{"G@T / HTTP/1.1\nHost: a\n", 400},
        Refused{"GET http://a/ HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /\x01 HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /?a=%4 HTTP/1.1\nHost: a\n", 400},
        Refused{"GET /?%xy HTTP/1.1\nHost: a\n", 400},
        Refused{"GET / HTTP/2.0\nHost: a\n", 505},
        Refused{"GET / FTP\nHost: a\n", 400},
        Refused{"GET /" + std::string(kMostTarget, 'a') + " HTTP/1.1\n", 414},
        // No host, or two.
        Refused{"GET / HTTP/1.1\n", 400},
        Refused{"GET / HTTP/1.1\nHost:\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\nHost: b\n", 400},
        // Lines that two programs read differently.
        Refused{"GET / HTTP/1.1\nHost : a\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\n b\n", 400},
        Refused{"GET / HTTP/1.1\nHost: a\rX: b\n", 400},
        Refused{std::string("GET / HTTP/1.1\nHost: a\0b\n", 25), 400},
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
        Refused{"POST / HTTP/1.1\nHost: a\nExpect: 100-continue\n", 417}),
    [](const auto& test) {
      return absl::StrCat("Head", test.index, "Is", test.param.status);
    });

TEST(ParseHeadTest, HeadersAreCounted) {
  std::string lines = "GET / HTTP/1.1\nHost: a\n";
  for (int i = 1; i < kMostHeaders; ++i) lines += "X: y\n";
  EXPECT_EQ(Parse(lines).status, 200);
  EXPECT_EQ(Parse(lines + "X: y\n").status, 431);
}

TEST(ParseHeadTest, ALineFeedAloneEndsNoLine) {
  EXPECT_EQ(ParseHead("GET / HTTP/1.1\nHost: a\n\r\n\r\n").status, 400);
}

TEST(ParseFormTest, ReadsFieldsOrNothing) {
  EXPECT_THAT(ParseForm("who=Ann+B&note=a%3Db&&").value(),
              UnorderedElementsAre(Pair("who", "Ann B"), Pair("note", "a=b")));
  EXPECT_FALSE(ParseForm("a=%").has_value());
  EXPECT_FALSE(ParseForm("a=%-1").has_value());
}

}  // namespace
}  // namespace mle::serve
