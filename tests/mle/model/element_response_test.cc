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

SampledDelay Split(double delay) { return SampledDelayOf(delay, kSampleTime); }

MatrixXd SimulateElement(const ElementResponse& element, double time_scale,
                         double delay, const VectorXd& inputs,
                         double past = 0.0) {
  MatrixXd columns(inputs.size(), 3);
  element.Simulate(time_scale, kSampleTime, Split(delay), inputs, past,
                   columns);
  return columns;
}

// All `samples` rows, those that are zero too.
void FreeResponses(const ElementResponse& element, double time_scale,
                   int samples, MatrixXd& columns, MatrixXd& derivatives) {
  element.FreeResponses(time_scale, kSampleTime, samples, columns, derivatives);
  for (MatrixXd* matrix : {&columns, &derivatives}) {
    const Eigen::Index zeros = samples - matrix->rows();
    matrix->conservativeResize(samples, Eigen::NoChange);
    matrix->bottomRows(zeros).setZero();
  }
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
        values.gain * SimulateElement(response, values.time_scale, values.delay,
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
    const VectorXd y =
        values.gain *
        SimulateElement(response, values.time_scale, values.delay, inputs, past)
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
    const VectorXd y =
        values.gain * SimulateElement(response, values.time_scale, values.delay,
                                      inputs, inputs(0))
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
    const MatrixXd columns = SimulateElement(response, T, L, inputs, 0.3);
    const VectorXd by_log =
        (SimulateElement(response, T * std::exp(h), L, inputs, 0.3).col(0) -
         SimulateElement(response, T * std::exp(-h), L, inputs, 0.3).col(0)) /
        (2.0 * h);
    const VectorXd by_delay =
        (SimulateElement(response, T, L + h, inputs, 0.3).col(0) -
         SimulateElement(response, T, L - h, inputs, 0.3).col(0)) /
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
      (y - SimulateElement(response, 5.0, L - h, inputs).col(0)) / h;
  const VectorXd from_right =
      (SimulateElement(response, 5.0, L + h, inputs).col(0) - y) / h;
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
        SimulateElement(response, v.time_scale, v.delay, inputs)
            .col(0)
            .tail(count);
    const VectorXd part = SimulateElement(response, v.time_scale, v.delay,
                                          inputs.tail(count), 0.0)
                              .col(0);
    // Once the dead time has passed, what is missing is a free response.
    const int skip = static_cast<int>(v.delay / kSampleTime) + 1;
    MatrixXd modes;
    MatrixXd derivatives;
    FreeResponses(response, v.time_scale, count - skip, modes, derivatives);
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
    MatrixXd later;
    MatrixXd sooner;
    MatrixXd unused;
    FreeResponses(response, v.time_scale * std::exp(h), count - skip, later,
                  unused);
    FreeResponses(response, v.time_scale * std::exp(-h), count - skip, sooner,
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

// They end once they are small, not before, and as soon as is asked for.
TEST(ElementResponseTest, FreeResponsesEnd) {
  const int samples = 20000;
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const double T = response.initial_values().time_scale;
    MatrixXd modes;
    MatrixXd derivatives;
    response.FreeResponses(T, kSampleTime, samples, modes, derivatives);
    EXPECT_EQ(modes.cols(), response.order());
    EXPECT_EQ(derivatives.cols(), response.order());
    EXPECT_EQ(derivatives.rows(), modes.rows());
    if (response.order() == 0) {
      EXPECT_EQ(modes.rows(), 0);
      continue;
    }
    const Eigen::Index end = modes.rows();
    ASSERT_GT(end, 0);
    ASSERT_LT(end, samples);
    EXPECT_LT(modes.row(end - 1).norm(), 1e-17 * modes.row(0).norm());
    EXPECT_GT(modes.row(end / 2).norm(), 1e-12 * modes.row(0).norm());
    MatrixXd few;
    MatrixXd unused;
    response.FreeResponses(T, kSampleTime, 5, few, unused);
    EXPECT_EQ(few, modes.topRows(5));
    EXPECT_EQ(unused, derivatives.topRows(5));
  }
}

// In pieces of any size: states, and the inputs at both ends of the dead time,
// are carried over.
TEST(ElementResponseTest, RunsInPieces) {
  const VectorXd inputs = RandomInputs(6);
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const ElementValues& v = response.initial_values();
    const MatrixXd whole =
        SimulateElement(response, v.time_scale, v.delay, inputs, 0.4);
    for (const int columns : {1, 3}) {
      ElementRun run =
          response.Run(v.time_scale, kSampleTime, Split(v.delay), inputs, 0.4,
                       /*derivatives=*/columns == 3);
      MatrixXd pieces(kSamples, columns);
      int first = 0;
      for (const int size : {1, 2, 0, 7, 30, 1, 79}) {
        run.Next(pieces.middleRows(first, size));
        first += size;
      }
      ASSERT_EQ(first, kSamples);
      EXPECT_LT((pieces - whole.leftCols(columns)).cwiseAbs().maxCoeff(),
                1e-12 * (1.0 + whole.cwiseAbs().maxCoeff()));
    }
  }
}

// The numbers of a run of first order make its columns.
TEST(ElementResponseTest, FirstOrderAsNumbers) {
  const VectorXd inputs = RandomInputs(7);
  int found = 0;
  for (const TransferFunction& element : Elements()) {
    const ElementResponse response = Make(element);
    const ElementValues& v = response.initial_values();
    ElementRun run = response.Run(v.time_scale, kSampleTime, Split(v.delay),
                                  inputs, 0.4, /*derivatives=*/true);
    EXPECT_EQ(run.is_first_order(),
              response.order() == 1 && !response.is_integrating());
    if (!run.is_first_order()) continue;
    ++found;
    const ElementRun::FirstOrder by = run.AsFirstOrder();
    const MatrixXd columns =
        SimulateElement(response, v.time_scale, v.delay, inputs, 0.4);
    // In two goes, with a stride.
    MatrixXd u = MatrixXd::Zero(2, kSamples + 2);
    const int half = kSamples / 3;
    run.TakeInputs(half, u.data(), 2);
    run.TakeInputs(kSamples - half, u.data() + 2 * (half + 1), 2);
    EXPECT_TRUE(u.row(1).isZero(0.0));
    EXPECT_EQ(u(0, half), u(0, half + 1));
    VectorXd seen(kSamples + 1);
    seen << u.row(0).head(half + 1).transpose(),
        u.row(0).tail(kSamples - half).transpose();
    double x = by.x;
    double d = 0.0;
    for (int k = 0; k < kSamples; ++k) {
      EXPECT_NEAR(by.C * x, columns(k, 0), 1e-12);
      EXPECT_NEAR(by.C * d, columns(k, 1), 1e-12);
      EXPECT_NEAR(by.s * x + by.t * seen(k), columns(k, 2), 1e-10);
      d = by.a * d + by.e * x + by.c1 * seen(k) + by.c0 * seen(k + 1);
      x = by.a * x + by.b1 * seen(k) + by.b0 * seen(k + 1);
    }
  }
  EXPECT_EQ(found, 2);
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
    const VectorXd step =
        v.gain * SimulateElement(response, v.time_scale, v.delay,
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
