#include "apps/serve/access.h"

#include <cstdlib>
#include <filesystem>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::serve {
namespace {

using ::testing::HasSubstr;

const Access kAccess = {.host_names = {"watch.plant.example"},
                        .token = "0123456789abcdef"};

TEST(AccessTest, HostsAreAddressesOrKnownNames) {
  for (const char* host :
       {"localhost", "LOCALHOST:1", "127.0.0.1:8080", "10.1.2.3", "[::1]",
        "[fe80::1]:80", "Watch.plant.example", "watch.plant.example:443"}) {
    EXPECT_TRUE(IsHostAllowed(kAccess, host)) << host;
  }
  for (const char* host :
       {"", "attacker.example", "127.0.0.1.attacker.example", "localhost.x",
        "127.0.0.1:80:80", "127.0.0.1:x", "[::1", "::1", "[::1]x",
        "watch.plant.example.attacker.example", "0x7f.1", "2130706433"}) {
    EXPECT_FALSE(IsHostAllowed(kAccess, host)) << host;
  }
}

TEST(AccessTest, OtherSitesAreToldByOriginAndFetchSite) {
  Request request{.host = "127.0.0.1:8080"};
  EXPECT_EQ(CrossSiteFault(kAccess, request), "");
  for (const char* origin :
       {"http://127.0.0.1:8080", "https://watch.plant.example"}) {
    request.origin = origin;
    EXPECT_EQ(CrossSiteFault(kAccess, request), "") << origin;
  }
  for (const char* origin :
       {"null", "http://127.0.0.1:9090", "https://attacker.example",
        "file://127.0.0.1:8080", "http://127.0.0.1:8080.attacker.example",
        "http://localhost:8080"}) {
    request.origin = origin;
    EXPECT_NE(CrossSiteFault(kAccess, request), "") << origin;
  }
  request.origin = "";
  request.fetch_site = "cross-site";
  EXPECT_NE(CrossSiteFault(kAccess, request), "");
  request.fetch_site = "same-site";
  EXPECT_NE(CrossSiteFault(kAccess, request), "");
  request.fetch_site = "same-origin";
  EXPECT_EQ(CrossSiteFault(kAccess, request), "");
}

TEST(AccessTest, OnlyTheTokenIsTheToken) {
  EXPECT_TRUE(IsRightToken(kAccess, "0123456789abcdef"));
  EXPECT_FALSE(IsRightToken(kAccess, "0123456789abcdeg"));
  EXPECT_FALSE(IsRightToken(kAccess, "0123456789abcde"));
  EXPECT_FALSE(IsRightToken(kAccess, ""));
  // Without a token none is right.
  EXPECT_FALSE(IsRightToken({}, ""));
}

TEST(AccessTest, BearerTokensStandBehindTheirScheme) {
  EXPECT_EQ(BearerToken({.authorization = "bearer  abc "}), "abc");
  EXPECT_EQ(BearerToken({.authorization = "Basic abc"}), "");
  EXPECT_EQ(BearerToken({}), "");
}

class ReadTokenTest : public ::testing::Test {
 protected:
  ReadTokenTest() : path_(folder_.Write("token", "0123456789abcdef\n")) {
    std::filesystem::permissions(path_, std::filesystem::perms::owner_read);
    setenv(kVariable, "from-the-environment", 1);
  }
  ~ReadTokenTest() override { unsetenv(kVariable); }
  static constexpr char kVariable[] = "MLE_TESTED_TOKEN";
  const ScratchFolder folder_;
  const std::string path_;
};

TEST_F(ReadTokenTest, TheFileGoesBeforeTheEnvironment) {
  EXPECT_EQ(ReadToken(path_, kVariable).value(), "0123456789abcdef");
  EXPECT_EQ(ReadToken("", kVariable).value(), "from-the-environment");
  unsetenv(kVariable);
  EXPECT_EQ(ReadToken("", kVariable).value(), "");
}

TEST_F(ReadTokenTest, WeakTokensAreRefused) {
  setenv(kVariable, "short", 1);
  const absl::Status status = ReadToken("", kVariable).status();
  EXPECT_THAT(std::string(status.message()), HasSubstr(kVariable));
  EXPECT_THAT(std::string(status.message()),
              ::testing::Not(HasSubstr("short")));
  EXPECT_FALSE(ReadToken(path_ + ".none", kVariable).ok());
  std::filesystem::permissions(path_, std::filesystem::perms::others_read,
                               std::filesystem::perm_options::add);
  EXPECT_THAT(std::string(ReadToken(path_, kVariable).status().message()),
              HasSubstr("others may read"));
}

}  // namespace
}  // namespace mle::serve
