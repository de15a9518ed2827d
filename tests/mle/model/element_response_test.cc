#include "mle/model/element_response.h"

#include <cmath>
#include <random>
#include <vector>

#include "Eigen/QR"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"
#include "mle/model/transfer_function.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kSampleTime = 0.2;
constexpr int kSamples = 120;

ElementResponse Make(const TransferFunction& element) {
  auto response = ElementResponse::Create(element);
  EXPECT_TRUE(response.ok()) << response.status();
  return *std::move(response);
}

VectorXd RandomInputs(unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  VectorXd inputs(kSamples);
  for (double& u : inputs) u = normal(engine);
  return inputs;
}

SampledDelay Split(double delay) {
  const double samples = delay / kSampleTime;
  const int whole = static_cast<int>(samples);
  return {whole, samples - whole};
}

MatrixXd Simulate(const ElementResponse& element, double time_scale,
                  double delay, const VectorXd& inputs, double past = 0.0) {
  MatrixXd columns(inputs.size(), 3);
  element.Simulate(time_scale, kSampleTime, Split(delay), inputs, past,
                   columns);
  return columns;
}

const std::vector<TransferFunction>& Elements() {
  static const std::vector<TransferFunction> elements = {
      TransferFunction::FirstOrder(-18.9, 21.0, 3.07),
      TransferFunction::FirstOrder(2.0, 0.05, 0.0),
      TransferFunction({2.0}, {48.0, 16.0, 1.0}, 1.13),
      TransferFunction({-6.0, 3.0}, {6.0, 5.0, 1.0}, 0.4),
      TransferFunction({1.0}, {4.0, 0.8, 1.0}, 2.5),
      TransferFunction::Integrator(-0.4, 0.0, 0.7),
      TransferFunction::Integrator(0.6, 3.0, 1.13),
      TransferFunction({4.0, 6.0}, {5.0, 7.0, 2.0, 0.0}, 0.4)};
  return elements;
}

TEST(ElementResponseTest, StepResponseIsThatOfTheTransferFunction) {
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const ElementValues& values = response.initial_values();
    const VectorXd step =
        values.gain * Simulate(response, values.time_scale, values.delay,
                               VectorXd::Ones(kSamples))
                          .col(0);
    // Two exact computations, a hundred steps of rounding apart.
    EXPECT_LT((step - element.StepResponse(kSampleTime, kSamples))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10 * std::abs(values.gain));
  }
}

TEST(ElementResponseTest, AnyInputIsASumOfSteps) {
  const VectorXd inputs = RandomInputs(1);
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const ElementValues& values = response.initial_values();
    const VectorXd step = element.StepResponse(kSampleTime, kSamples);
    const double past = 0.7;
    VectorXd expected = VectorXd::Constant(
        kSamples, element.IsIntegrating() ? 0.0 : element.StaticGain() * past);
    for (int k = 0; k < kSamples; ++k) {
      const double move = inputs(k) - (k == 0 ? past : inputs(k - 1));
      expected.tail(kSamples - k) += move * step.head(kSamples - k);
    }
    const VectorXd y = values.gain * Simulate(response, values.time_scale,
                                              values.delay, inputs, past)
                                         .col(0);
    EXPECT_LT((y - expected).cwiseAbs().maxCoeff(),
              1e-9 * std::abs(values.gain));
  }
}

TEST(ElementResponseTest, IsTheResponseOfTheProcessModel) {
  const VectorXd inputs = RandomInputs(5);
  for (const TransferFunction& element : Elements()) {
    ProcessModel model("one", "min", {{"u", ""}}, {{"y", ""}});
    model.element(0, 0) = element;
    const absl::StatusOr<MatrixXd> expected =
        SimulateResponse(model, kSampleTime, inputs.transpose());
    ASSERT_TRUE(expected.ok()) << expected.status();
    const ElementResponse response = Make(element);
    const ElementValues& values = response.initial_values();
    const VectorXd y = values.gain * Simulate(response, values.time_scale,
                                              values.delay, inputs, inputs(0))
                                         .col(0);
    EXPECT_LT((y - expected->row(0).transpose()).cwiseAbs().maxCoeff(),
              1e-11 * std::abs(values.gain));
  }
}

