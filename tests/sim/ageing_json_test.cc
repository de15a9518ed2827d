#include "sim/ageing_json.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using ::mle::testing::MixedModel;
using ::testing::AllOf;
using ::testing::HasSubstr;

absl::StatusOr<AgeingSchedule> ParseAgeingOf(const std::string& json) {
  return ParseAgeingSchedule(json, "age.json", MixedModel());
}

TEST(AgeingJsonTest, ReadsSchedulesInTheirOwnUnitOfTime) {
  const absl::StatusOr<AgeingSchedule> ageing = ParseAgeingOf(R"({
    "time_factor": 100,
    "elements": [
      {"output": "y2", "input": "u1", "gain": [[0, 1.0], [10, 0.5]]},
      {"output": "y1", "input": "u2", "time_constant": 1.5, "falling": 2,
       "delay": [[2, 0], [2, 4]]}
    ]})");
  ASSERT_TRUE(ageing.ok()) << ageing.status();
  ASSERT_EQ(ageing->elements.size(), 2u);
  const ElementAgeing& first = ageing->elements[0];
  EXPECT_EQ(first.output, 1);
  EXPECT_EQ(first.input, 0);
  EXPECT_EQ(first.gain.At(500.0), 0.75);
  EXPECT_EQ(first.time_constant.At(500.0), 1.0);
  const ElementAgeing& second = ageing->elements[1];
  EXPECT_EQ(second.time_constant.At(0.0), 1.5);
  EXPECT_EQ(second.falling, 2.0);
  EXPECT_EQ(second.delay.At(199.0), 0.0);
  EXPECT_EQ(second.delay.At(200.0), 4.0);
}

TEST(AgeingJsonTest, MistakesAreNamed) {
  const auto message = [](const std::string& json) {
    const absl::Status status = ParseAgeingOf(json).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  const auto element = [&](const std::string& rest) {
    return message(R"({"elements": [{"output": "y1", "input": "u1", )" + rest +
                   "}]}");
  };
  EXPECT_THAT(message("{"), HasSubstr("age.json: line 1"));
  EXPECT_THAT(message("{}"),
              HasSubstr("age.json: key \"elements\" is missing"));
  EXPECT_THAT(message(R"({"elements": 1})"), HasSubstr("elements: must be"));
  EXPECT_THAT(message(R"({"elements": [], "time_factor": 0})"),
              HasSubstr("time_factor: must be a number > 0"));
  EXPECT_THAT(message(R"({"elements": [{"output": "y9", "input": "u1"}]})"),
              HasSubstr("elements[0]: the model has no output \"y9\""));
  EXPECT_THAT(message(R"({"elements": [{"output": "y1", "input": 3}]})"),
              HasSubstr("elements[0].input: must be a string"));
  EXPECT_THAT(element(R"("gian": 2)"),
              HasSubstr("elements[0]: unknown key \"gian\"; allowed are"));
  EXPECT_THAT(element(R"("gain": "2")"),
              HasSubstr("elements[0].gain: must be a number, or a list"));
  EXPECT_THAT(element(R"("gain": [[1, 2, 3]])"), HasSubstr("[time, value]"));
  EXPECT_THAT(element(R"("gain": [[1, 2], [0, 2]])"),
              HasSubstr("elements[0].gain: point 2 is at time 0"));
  EXPECT_THAT(element(R"("time_constant": -1)"),
              HasSubstr("element (y1, u1): time_constant falls to -1"));
  EXPECT_THAT(element(R"("time_constant": 1.7e308)"),
              AllOf(HasSubstr("element (y1, u1): with gain 1, time_constant "
                              "1.7e+308 and delay 0: "),
                    HasSubstr("not finite")));
  EXPECT_THAT(element(R"("gain": [[0, -1e308], [1, 1e308]])"),
              HasSubstr("elements[0].gain: between points 1 and 2"));
  EXPECT_THAT(element(R"("gain": [[0, 1], [5e-324, 2]])"),
              HasSubstr("slope is not finite; a step is two points"));
}

}  // namespace
}  // namespace mle::sim
