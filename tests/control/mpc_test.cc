#include "control/mpc.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/LU"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::EmptyModel;
using ::testing::HasSubstr;
using testing::MixedModel;
using testing::SingleLoop;

// Small horizons and weights that couple the channels of MixedModel().
MpcOptions MixedOptions() {
  MpcOptions options;
  options.control_period = 0.7;
  options.prediction_horizon = 9;
  options.control_horizon = 3;
  options.output_weight = (MatrixXd(2, 2) << 2.0, 0.3, 0.3, 1.0).finished();
  options.move_weight = MatrixXd::Identity(3, 3) * 0.4;
  options.move_weight(0, 2) = options.move_weight(2, 0) = -0.1;
  return options;
}

MpcOptions SingleOptions(double output_weight, double move_weight) {
  MpcOptions options;
  options.output_weight = MatrixXd::Constant(1, 1, output_weight);
  options.move_weight = MatrixXd::Constant(1, 1, move_weight);
  return options;
}

Mpc MakeMpc(const ProcessModel& model, const MpcOptions& options) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(model, options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return *std::move(mpc);
}

// S_i (p × m) at iΔt_c, i = 0 … count.
std::vector<MatrixXd> StepMatrices(const ProcessModel& model, double period,
                                   int count) {
  const StepResponse responses = model.ComputeStepResponse(period, count + 1);
  std::vector<MatrixXd> S;
  for (int i = 0; i <= count; ++i) {
    MatrixXd matrix(model.num_outputs(), model.num_inputs());
    for (int out = 0; out < matrix.rows(); ++out) {
      for (int in = 0; in < matrix.cols(); ++in) {
        matrix(out, in) = responses.element(out, in)[i];
      }
    }
    S.push_back(matrix);
  }
  return S;
}

// J as it is written in the header, from the errors e_i without moves (p × H_p)
// and the moves (m × H_c).
double Cost(const std::vector<MatrixXd>& S, const MpcOptions& options,
            const MatrixXd& errors, const MatrixXd& moves) {
  double J = 0.0;
  for (int i = 1; i <= options.prediction_horizon; ++i) {
    VectorXd e = errors.col(i - 1);
    for (int j = 1; j <= std::min(i, options.control_horizon); ++j) {
      e -= S[i - j] * moves.col(j - 1);
    }
    J += e.dot(options.output_weight * e);
  }
  for (int j = 0; j < options.control_horizon; ++j) {
    J += moves.col(j).dot(options.move_weight * moves.col(j));
  }
  return J;
}

// J is a quadratic, so that its differences over unit steps are its derivatives
// but for rounding.
MatrixXd Minimiser(const std::vector<MatrixXd>& S, const MpcOptions& options,
                   const MatrixXd& errors) {
  const int n =
      static_cast<int>(options.move_weight.rows()) * options.control_horizon;
  const auto cost = [&](const VectorXd& v) {
    return Cost(
        S, options, errors,
        v.reshaped(options.move_weight.rows(), options.control_horizon));
  };
  const VectorXd zero = VectorXd::Zero(n);
  VectorXd gradient(n);
  MatrixXd hessian(n, n);
  for (int a = 0; a < n; ++a) {
    const VectorXd ea = VectorXd::Unit(n, a);
    gradient[a] = 0.5 * (cost(ea) - cost(-ea));
    for (int b = 0; b < n; ++b) {
      const VectorXd eb = VectorXd::Unit(n, b);
      hessian(a, b) = cost(ea + eb) - cost(ea) - cost(eb) + cost(zero);
    }
  }
  const VectorXd minimiser = -hessian.fullPivLu().solve(gradient);
  return minimiser.reshaped(options.move_weight.rows(),
                            options.control_horizon);
}