TEST(ElementResponseTest, DerivativesAreThoseOfDifferences) {
  const VectorXd inputs = RandomInputs(2);
  const double h = 1e-5;
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const double T = response.initial_values().time_scale;
    // Inside a sample, where the response is smooth in L.
    const double L = 1.13;
    const MatrixXd columns = Simulate(response, T, L, inputs, 0.3);
    const VectorXd by_log =
        (Simulate(response, T * std::exp(h), L, inputs, 0.3).col(0) -
         Simulate(response, T * std::exp(-h), L, inputs, 0.3).col(0)) /
        (2.0 * h);
    const VectorXd by_delay =
        (Simulate(response, T, L + h, inputs, 0.3).col(0) -
         Simulate(response, T, L - h, inputs, 0.3).col(0)) /
        (2.0 * h);
    // Differences err by h² times third derivatives, (h/T)² of the slope: a
    // part in 10⁷ for the fastest element; rounding by 1e-16/h.
    const double slope = 1.0 + columns.col(2).cwiseAbs().maxCoeff();
    EXPECT_LT((columns.col(1) - by_log).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((columns.col(2) - by_delay).cwiseAbs().maxCoeff(), 1e-6 * slope);
  }
}

TEST(ElementResponseTest, AtAKinkEachSampleHasItsOwnDerivative) {
  const VectorXd inputs = RandomInputs(3);
  const ElementResponse response =
      Make(TransferFunction::FirstOrder(1.0, 5.0, 0.0));
  MatrixXd before(kSamples, 3);
  MatrixXd after(kSamples, 3);
  response.Simulate(5.0, kSampleTime, {6, 1.0}, inputs, 0.0, before);
  response.Simulate(5.0, kSampleTime, {7, 0.0}, inputs, 0.0, after);
  EXPECT_LT((before.leftCols(2) - after.leftCols(2)).cwiseAbs().maxCoeff(),
            1e-13);
  const double h = 1e-6;
  const double L = 7 * kSampleTime;
  const VectorXd y = before.col(0);
  const VectorXd from_left =
      (y - Simulate(response, 5.0, L - h, inputs).col(0)) / h;
  const VectorXd from_right =
      (Simulate(response, 5.0, L + h, inputs).col(0) - y) / h;
  // One-sided differences err by h/2 times the curvature, here below 1/T².
  EXPECT_LT((before.col(2) - from_left).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((after.col(2) - from_right).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT((before.col(2) - after.col(2)).cwiseAbs().maxCoeff(), 0.1);
}

TEST(ElementResponseTest, FreeResponsesMakeUpForForgottenInputs) {
  const VectorXd inputs = RandomInputs(4);
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const ElementValues& v = response.initial_values();
    const int begin = 40;
    const int count = kSamples - begin;
    const VectorXd whole =
        Simulate(response, v.time_scale, v.delay, inputs).col(0).tail(count);
    const VectorXd part =
        Simulate(response, v.time_scale, v.delay, inputs.tail(count), 0.0)
            .col(0);
    // Once the dead time has passed, what is missing is a free response.
    const int skip = static_cast<int>(v.delay / kSampleTime) + 1;
    MatrixXd modes(count - skip, response.order());
    MatrixXd derivatives = modes;
    response.FreeResponses(v.time_scale, kSampleTime, modes, derivatives);
    VectorXd missing = (whole - part).tail(count - skip);
    if (response.is_integrating()) {
      // A level, and the ramp of what was a balance before.
      modes.conservativeResize(Eigen::NoChange, response.order() + 2);
      modes.rightCols<2>() << VectorXd::Ones(count - skip),
          VectorXd::LinSpaced(count - skip, 0.0, 1.0);
    }
    const VectorXd amplitudes = modes.colPivHouseholderQr().solve(missing);
    EXPECT_LT((modes * amplitudes - missing).norm(), 1e-9);

    if (response.order() == 0) continue;
    const double h = 1e-5;
    MatrixXd later = derivatives;
    MatrixXd sooner = derivatives;
    MatrixXd unused = derivatives;
    response.FreeResponses(v.time_scale * std::exp(h), kSampleTime, later,
                           unused);
    response.FreeResponses(v.time_scale * std::exp(-h), kSampleTime, sooner,
                           unused);
    EXPECT_LT(
        ((later - sooner) / (2.0 * h) - derivatives).cwiseAbs().maxCoeff(),
        1e-6);
  }
}

TEST(ElementResponseTest, KnowsItsShortestTime) {
  EXPECT_NEAR(Make(TransferFunction::FirstOrder(2.0, 5.0, 1.0)).shortest_time(),
              1.0, 1e-12);
  // (10 s + 1)(2 s + 1)
  EXPECT_NEAR(
      Make(TransferFunction({2.0}, {20.0, 12.0, 1.0}, 1.0)).shortest_time(),
      0.2, 1e-9);
  // Decays with 1/(ζω) = 50, at ω = 2.
  EXPECT_NEAR(
      Make(TransferFunction({2.0}, {0.25, 0.01, 1.0}, 1.0)).shortest_time(),
      0.5 / 50.0, 1e-9);
  EXPECT_EQ(Make(TransferFunction({0.3}, {1.0, 0.0}, 1.0)).shortest_time(),
            0.0);
}

// From the row that is returned on they are zero, and before they were small.
TEST(ElementResponseTest, FreeResponsesEnd) {
  const int samples = 20000;
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    if (response.order() == 0) continue;
    MatrixXd modes(samples, response.order());
    MatrixXd derivatives = modes;
    const Eigen::Index end = response.FreeResponses(
        response.initial_values().time_scale, kSampleTime, modes, derivatives);
    ASSERT_GT(end, 0);
    ASSERT_LT(end, samples);
    EXPECT_TRUE(modes.bottomRows(samples - end).isZero(0.0));
    EXPECT_TRUE(derivatives.bottomRows(samples - end).isZero(0.0));
    EXPECT_FALSE(modes.row(end - 1).isZero(0.0));
    EXPECT_LT(modes.row(end - 1).norm(), 1e-17 * modes.row(0).norm());
    // No more than what fits is asked for.
    MatrixXd few = modes.topRows(5);
    MatrixXd unused = few;
    EXPECT_EQ(response.FreeResponses(response.initial_values().time_scale,
                                     kSampleTime, few, unused),
              5);
  }
}

