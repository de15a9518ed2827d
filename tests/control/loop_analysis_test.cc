#include "control/loop_analysis.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/control/analysed_loops.h"
#include "tests/mle/base/optimised_algebra.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using analysed_loops::Analyse;
using analysed_loops::FastTwoByTwo;
using analysed_loops::MakeAnalysedMpc;
using analysed_loops::Options;
using analysed_loops::Predict;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::EmptyModel;
using testing::SingleLoop;

// The loop as x ← A x, x = (moves decided 1 … N instants ago, u and v, ŵ and d̂
// of the coming instant), with the laws as mpc.h states them: of older moves
// u = Σ Δu and v = Σ (a − 1) Δu, a their age; v where a pair ends in a ramp.
// A's eigenvalues are the modes; independent of transfer functions.
MatrixXd ClosedLoopMatrix(const Mpc& mpc, const PredictionModel& plant) {
  const int p = plant.num_outputs;
  const int m = plant.num_inputs();
  const bool ramps = plant.IsIntegrating() || mpc.model().IsIntegrating();
  const int N = std::max(plant.periods(), mpc.model().periods()) + 1;
  const int H_p = static_cast<int>(mpc.gain().cols()) / p;
  const int at_u = m * N;
  const int at_v = at_u + m;
  const int at_w = at_v + (ramps ? m : 0);
  const int size = at_w + 2 * p;
  std::vector<int> inputs(m);
  std::iota(inputs.begin(), inputs.end(), 0);
  // S_k = S_n + (k − n) R beyond n.
  const auto step = [&](const PredictionModel& model, int k) -> MatrixXd {
    const int n = model.periods();
    return model.responses.middleRows(p * std::min(k, n), p) +
           std::max(k - n, 0) * model.SlopesOf(inputs);
  };
  // y_l and f_{l+i} as linear functions of x.
  const auto response = [&](const PredictionModel& model, int ahead) {
    MatrixXd row = MatrixXd::Zero(p, size);
    for (int a = 1; a <= N; ++a) {
      row.middleCols(m * (a - 1), m) = step(model, a + ahead - 1);
    }
    row.middleCols(at_u, m) =
        step(model, model.periods()) +
        (ahead - model.periods()) * model.SlopesOf(inputs);
    if (ramps) row.middleCols(at_v, m) = model.SlopesOf(inputs);
    return row;
  };
  const DisturbanceObserver& observer = mpc.observer();
  MatrixXd w_now = MatrixXd::Zero(p, size);
  w_now.middleCols(at_w, p).setIdentity();
  // Outputs without ramps have no d̂.
  MatrixXd d_now = MatrixXd::Zero(p, size);
  d_now.rightCols(p).diagonal() =
      (observer.slope_gains().array() > 0.0).cast<double>();
  const MatrixXd innovation =
      response(plant, 0) - response(mpc.model(), 0) - w_now;
  w_now += observer.gains().asDiagonal() * innovation;
  d_now += observer.slope_gains().asDiagonal() * innovation;
  MatrixXd move = MatrixXd::Zero(m, size);
  for (int i = 1; i <= H_p; ++i) {
    move -= mpc.gain().middleCols(p * (i - 1), p) *
            (response(mpc.model(), i) + w_now + i * d_now);
  }
  MatrixXd A = MatrixXd::Zero(size, size);
  A.topRows(m) = move;
  A.block(m, 0, m * (N - 1), m * (N - 1)).setIdentity();
  A.block(at_u, m * (N - 1), m, m).setIdentity();
  A.block(at_u, at_u, m, m).setIdentity();
  if (ramps) {
    // One instant on each age is one more, and the youngest of u is N + 1.
    A.block(at_v, at_v, m, m).setIdentity();
    A.block(at_v, at_u, m, m).setIdentity();
    A.block(at_v, m * (N - 1), m, m) = N * MatrixXd::Identity(m, m);
  }
  A.middleRows(at_w, p) = w_now + d_now;
  A.bottomRows(p) = d_now;
  return A;
}

struct Modes {
  double radius = 0.0;
  int growing = 0;
};

// Several modes at 1 are off by more than one is: `margin`.
Modes EigenvalueModes(const Mpc& mpc, const PredictionModel& plant,
                      double margin = 1e-6) {
  const VectorXd sizes = Eigenvalues(ClosedLoopMatrix(mpc, plant)).cwiseAbs();
  return {sizes.maxCoeff(),
          static_cast<int>((sizes.array() > 1.0 + margin).count())};
}

