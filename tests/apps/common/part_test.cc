#include "apps/common/part.h"

#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::Le;

TEST(PartTest, EachControllerIsInOnePart) {
  constexpr int kParts = 16;
  std::vector<int> sizes(kParts, 0);
  for (int c = 0; c < 1000; ++c) {
    int found = 0;
    for (int number = 1; number <= kParts; ++number) {
      const auto part = ParsePart(absl::StrCat(number, "/", kParts));
      ASSERT_TRUE(part.ok()) << part.status();
      EXPECT_EQ(part->Has(std::int64_t{c}), c % kParts == number - 1);
      if (!part->Has(absl::StrCat("controller ", c))) continue;
      ++found;
      ++sizes[number - 1];
    }
    EXPECT_EQ(found, 1);
  }
  // 62 on the average, with a standard deviation of 8.
  EXPECT_THAT(sizes, Each(AllOf(Ge(30), Le(95))));
}

TEST(PartTest, StaysTheSame) {
  // By sha256sum: 881d5fb60090 is 149659741192336 = 4 modulo 7.
  EXPECT_TRUE(ParsePart("5/7")->Has("column"));
}

TEST(PartTest, TextsAreReadOrRefused) {
  EXPECT_TRUE(ParsePart("")->is_everything());
  EXPECT_TRUE(ParsePart("")->Has("any"));
  EXPECT_TRUE(ParsePart("")->Has(std::int64_t{17}));
  EXPECT_EQ(ParsePart("")->FolderBelow("out"), "out");
  EXPECT_EQ(ParsePart("3/16")->FolderBelow("out"), "out/parts/3-of-16");
  for (const char* const wrong :
       {"3", "0/4", "5/4", "a/4", "1/0", "1/2/3", "-1/4", "1/1000000"}) {
    EXPECT_THAT(std::string(ParsePart(wrong).status().message()),
                HasSubstr("such as 3/16"))
        << wrong;
  }
}

}  // namespace
}  // namespace mle