TEST(MpcTest, FirstMoveMinimisesTheCost) {
  const ProcessModel model = MixedModel();
  for (const int control_horizon : {1, 3, 9}) {
    MpcOptions options = MixedOptions();
    options.control_horizon = control_horizon;
    const Mpc mpc = MakeMpc(model, options);
    const std::vector<MatrixXd> S =
        StepMatrices(model, options.control_period, options.prediction_horizon);
    for (unsigned seed = 1; seed <= 3; ++seed) {
      std::srand(seed);
      const MatrixXd errors = MatrixXd::Random(2, options.prediction_horizon);
      const MatrixXd moves = Minimiser(S, options, errors);
      const VectorXd first = mpc.gain() * errors.reshaped();
      // Rounding of the differences of J (about 10) over a Hessian ≥ 0.2.
      EXPECT_LE((first - moves.col(0)).cwiseAbs().maxCoeff(), 1e-11);
    }
  }
}

// With the first move the gain gives and the best of the others, no step in any
// direction lowers J.
TEST(MpcTest, NoDirectionLowersTheCost) {
  const ProcessModel model = MixedModel();
  const MpcOptions options = MixedOptions();
  const Mpc mpc = MakeMpc(model, options);
  const std::vector<MatrixXd> S =
      StepMatrices(model, options.control_period, options.prediction_horizon);
  std::srand(5);
  const MatrixXd errors = MatrixXd::Random(2, options.prediction_horizon);
  MatrixXd moves = Minimiser(S, options, errors);
  moves.col(0) = mpc.gain() * errors.reshaped();
  const double J = Cost(S, options, errors, moves);
  for (int trial = 0; trial < 200; ++trial) {
    const MatrixXd direction = MatrixXd::Random(3, options.control_horizon);
    EXPECT_GT(Cost(S, options, errors, moves + 1e-3 * direction), J);
    EXPECT_GT(Cost(S, options, errors, moves - 1e-3 * direction), J);
  }
}

// Every instant against the definition, with f by superposition of all moves so
// far: the n-th move acts from instant n on.
TEST(MpcTest, StepsFollowTheDefinitionUnderAnyMeasurement) {
  const ProcessModel model = MixedModel();
  const MpcOptions options = MixedOptions();
  const int instants = 60, H_p = options.prediction_horizon;
  Mpc mpc = MakeMpc(model, options);
  const std::vector<MatrixXd> S =
      StepMatrices(model, options.control_period, instants + H_p);

  std::vector<VectorXd> moves = {VectorXd::Zero(3)};
  const auto free_response = [&](int at) {
    VectorXd f = VectorXd::Zero(2);
    for (int n = 0; n < static_cast<int>(moves.size()) && n < at; ++n) {
      f += S[at - n] * moves[n];
    }
    return f;
  };
  const double gain = StationaryGain(options.disturbance_variance_ratio);
  VectorXd w = VectorXd::Zero(2), u = VectorXd::Zero(3), next(3);
  std::srand(11);
  for (int l = 0; l < instants; ++l) {
    const VectorXd measured = VectorXd::Random(2);
    const VectorXd r = VectorXd::Random(2);
    mpc.Step(measured, r, next);

    w += gain * (measured - free_response(l) - w);
    MatrixXd errors(2, H_p);
    for (int i = 1; i <= H_p; ++i) {
      errors.col(i - 1) = r - free_response(l + i) - w;
    }
    moves.push_back(Minimiser(S, options, errors).col(0));
    u += moves.back();
    // As above, gathered over the instants.
    ASSERT_LE((next - u).cwiseAbs().maxCoeff(), 1e-9) << l;
    u = next;
  }
}

// What is decided at l acts from l+1, so that with a dead time of q to q+1
// periods the first output it can move is that at l+q+2.
TEST(MpcTest, MoveActsFromTheNextInstantOn) {
  for (const auto& [delay, blind] : std::vector<std::pair<double, int>>{
           {0.0, 1}, {0.4, 1}, {1.0, 2}, {2.5, 3}}) {
    const Mpc mpc =
        MakeMpc(SingleLoop(TransferFunction::FirstOrder(2.0, 5.0, delay)),
                SingleOptions(1.0, 0.1));
    EXPECT_EQ(mpc.gain().leftCols(blind).norm(), 0.0) << delay;
    EXPECT_NE(mpc.gain()(0, blind), 0.0) << delay;
  }
}

