#include "mle/model/process_model.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ProcessModel Example() {
  ProcessModel model("example", "min",
                     {{"flow", "kg/h"},
                      {"feed", "t/h", InputRole::kDisturbance},
                      {"steam", "kg/h"}},
                     {{"level", "%"}, {"quality", "wt%"}});
  model.element(0, 1) = TransferFunction::FirstOrder(2.0, 5.0, 1.0);
  model.element(1, 2) = TransferFunction({-1.0, 4.0}, {2.0, 3.0, 1.0}, 0.25);
  return model;
}

TEST(ProcessModelTest, ElementsAreZeroUntilSet) {
  const ProcessModel model = Example();
  EXPECT_TRUE(model.Validate().ok());
  EXPECT_EQ(model.num_inputs(), 3);
  EXPECT_EQ(model.num_outputs(), 2);
  int zeros = 0;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) zeros += model.element(i, j).IsZero();
  }
  EXPECT_EQ(zeros, 4);
  EXPECT_EQ(model.element(1, 2).StaticGain(), 4.0);
}

TEST(ProcessModelTest, StepResponseIsThatOfTheElements) {
  const ProcessModel model = Example();
  const StepResponse response = model.ComputeStepResponse(0.2, 77);
  EXPECT_EQ(response.sample_time, 0.2);
  EXPECT_EQ(response.samples(), 77);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      EXPECT_EQ(response.element(i, j),
                model.element(i, j).StepResponse(0.2, 77));
    }
  }
}

TEST(ProcessModelTest, ValidateSaysWhatIsWrong) {
  const auto message = [](const ProcessModel& model) {
    return std::string(model.Validate().message());
  };
  EXPECT_THAT(message(ProcessModel()), HasSubstr("inputs is empty"));
  EXPECT_THAT(message(ProcessModel("", "", {{"u", ""}}, {})),
              HasSubstr("outputs is empty"));
  EXPECT_THAT(message(ProcessModel("", "", {{"u", ""}}, {{"", ""}})),
              HasSubstr("outputs[0]: name is empty"));
  EXPECT_THAT(message(ProcessModel("", "", {{"u", ""}}, {{"u", ""}})),
              HasSubstr("outputs[0]: name \"u\" is used already"));
  const std::string nul("a\0b", 3);
  EXPECT_THAT(message(ProcessModel(nul, "", {{"u", ""}}, {{"y", ""}})),
              HasSubstr("name has a NUL character"));
  EXPECT_THAT(message(ProcessModel("", nul, {{"u", ""}}, {{"y", ""}})),
              HasSubstr("time_unit has a NUL character"));
  EXPECT_THAT(message(ProcessModel("", "", {{nul, ""}}, {{"y", ""}})),
              HasSubstr("inputs[0]: name has a NUL character"));
  EXPECT_THAT(message(ProcessModel("", "", {{"u", ""}}, {{"y", nul}})),
              HasSubstr("outputs[0]: unit has a NUL character"));
  ProcessModel model = Example();
  model.element(1, 0) = TransferFunction::FirstOrder(1.0, -3.0, 0.0);
  EXPECT_THAT(message(model),
              HasSubstr("output \"quality\", input \"flow\": denominator"));
}

TEST(CheckSameChannelsTest, DifferencesAreNamed) {
  const ProcessModel a = Example();
  const auto message = [&a](const ProcessModel& b) {
    return std::string(CheckSameChannels(a, "M", b, "G").message());
  };
  EXPECT_TRUE(CheckSameChannels(a, "M", a, "G").ok());
  EXPECT_THAT(message(ProcessModel("", "min", a.inputs(), {{"level", "%"}})),
              HasSubstr("M has 2 outputs, G 1"));
  EXPECT_THAT(message(ProcessModel("", "min", a.inputs(),
                                   {a.outputs()[1], a.outputs()[0]})),
              HasSubstr("outputs[0] is \"level\" in M and \"quality\" in G"));
  EXPECT_THAT(message(ProcessModel("", "s", a.inputs(), a.outputs())),
              HasSubstr("time_unit is \"min\" in M and \"s\" in G"));
  // The name and the elements may differ.
  EXPECT_TRUE(
      CheckSameChannels(a, "M",
                        ProcessModel("b", "min", a.inputs(), a.outputs()), "G")
          .ok());
}

}  // namespace
}  // namespace mle
