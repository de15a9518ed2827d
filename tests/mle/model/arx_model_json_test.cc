#include "mle/model/arx_model_json.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kValid[] = R"({
  "version": 1, "name": "tank", "time_unit": "min",
  "sample_time": 0.5, "order": 2,
  "outputs": ["level"], "inputs": ["inflow"],
  "R": [[0.9, 0.1, -0.2, 0.05]]
})";

std::string MessageWith(const std::string& from, const std::string& to) {
  const std::string text = absl::StrReplaceAll(kValid, {{from, to}});
  EXPECT_NE(text, kValid) << from;
  const auto named = ParseArxModel(text, "a.json");
  EXPECT_FALSE(named.ok()) << text;
  return std::string(named.status().message());
}

TEST(ArxModelJsonTest, ReadsEveryKey) {
  const auto named = ParseArxModel(kValid, "a.json");
  ASSERT_TRUE(named.ok()) << named.status();
  EXPECT_EQ(named->name, "tank");
  EXPECT_EQ(named->time_unit, "min");
  EXPECT_EQ(named->outputs, std::vector<std::string>{"level"});
  EXPECT_EQ(named->inputs, std::vector<std::string>{"inflow"});
  EXPECT_EQ(named->model.sample_time, 0.5);
  EXPECT_EQ(named->model.order, 2);
  EXPECT_EQ(named->model.R, Eigen::RowVector4d(0.9, 0.1, -0.2, 0.05));
}

TEST(ArxModelJsonTest, ReadsBackWhatItWritesBitByBit) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  NamedArxModel named = {"a \"b\"\n", "µs", {"y1", "y2"}, {"u"}, {}};
  named.model = {0.1, 7, 2, 1, Eigen::MatrixXd(2, 21)};
  for (double& value : named.model.R.reshaped()) {
    value = std::ldexp(normal(random), static_cast<int>(random() % 600) - 300);
  }
  named.model.R(0, 0) = -0.0;
  named.model.R(1, 1) = std::numeric_limits<double>::denorm_min();
  const auto again = ParseArxModel(FormatArxModel(named), "b");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->model.R, named.model.R);
  EXPECT_EQ(again->model.sample_time, named.model.sample_time);
  EXPECT_EQ(again->name, named.name);
  EXPECT_EQ(again->outputs, named.outputs);
}

TEST(ArxModelJsonTest, FaultsNameTheKeyAndWhatWouldBeRight) {
  EXPECT_THAT(MessageWith("\"order\": 2", "\"order\": 3"),
              AllOf(StartsWith("a.json: R[0]: must be a list of 6 numbers"),
                    HasSubstr("is one of 4")));
  EXPECT_THAT(MessageWith("\"order\": 2", "\"order\": 2.5"),
              HasSubstr("order: must be a whole number from 1 to 1000000, is "
                        "the number 2.5"));
  EXPECT_THAT(MessageWith("\"order\": 2", "\"order\": 1e300"),
              HasSubstr("order: must be a whole number"));
  EXPECT_THAT(MessageWith("\"order\": 2", "\"order\": 700000"),
              HasSubstr("more than 1000000 regressors"));
  EXPECT_THAT(MessageWith("\"version\": 1", "\"version\": 2"),
              HasSubstr("version: must be a whole number from 1 to 1"));
  EXPECT_THAT(MessageWith("\"order\": 2", "\"Order\": 2"),
              HasSubstr("unknown key \"Order\"; allowed are version"));
  EXPECT_THAT(MessageWith("\"order\": 2,", ""),
              HasSubstr("key \"order\" is missing"));
  EXPECT_THAT(MessageWith("0.5", "-0.5"), HasSubstr("must be positive"));
  EXPECT_THAT(MessageWith("0.05", "\"x\""),
              HasSubstr("R[0][3]: must be a number, is the string \"x\""));
  EXPECT_THAT(MessageWith("[[", "[[1,2,3,4],["),
              HasSubstr("R: must be a list of 1 rows"));
  EXPECT_THAT(MessageWith("[\"level\"]", "[]"),
              HasSubstr("outputs: is an empty list"));
  EXPECT_THAT(MessageWith("[\"level\"]", "[3]"),
              HasSubstr("outputs[0]: must be a string, is the number 3"));
  EXPECT_THAT(MessageWith("\"inflow\"", "\"level\""),
              HasSubstr("the name \"level\" is duplicated"));
  EXPECT_THAT(MessageWith("\"inflow\"", "\"\""),
              HasSubstr("an input has an empty name"));
  EXPECT_THAT(MessageWith("[\"level\"]", "\"level\""),
              HasSubstr("outputs: must be a list, is the string"));
}

TEST(ArxModelJsonTest, NamesAFileThatIsNotThere) {
  EXPECT_THAT(std::string(ReadArxModel("/no/arx.json").status().message()),
              HasSubstr("/no/arx.json"));
}

}  // namespace
}  // namespace mle