TEST(MpcTest, RestIsKeptAtTheSetPoint) {
  Mpc mpc = MakeMpc(MixedModel(), MixedOptions());
  VectorXd next = VectorXd::Ones(3);
  mpc.Step(VectorXd::Zero(2), VectorXd::Zero(2), next);
  EXPECT_EQ(next.norm(), 0.0);
}

TEST(MpcTest, IsLinear) {
  const ProcessModel model = MixedModel();
  Mpc one = MakeMpc(model, MixedOptions());
  Mpc other = MakeMpc(model, MixedOptions());
  Mpc both = MakeMpc(model, MixedOptions());
  std::srand(3);
  VectorXd u(3), v(3), w(3);
  for (int l = 0; l < 30; ++l) {
    const VectorXd y1 = VectorXd::Random(2), y2 = VectorXd::Random(2);
    const VectorXd r1 = VectorXd::Random(2), r2 = VectorXd::Random(2);
    one.Step(y1, r1, u);
    other.Step(y2, r2, v);
    both.Step(3.0 * y1 - y2, 3.0 * r1 - r2, w);
    ASSERT_LE((w - (3.0 * u - v)).cwiseAbs().maxCoeff(), 1e-11);
  }
}

// Outputs in units of 1/c_i, inputs of 1/d_j, weights accordingly: the same
// controller, also where units are many decades apart.
TEST(MpcTest, DoesNotDependOnUnits) {
  const VectorXd c = (VectorXd(2) << 1e6, 1e-4).finished();
  const VectorXd d = (VectorXd(3) << 1e-7, 1e5, 1.0).finished();
  ProcessModel scaled = MixedModel();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      const TransferFunction g = scaled.element(i, j);
      std::vector<double> numerator = g.numerator();
      for (double& b : numerator) b *= c[i] / d[j];
      scaled.element(i, j) =
          TransferFunction(numerator, g.denominator(), g.delay());
    }
  }
  MpcOptions options = MixedOptions();
  const Mpc plain = MakeMpc(MixedModel(), options);
  options.output_weight = c.cwiseInverse().asDiagonal() *
                          options.output_weight * c.cwiseInverse().asDiagonal();
  options.move_weight = d.cwiseInverse().asDiagonal() * options.move_weight *
                        d.cwiseInverse().asDiagonal();
  MatrixXd gain =
      d.cwiseInverse().asDiagonal() * MakeMpc(scaled, options).gain();
  for (int i = 0; i < options.prediction_horizon; ++i) {
    gain.middleCols(2 * i, 2) *= c.asDiagonal();
  }
  EXPECT_LE((gain - plain.gain()).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(MpcTest, CarriesTheFreeResponseUntilTheModelHasSettled) {
  // A triple pole settles far later than its time constant tells.
  const TransferFunction triple({2.0}, {27.0, 27.0, 9.0, 1.0}, 4.0);
  const MpcOptions options = SingleOptions(1.0, 1.0);
  const Mpc mpc = MakeMpc(SingleLoop(triple), options);
  const int n = mpc.model().periods();
  EXPECT_GE(n, options.prediction_horizon);
  EXPECT_NEAR(triple.StepResponse(1.0, n + 1)[n], 2.0, 1e-10);
  // Not without end either: e^{-40} is below the last digit.
  EXPECT_LE(n, 4 + 40 * 3);
}

TEST(MpcTest, DisturbancesAreNotMoved) {
  ProcessModel with_disturbance(
      "test", "min",
      {{.name = "a", .unit = "1"},
       {.name = "d", .unit = "1", .role = InputRole::kDisturbance},
       {.name = "b", .unit = "1"}},
      {{.name = "y1", .unit = "1"}, {.name = "y2", .unit = "1"}});
  ProcessModel without = EmptyModel(2, 2);
  const ProcessModel mixed = MixedModel();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      with_disturbance.element(i, j) = mixed.element(i, j);
    }
    without.element(i, 0) = mixed.element(i, 0);
    without.element(i, 1) = mixed.element(i, 2);
  }
  MpcOptions options = MixedOptions();
  Mpc mpc = MakeMpc(with_disturbance, options);
  const MatrixXd weight = options.move_weight;
  options.move_weight.resize(2, 2);
  options.move_weight << weight(0, 0), weight(0, 2), weight(2, 0), weight(2, 2);
  Mpc reduced = MakeMpc(without, options);

  VectorXd next(3), expected(2);
  std::srand(2);
  for (int l = 0; l < 10; ++l) {
    const VectorXd y = VectorXd::Random(2), r = VectorXd::Random(2);
    mpc.Step(y, r, next);
    reduced.Step(y, r, expected);
    EXPECT_EQ(next[1], 0.0);
    EXPECT_EQ(next[0], expected[0]);
    EXPECT_EQ(next[2], expected[1]);
  }
}

