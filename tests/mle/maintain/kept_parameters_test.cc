#include "mle/maintain/kept_parameters.h"

#include <cmath>

#include "Eigen/Core"
#include "Eigen/LU"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"

namespace mle {
namespace {

ParameterEstimate Estimated(double initial, double value, double error) {
  return {.initial = initial,
          .value = value,
          .standard_error = error,
          .lower = value - 2.0 * error,
          .upper = value + 2.0 * error};
}

// A gain that changed, and times that did not, with the covariance of a fit.
OutputErrorFit ChangedGain() {
  OutputErrorFit fit;
  fit.model = ProcessModel("m", "min", {{"u", "%"}}, {{"y", "K"}});
  fit.model.element(0, 0) = TransferFunction::FirstOrder(1.4, 11.0, 1.5);
  fit.elements.resize(1);
  fit.elements[0].state = ElementState::kFitted;
  fit.elements[0].gain = Estimated(2.0, 1.4, 0.05);
  fit.elements[0].time_scale = Estimated(10.0, 11.0, 0.8);
  fit.elements[0].delay = Estimated(2.0, 1.5, 0.4);
  Eigen::Matrix3d C;
  C << 0.0025, 0.032, -0.004, 0.032, 0.64, -0.16, -0.004, -0.16, 0.16;
  fit.covariances = {C};
  return fit;
}

// The minimum of (θ − θ̂)ᵀ C⁻¹ (θ − θ̂) where T and L are the model's.
TEST(KeepUnchangedParametersTest, TheOthersTakeTheirConditionalValues) {
  OutputErrorFit fit = ChangedGain();
  const Eigen::Matrix3d precision =
      Eigen::Matrix3d(fit.covariances[0]).inverse();
  KeepUnchangedParameters(fit);
  const ElementEstimate& element = fit.elements[0];
  EXPECT_EQ(element.time_scale.value, 10.0);
  EXPECT_EQ(element.delay.value, 2.0);
  const Eigen::Vector3d change(element.gain.value - 1.4, -1.0, 0.5);
  EXPECT_NEAR((precision * change)[0], 0.0, 1e-9);
  EXPECT_NEAR(element.gain.upper - element.gain.lower, 0.2, 1e-12);
  EXPECT_NEAR(element.gain.upper - element.gain.value, 0.1, 1e-12);
  EXPECT_NEAR(element.time_scale.upper, 12.6, 1e-12);
  EXPECT_NEAR(fit.model.element(0, 0).StaticGain(), element.gain.value, 1e-12);
  EXPECT_EQ(fit.model.element(0, 0).delay(), 2.0);
}

TEST(KeepUnchangedParametersTest, WhereNothingChangedTheElementIsLeft) {
  OutputErrorFit fit = ChangedGain();
  fit.elements[0].gain.upper = 2.1;
  KeepUnchangedParameters(fit);
  EXPECT_EQ(fit.elements[0].gain.value, 1.4);
  EXPECT_EQ(fit.elements[0].delay.value, 1.5);
}

// The dead time changed and would be negative with the gain of the model.
TEST(KeepUnchangedParametersTest, NoTimeBecomesNegative) {
  OutputErrorFit fit = ChangedGain();
  fit.elements[0].gain = Estimated(1.5, 1.4, 0.05);
  fit.elements[0].delay = Estimated(2.0, 0.1, 0.4);
  fit.covariances[0](0, 2) = fit.covariances[0](2, 0) = -0.019;
  KeepUnchangedParameters(fit);
  EXPECT_EQ(fit.elements[0].delay.value, 0.1);
  EXPECT_EQ(fit.elements[0].gain.value, 1.4);
  EXPECT_EQ(fit.elements[0].time_scale.value, 11.0);
}

}  // namespace
}  // namespace mle
