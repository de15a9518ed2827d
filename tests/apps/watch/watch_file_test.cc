#include "apps/watch/watch_file.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string ErrorOf(const std::string& json) {
  return std::string(ParseWatchFile(json, "site/c.json").status().message());
}

TEST(WatchFileTest, PathsAreTakenFromTheFilesFolder) {
  const auto controllers = ParseWatchFile(
      R"({"version": 1, "controllers": [
          {"name": "C 1", "model": "m.json", "records": "/data/c1",
           "tag_file": "../tags.csv", "reference_days": 20, "level": 0.01},
          {"name": "C 2", "model": "m.json", "records": "c2"}]})",
      "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  ASSERT_EQ(controllers->size(), 2U);
  const Controller& first = controllers->front();
  EXPECT_EQ(first.name, "C 1");
  EXPECT_EQ(first.model, "site/m.json");
  EXPECT_EQ(first.records, "/data/c1");
  EXPECT_EQ(first.tag_file, "tags.csv");
  EXPECT_EQ(first.reference_days, 20);
  EXPECT_EQ(first.options.level, 0.01);
  EXPECT_EQ(controllers->back().reference_days, 14);
}

TEST(WatchFileTest, ErrorsNameThePlaceAndWhatIsRight) {
  EXPECT_THAT(ErrorOf("{"), HasSubstr("site/c.json"));
  EXPECT_THAT(ErrorOf(R"({"version": 2, "controllers": []})"),
              HasSubstr("version"));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": []})"),
              HasSubstr("controllers"));
  EXPECT_THAT(
      ErrorOf(
          R"({"version": 1, "controllers": [{"name": "a", "model": "m"}]})"),
      HasSubstr("records"));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r", "colour": 1}]})"),
              HasSubstr("colour"));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r", "level": 1.5}]})"),
              AllOf(HasSubstr("level = 1.5"), HasSubstr("(0, 1)")));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r"},
      {"name": "a", "model": "n", "records": "s"}]})"),
              HasSubstr("twice"));
  // Names go into pages and file names.
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "../../etc", "model": "m", "records": "r"}]})"),
              HasSubstr("name"));
}

}  // namespace
}  // namespace mle::watch