std::string CreateError(const ProcessModel& model, const MpcOptions& options) {
  const absl::StatusOr<Mpc> mpc = Mpc::Create(model, options);
  EXPECT_EQ(mpc.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(mpc.status().message());
}

TEST(MpcTest, OptionsNameFieldValueAndConstraint) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](auto change) {
    MpcOptions options = MixedOptions();
    change(options);
    return CreateError(MixedModel(), options);
  };
  EXPECT_THAT(error([](MpcOptions& o) { o.control_period = 0.0; }),
              HasSubstr("control_period = 0"));
  EXPECT_THAT(error([nan](MpcOptions& o) { o.control_period = nan; }),
              HasSubstr("control_period = nan"));
  EXPECT_THAT(error([](MpcOptions& o) { o.control_horizon = 0; }),
              HasSubstr("control_horizon = 0"));
  const std::string horizons =
      error([](MpcOptions& o) { o.control_horizon = 10; });
  EXPECT_THAT(horizons, HasSubstr("prediction_horizon = 9"));
  EXPECT_THAT(horizons, HasSubstr("control_horizon = 10"));
  // Matrices of as many numbers as no memory holds.
  EXPECT_THAT(error([](MpcOptions& o) { o.prediction_horizon = 2147483647; }),
              HasSubstr("prediction_horizon = 2147483647 with 3 moves is too "
                        "long"));
  EXPECT_THAT(error([](MpcOptions& o) {
                o.prediction_horizon = 20'000;
                o.block_lengths.assign(20'000, 1);
              }),
              HasSubstr("prediction_horizon = 20000 with 20000 moves"));
  EXPECT_THAT(error([](MpcOptions& o) { o.disturbance_variance_ratio = -1.0; }),
              HasSubstr("disturbance_variance_ratio = -1"));
  EXPECT_THAT(
      error([nan](MpcOptions& o) { o.disturbance_variance_ratio = nan; }),
      HasSubstr("disturbance_variance_ratio = nan"));
}

TEST(MpcTest, AGainThatIsNoNumberIsRefused) {
  MpcOptions options = MixedOptions();
  options.output_weight *= 5e-324;
  options.move_weight *= 1e-310;
  EXPECT_THAT(CreateError(MixedModel(), options),
              HasSubstr("beyond double precision"));
}

TEST(MpcTest, WeightsAreChecked) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](auto change) {
    MpcOptions options = MixedOptions();
    change(options);
    return CreateError(MixedModel(), options);
  };
  EXPECT_THAT(error([](MpcOptions& o) { o.output_weight.resize(0, 0); }),
              HasSubstr("output_weight is 0 × 0, but it must be 2 × 2"));
  EXPECT_THAT(
      error([](MpcOptions& o) { o.move_weight = MatrixXd::Identity(2, 2); }),
      HasSubstr("move_weight is 2 × 2, but it must be 3 × 3"));
  EXPECT_THAT(error([](MpcOptions& o) { o.output_weight(0, 1) = 0.5; }),
              HasSubstr("must be symmetric"));
  EXPECT_THAT(error([](MpcOptions& o) { o.move_weight(1, 1) = -0.2; }),
              HasSubstr("move_weight has the eigenvalue -0.2"));
  EXPECT_THAT(error([nan](MpcOptions& o) { o.output_weight(1, 1) = nan; }),
              HasSubstr("not finite"));
}

