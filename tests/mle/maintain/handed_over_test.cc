// Forms in which the corrected model is handed over.

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/maintain/corrected_model.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ProcessModel ModelOf(const std::vector<TransferFunction>& elements) {
  std::vector<OutputChannel> outputs;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    outputs.push_back({std::string("y").append(std::to_string(i)), ""});
  }
  ProcessModel model("test", "min", {{"u", ""}}, outputs);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    model.element(static_cast<int>(i), 0) = elements[i];
  }
  return model;
}

CorrectedModel Corrected(const ProcessModel& model, bool by_process) {
  CorrectedModel corrected;
  if (by_process) corrected.process = model;
  corrected.response = model.ComputeStepResponse(0.5, 400);
  return corrected;
}

std::vector<FopdtElement> Describe(const ProcessModel& model, bool by_process) {
  Estimate estimate;
  estimate.setting.initial = model;
  const auto elements =
      DescribeAsFopdt(estimate, false, Corrected(model, by_process));
  EXPECT_TRUE(elements.ok()) << elements.status();
  return *elements;
}

TEST(HandedOverTest, SecondOrderIsGivenWhereFirstOrderIsNotNear) {
  const TransferFunction oscillation({3.0}, {25.0, 3.0, 1.0}, 2.0);
  const TransferFunction lags({-2.0}, {36.0, 12.0, 1.0}, 1.0);
  const TransferFunction nearly({1.0}, {2.0, 21.0, 1.0}, 4.0);
  const TransferFunction first = TransferFunction::FirstOrder(2.0, 9.0, 1.0);
  // An inverse response, which second order describes no better.
  const TransferFunction inverse({-9.0, 1.0}, {30.0, 11.0, 1.0}, 0.0);
  const ProcessModel model =
      ModelOf({oscillation, lags, nearly, first, TransferFunction(), inverse});
  for (const bool by_process : {true, false}) {
    SCOPED_TRACE(by_process);
    const std::vector<FopdtElement> elements = Describe(model, by_process);
    ASSERT_EQ(elements.size(), 6u);
    ASSERT_TRUE(elements[0].second_order.has_value());
    EXPECT_GT(elements[0].largest_difference, kNearFopdt);
    EXPECT_NEAR(elements[0].second_order->gain, 3.0, 1e-3);
    EXPECT_NEAR(elements[0].second_order->time_constant, 5.0, 1e-2);
    EXPECT_NEAR(elements[0].second_order->damping, 0.3, 1e-3);
    EXPECT_NEAR(elements[0].second_order->delay, 2.0, 0.02);
    EXPECT_LT(elements[0].second_order->largest_difference, 1e-3);
    ASSERT_TRUE(elements[1].second_order.has_value());
    EXPECT_NEAR(elements[1].second_order->damping, 1.0, 1e-2);
    EXPECT_FALSE(elements[2].second_order.has_value());
    EXPECT_LT(elements[2].largest_difference, kNearFopdt);
    EXPECT_FALSE(elements[3].second_order.has_value());
    EXPECT_LT(elements[3].largest_difference, 1e-6);
    EXPECT_FALSE(elements[4].second_order.has_value());
    EXPECT_EQ(elements[4].shape, FopdtShape::kNoResponse);
    EXPECT_GT(elements[5].largest_difference, kNearFopdt);
    EXPECT_FALSE(elements[5].second_order.has_value());
  }
}

TEST(HandedOverTest, AStateSpaceModelIsHeldToTheCorrectedModel) {
  const ProcessModel model =
      ModelOf({TransferFunction({3.0}, {25.0, 3.0, 1.0}, 2.0),
               TransferFunction::FirstOrder(2.0, 9.0, 1.0)});
  for (const bool by_process : {true, false}) {
    const StateSpaceForm form =
        MakeStateSpaceForm(model, Corrected(model, by_process));
    ASSERT_TRUE(form.model.has_value()) << form.reason;
    EXPECT_TRUE(form.model->Validate().ok()) << form.model->Validate();
    EXPECT_EQ(form.model->inputs, std::vector<std::string>{"u"});
    EXPECT_LE(form.error_bound(), 0.01);
    EXPECT_LE(form.largest_difference(), 0.01);
  }
  // An ARX model that the transfer functions are not near.
  CorrectedModel arx = Corrected(model, false);
  arx.response.values.col(1) *= 1.05;
  const StateSpaceForm form = MakeStateSpaceForm(model, arx);
  EXPECT_FALSE(form.model.has_value());
  EXPECT_THAT(form.reason, HasSubstr("differ from the ARX model by 4.8 %"));
}

// What is typed into a controller must have the gain, though first order is far
// from such a shape.
TEST(HandedOverTest, ManyEqualLagsKeepTheirGain) {
  const TransferFunction four({2.8}, {1e4, 4e3, 600.0, 40.0, 1.0}, 1.0);
  const FopdtElement element = Describe(ModelOf({four}), true)[0];
  EXPECT_NEAR(element.gain, 2.8, 0.07);
  EXPECT_GT(element.largest_difference, kNearFopdt);
}

}  // namespace
}  // namespace mle