// The analysis, whose modes are those of the eigenvalues.
LoopAnalysis AnalyseLikeEigenvalues(const Mpc& mpc,
                                    const PredictionModel& plant) {
  const Modes expected = EigenvalueModes(mpc, plant);
  LoopAnalysis analysis = Analyse(mpc, plant);
  EXPECT_EQ(analysis.growing_modes, expected.growing);
  EXPECT_EQ(analysis.stable, expected.growing == 0);
  if (expected.growing > 0) {
    // The search ends within 1e-5 of |w|.
    EXPECT_NEAR(analysis.spectral_radius, expected.radius,
                1e-4 * expected.radius);
  } else {
    EXPECT_GE(analysis.spectral_radius, expected.radius - 1e-4);
  }
  return analysis;
}

TEST(LoopAnalysisTest, CountsTheModesThatEigenvaluesShow) {
  const PredictionModel model = Predict(FastTwoByTwo());
  for (const double ratio : {0.05, 1.0}) {
    MpcOptions options = Options(2, 2, 0.02);
    options.disturbance_variance_ratio = ratio;
    const Mpc mpc = MakeAnalysedMpc(model, options);
    int unstable = 0;
    for (const double factor : {0.3, 1.0, 1.7, 2.6, 4.0, 8.0}) {
      for (const double delay : {0.0, 1.0, 3.0}) {
        ProcessModel aged = FastTwoByTwo();
        for (int i = 0; i < 2; ++i) {
          for (int j = 0; j < 2; ++j) {
            const TransferFunction g = aged.element(i, j);
            std::vector<double> numerator = g.numerator();
            for (double& b : numerator) b *= i == j ? factor : 1.0;
            aged.element(i, j) = TransferFunction(
                numerator, g.denominator(), g.delay() + (j == 0 ? delay : 0));
          }
        }
        SCOPED_TRACE(::testing::Message() << factor << " " << delay);
        if (!AnalyseLikeEigenvalues(mpc, Predict(aged)).stable) ++unstable;
      }
    }
    EXPECT_GT(unstable, 3);
  }
}

// With levels: an integrator with lag and dead time, and in a 2 × 2 loop one
// level beside an output that settles.
TEST(LoopAnalysisTest, CountsTheModesOfLevels) {
  int unstable = 0;
  int stable = 0;
  for (const double ratio : {0.05, 0.5, 5.0}) {
    for (const double weight : {0.02, 2.0}) {
      for (const double factor : {0.05, 0.3, 1.0, 1.7, 3.0, 6.0}) {
        for (const double delay : {0.0, 2.0}) {
          MpcOptions options = Options(1, 1, weight);
          options.disturbance_variance_ratio = ratio;
          const Mpc mpc = MakeAnalysedMpc(
              Predict(SingleLoop(TransferFunction::Integrator(0.5, 1.1, 0.7))),
              options);
          const PredictionModel plant = Predict(SingleLoop(
              TransferFunction::Integrator(0.5 * factor, 1.1, 0.7 + delay)));
          SCOPED_TRACE(::testing::Message() << ratio << " " << weight << " "
                                            << factor << " " << delay);
          const LoopAnalysis analysis = AnalyseLikeEigenvalues(mpc, plant);
          if (!analysis.stable) {
            ++unstable;
          } else {
            ++stable;
            EXPECT_GT(analysis.sensitivity_peak, 1.0);
            // No offset from loads either: T(0) = 1.
            EXPECT_GE(analysis.complementary_peak, 1.0 - 1e-3);
          }
        }
      }
    }
  }
  EXPECT_GT(unstable, 10);
  EXPECT_GT(stable, 10);
}