// Two inputs of the same effect and no price on moving them: which to move is
// not determined.
TEST(MpcTest, RefusesWeightsThatDoNotDetermineTheMoves) {
  ProcessModel model = EmptyModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 0.0);
  model.element(0, 1) = TransferFunction::FirstOrder(2.0, 5.0, 0.0);
  MpcOptions options = SingleOptions(1.0, 0.0);
  options.move_weight = MatrixXd::Zero(2, 2);
  EXPECT_THAT(CreateError(model, options), HasSubstr("positive definite"));
  // So little that rounding decides: the second input could be any number.
  options.move_weight = 1e-13 * MatrixXd::Identity(2, 2);
  EXPECT_THAT(CreateError(model, options), HasSubstr("positive definite"));
  options.move_weight = MatrixXd::Zero(2, 2);
  options.move_weight(0, 0) = 0.1;
  EXPECT_TRUE(Mpc::Create(model, options).ok());

  EXPECT_THAT(CreateError(model,
                          [] {
                            MpcOptions none = SingleOptions(0.0, 0.0);
                            none.move_weight = MatrixXd::Zero(2, 2);
                            return none;
                          }()),
              HasSubstr("positive definite"));
}

TEST(MpcTest, RefusesAModelThatItCannotControl) {
  const ProcessModel only_disturbance(
      "test", "min",
      {{.name = "d", .unit = "1", .role = InputRole::kDisturbance}},
      {{.name = "y", .unit = "1"}});
  EXPECT_THAT(CreateError(only_disturbance, SingleOptions(1.0, 1.0)),
              HasSubstr("no manipulated input"));
  EXPECT_THAT(
      CreateError(SingleLoop(TransferFunction::FirstOrder(1.0, 1e9, 0.0)),
                  SingleOptions(1.0, 1.0)),
      HasSubstr("longer control_period"));
}

// A walk of each output with the gain of ρ as disturbance model: the same
// moves.
TEST(MpcDisturbanceModelTest, AWalkGivesTheMovesOfTheBiasFilter) {
  const ProcessModel model = MixedModel();
  MpcOptions options = MixedOptions();
  Mpc bias = MakeMpc(model, options);
  DisturbanceForm walks;
  walks.A = walks.C = walks.Q = MatrixXd::Identity(2, 2);
  walks.K = MatrixXd::Identity(2, 2) *
            StationaryGain(options.disturbance_variance_ratio);
  walks.R = VectorXd::Ones(2);
  options.disturbance_model = walks;
  Mpc modelled = MakeMpc(model, options);
  VectorXd one(3);
  VectorXd other(3);
  const VectorXd set_points = VectorXd::Zero(2);
  for (int l = 0; l < 20; ++l) {
    const VectorXd measured = Eigen::Vector2d(std::sin(0.5 * l), 0.1 * l);
    bias.Step(measured, set_points, one);
    modelled.Step(measured, set_points, other);
    EXPECT_TRUE(one.isApprox(other, 1e-12) || one.isZero(1e-12));
  }
  const VectorXd before = modelled.PredictedOutputs();
  ASSERT_TRUE(
      modelled.ExchangeModel(modelled.model(), modelled.options()).ok());
  EXPECT_TRUE(modelled.PredictedOutputs().isApprox(before, 1e-10));
}

TEST(MpcDisturbanceModelTest, RefusesWhatItCannotUse) {
  MpcOptions options = MixedOptions();
  DisturbanceForm form;
  form.A = form.Q = MatrixXd::Identity(1, 1);
  form.C = form.K = MatrixXd::Ones(1, 1);
  form.R = VectorXd::Ones(1);
  options.disturbance_model = form;
  EXPECT_THAT(Mpc::Create(MixedModel(), options).status().message(),
              HasSubstr("C p × n"));
}

}  // namespace
}  // namespace mle::control