TEST(ElementResponseTest, ValuesMakeTheTransferFunction) {
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    ElementValues v = response.initial_values();
    v.gain *= -1.3;
    v.time_scale *= 1.7;
    v.delay += 0.31;
    const TransferFunction changed = response.ToTransferFunction(v);
    ASSERT_TRUE(changed.Validate().ok());
    EXPECT_NEAR(changed.StaticGain(), v.gain, 1e-12 * std::abs(v.gain));
    const VectorXd step = v.gain * Simulate(response, v.time_scale, v.delay,
                                            VectorXd::Ones(kSamples))
                                       .col(0);
    EXPECT_LT((step - changed.StepResponse(kSampleTime, kSamples))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9 * std::abs(v.gain));
  }
}

TEST(ElementResponseTest, SaysWhatItCannotFit) {
  const auto message = [](const TransferFunction& element) {
    return std::string(ElementResponse::Create(element).status().message());
  };
  EXPECT_THAT(message(TransferFunction()), HasSubstr("zero"));
  EXPECT_THAT(message(TransferFunction({2.0, 1.0}, {3.0, 1.0}, 0.0)),
              HasSubstr("feedthrough"));
  EXPECT_THAT(message(TransferFunction({1.0}, {1.0, 0.0, 0.0}, 0.0)),
              HasSubstr("pole"));
  EXPECT_THAT(message(TransferFunction({1.0, 2.0}, {1.0, 0.0}, 0.0)),
              HasSubstr("feedthrough"));
}

}  // namespace
}  // namespace mle