TEST(LoopAnalysisTest, CountsTheModesOfALevelBesideOutputsThatSettle) {
  ProcessModel believed = FastTwoByTwo();
  believed.element(1, 0) = TransferFunction::Integrator(0.2, 0.5, 1.0);
  believed.element(1, 1) = TransferFunction::Integrator(0.6, 0.0, 0.5);
  const Mpc mpc = MakeAnalysedMpc(Predict(believed), Options(2, 2, 0.1));
  int unstable = 0;
  for (const double factor : {0.3, 1.0, 2.0, 4.0, 8.0}) {
    for (const double delay : {0.0, 1.0, 3.0}) {
      ProcessModel aged = believed;
      aged.element(1, 1) =
          TransferFunction::Integrator(0.6 * factor, 0.0, 0.5 + delay);
      const PredictionModel plant = Predict(aged);
      // Two modes at 1, of sums that the one level does not need.
      const int growing = EigenvalueModes(mpc, plant, 1e-4).growing;
      EXPECT_EQ(Analyse(mpc, plant).growing_modes, growing)
          << factor << " " << delay;
      unstable += growing > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(unstable, 3);
  EXPECT_LT(unstable, 12);
}

// The plant integrates and the model does not know it: no offset, but the loop
// is not calm, and settles or not as its eigenvalues say.
TEST(LoopAnalysisTest, CountsTheModesOfALevelThatTheModelDoesNotKnow) {
  for (const double gain : {0.02, 0.2, 1.0}) {
    const Mpc mpc = MakeAnalysedMpc(
        Predict(SingleLoop(TransferFunction::FirstOrder(2.0, 3.0, 1.0))),
        Options(1, 1, 1.0));
    const PredictionModel plant =
        Predict(SingleLoop(TransferFunction::Integrator(gain, 0.0, 1.0)));
    EXPECT_EQ(Analyse(mpc, plant).growing_modes,
              EigenvalueModes(mpc, plant).growing)
        << gain;
  }
}

// A slow loop on a quick plant: its mode is found, not only bounded.
TEST(LoopAnalysisTest, FindsASlowMode) {
  const PredictionModel model =
      Predict(SingleLoop(TransferFunction::FirstOrder(1.0, 0.8, 0.0)));
  const Mpc mpc = MakeAnalysedMpc(model, Options(1, 1, 3000.0));
  const Modes expected = EigenvalueModes(mpc, model);
  ASSERT_GT(expected.radius, 0.95);
  EXPECT_NEAR(Analyse(mpc, model).spectral_radius, expected.radius, 1e-4);
}

TEST(LoopAnalysisTest, SurplusInputsAreNoInstability) {
  ProcessModel model = EmptyModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 1.5, 0.5);
  model.element(0, 1) = TransferFunction::FirstOrder(2.0, 1.0, 0.0);
  const PredictionModel prediction = Predict(model);
  const LoopAnalysis analysis =
      Analyse(MakeAnalysedMpc(prediction, Options(1, 2, 0.1)), prediction);
  EXPECT_TRUE(analysis.stable);
  EXPECT_EQ(analysis.spectral_radius, 1.0);
}

// One input cannot bring two outputs to their set points, but its loop can be
// stable: outputs that settle, a level beside one, and two levels in step.
TEST(LoopAnalysisTest, CountsTheModesOfMoreOutputsThanInputs) {
  const auto settles = [](double gain) {
    return TransferFunction::FirstOrder(gain, 1.2, 0.5);
  };
  const auto level = [](double gain, double delay) {
    return TransferFunction::Integrator(gain, 0.0, delay);
  };
  int unstable = 0;
  for (const int levels : {0, 1, 2}) {
    for (const double factor : {1.0, 3.0, 8.0}) {
      const auto process = [&](double gain) {
        ProcessModel model = EmptyModel(2, 1);
        model.element(0, 0) =
            levels > 0 ? level(0.5 * gain, 0.5) : settles(gain);
        model.element(1, 0) =
            levels > 1 ? level(0.2 * gain, 1.0) : settles(0.7 * gain);
        return Predict(model);
      };
      SCOPED_TRACE(::testing::Message() << levels << " " << factor);
      const Mpc mpc = MakeAnalysedMpc(process(1.0), Options(2, 1, 0.1));
      const PredictionModel plant = process(factor);
      const int growing = EigenvalueModes(mpc, plant, 1e-4).growing;
      const LoopAnalysis analysis = Analyse(mpc, plant);
      EXPECT_EQ(analysis.growing_modes, growing);
      unstable += growing > 0 ? 1 : 0;
      // Two levels drift apart.
      if (growing == 0 && levels < 2) {
        EXPECT_LT(analysis.spectral_radius, 0.99);
      }
    }
  }
  EXPECT_GT(unstable, 2);
  EXPECT_LT(unstable, 9);
}

TEST(LoopAnalysisTest, CountsTheModesOfPlantsWithoutSomeElements) {
  ProcessModel believed = FastTwoByTwo();
  believed.element(1, 0) = TransferFunction();
  const Mpc mpc = MakeAnalysedMpc(Predict(believed), Options(2, 2, 0.02));
  int unstable = 0;
  for (const double factor : {0.5, 1.0, 3.0, 8.0}) {
    ProcessModel aged = believed;
    const TransferFunction g = aged.element(1, 1);
    std::vector<double> numerator = g.numerator();
    for (double& b : numerator) b *= factor;
    aged.element(1, 1) =
        TransferFunction(numerator, g.denominator(), g.delay() + 1.0);
    // An element that the model does not know, in place of one that it knows.
    aged.element(1, 0) = aged.element(0, 1);
    aged.element(0, 1) = TransferFunction();
    SCOPED_TRACE(factor);
    if (!AnalyseLikeEigenvalues(mpc, Predict(aged)).stable) ++unstable;
  }
  EXPECT_GT(unstable, 0);
  EXPECT_LT(unstable, 4);
}

// Inputs that act alike are one input of their gains together, moved as
// cheaply: each of them but one adds a mode at 1 and nothing else. So many of
// them make a determinant smaller than any number where it is evaluated nearest
// to 1.
TEST(LoopAnalysisTest, ManyInputsThatActAlikeAreOne) {
  constexpr int kInputs = 61;
  constexpr double kWeight = 0.1;
  const auto process = [](int inputs, double factor) {
    ProcessModel model = EmptyModel(1, inputs);
    for (int j = 0; j < inputs; ++j) {
      model.element(0, j) =
          TransferFunction::FirstOrder(factor / inputs, 2.0, 1.0);
    }
    return Predict(model);
  };
  const Mpc one = MakeAnalysedMpc(process(1, 1.0), Options(1, 1, kWeight));
  const Mpc many = MakeAnalysedMpc(process(kInputs, 1.0),
                                   Options(1, kInputs, kWeight / kInputs));
  int unstable = 0;
  for (const double factor : {0.5, 1.0, 4.0, 8.0}) {
    SCOPED_TRACE(factor);
    const LoopAnalysis expected = Analyse(one, process(1, factor));
    const LoopAnalysis analysis = Analyse(many, process(kInputs, factor));
    EXPECT_EQ(analysis.growing_modes, expected.growing_modes);
    if (expected.stable) {
      EXPECT_EQ(analysis.spectral_radius, 1.0);
      EXPECT_NEAR(analysis.sensitivity_peak, expected.sensitivity_peak, 1e-6);
      EXPECT_NEAR(analysis.complementary_peak, expected.complementary_peak,
                  1e-6);
    } else {
      ++unstable;
      EXPECT_NEAR(analysis.spectral_radius, expected.spectral_radius, 1e-4);
    }
  }
  EXPECT_EQ(unstable, 2);
}

// Many periods, and a mode that hardly decays: the grid of the transform has to
// be fine enough, and between its points the phase is followed.
TEST(LoopAnalysisTest, CountsTheModesOfLongResponses) {
  const PredictionModel model =
      Predict(SingleLoop(TransferFunction::FirstOrder(1.0, 400.0, 3.0)));
  ASSERT_GT(model.periods(), 1000);
  const Mpc mpc = MakeAnalysedMpc(model, Options(1, 1, 1.0));
  EXPECT_TRUE(Analyse(mpc, model).stable);
  // A plant of forty times the gain: the loop's dead time cannot bear it.
  const LoopAnalysis wild = Analyse(
      mpc, Predict(SingleLoop(TransferFunction::FirstOrder(40.0, 400.0, 3.0))));
  EXPECT_FALSE(wild.stable);
  EXPECT_GE(wild.growing_modes, 1);
}

TEST(LoopAnalysisTest, RefusesResponsesThatHardlySettle) {
  const PredictionModel model =
      Predict(SingleLoop(TransferFunction::FirstOrder(1.0, 10.0, 3.0)));
  const Mpc mpc = MakeAnalysedMpc(model, Options(1, 1, 1.0));
  const auto status =
      AnalyseLoop(
          mpc,
          Predict(SingleLoop(TransferFunction::FirstOrder(1.0, 20'000.0, 3.0))))
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("control periods, and loops of up to 50000"),
            std::string::npos)
      << status;
}

TEST(LoopAnalysisTest, RefusesAnotherShape) {
  const PredictionModel model = Predict(FastTwoByTwo());
  const Mpc mpc = MakeAnalysedMpc(model, Options(2, 2, 0.1));
  const PredictionModel other =
      Predict(SingleLoop(TransferFunction::FirstOrder(1.0, 1.0, 0.0)));
  EXPECT_EQ(AnalyseLoop(mpc, other).status().code(),
            absl::StatusCode::kInvalidArgument);
}

// A plant whose responses go beyond double precision, seen from the controller.
TEST(LoopAnalysisTest, SaysWhereNothingCanBeCounted) {
  const auto process = [](double gain) {
    return SingleLoop(TransferFunction::FirstOrder(gain, 5.0, 2.0));
  };
  const Mpc mpc = MakeAnalysedMpc(Predict(process(1e-5)), Options(1, 1, 1e-12));
  const absl::Status status =
      AnalyseLoop(mpc, Predict(process(1e307))).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_NE(status.message().find("modes cannot be counted"), std::string::npos)
      << status;
}

}  // namespace
}  // namespace mle::control
