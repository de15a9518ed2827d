#include "apps/watch/shard.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::Le;

TEST(ShardTest, EachControllerIsInOnePart) {
  constexpr int kParts = 16;
  std::vector<int> sizes(kParts, 0);
  for (int c = 0; c < 1000; ++c) {
    int found = 0;
    for (int part = 1; part <= kParts; ++part) {
      const auto shard = ParseShard(absl::StrCat(part, "/", kParts));
      ASSERT_TRUE(shard.ok()) << shard.status();
      if (!shard->Has(absl::StrCat("controller ", c))) continue;
      ++found;
      ++sizes[part - 1];
    }
    EXPECT_EQ(found, 1);
  }
  // 62 on the average, with a standard deviation of 8.
  EXPECT_THAT(sizes, Each(AllOf(Ge(30), Le(95))));
}

TEST(ShardTest, StaysTheSame) {
  // By sha256sum: 881d5fb60090 is 149659741192336 = 4 modulo 7.
  EXPECT_TRUE(ParseShard("5/7")->Has("column"));
}

TEST(ShardTest, TextsAreReadOrRefused) {
  EXPECT_TRUE(ParseShard("")->is_everything());
  EXPECT_TRUE(ParseShard("")->Has("any"));
  EXPECT_EQ(ParseShard("3/16")->Name(), "3-of-16");
  for (const char* const wrong :
       {"3", "0/4", "5/4", "a/4", "1/0", "1/2/3", "-1/4", "1/1000000"}) {
    EXPECT_THAT(std::string(ParseShard(wrong).status().message()),
                HasSubstr("such as 3/16"))
        << wrong;
  }
}

}  // namespace
}  // namespace mle::watch
