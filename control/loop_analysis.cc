#include "control/loop_analysis.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "absl/strings/str_format.h"
#include "control/matrix_series.h"
#include "mle/base/fast_length.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double kPi = std::numbers::pi;
// A mode this much larger than 1 per period grows.
constexpr double kMargin = 1e-6;
// Complex numbers that the transforms of one circle may hold (256 MiB).
constexpr Eigen::Index kMostNumbers = Eigen::Index{1} << 24;

// The responses S_k = L + kR + C_k of a model, of which C_k decays.
struct Decomposed {
  Decomposed(const PredictionModel& model, const std::vector<int>& inputs)
      : slopes(model.SlopesOf(inputs)),
        decaying(model.num_outputs, slopes.cols(), model.periods()) {
    const int p = model.num_outputs;
    const int n = model.periods();
    level = model.responses(Eigen::seqN(p * n, p), inputs) - n * slopes;
    for (int k = 0; k < n; ++k) {
      decaying.SetTerm(k + 1, model.responses(Eigen::seqN(p * k, p), inputs) -
                                  level - static_cast<double>(k) * slopes);
    }
    decaying.Trim();
  }

  MatrixXd slopes;        // R
  MatrixXd level;         // L
  MatrixSeries decaying;  // c_0 = Σ C_{a−1} w^a
};

// The loop's transfer matrices, as the header has them.
class Loop {
 public:
  Loop(const Mpc& mpc, const PredictionModel& plant)
      : gains_(mpc.observer().gains()),
        slope_gains_(mpc.observer().slope_gains()),
        model_(mpc.model(), mpc.model().InputsOf(InputRole::kManipulated)),
        plant_(plant, mpc.model().InputsOf(InputRole::kManipulated)),
        predictor_(model_.decaying.Ahead(mpc.gain())),
        degree_(std::max({model_.decaying.degree(), plant_.decaying.degree(),
                          predictor_.degree()})) {
    const Eigen::Index p = mpc.model().num_outputs;
    sum_ = MatrixXd::Zero(mpc.gain().rows(), p);
    moment_ = sum_;
    for (Eigen::Index i = 0; i < mpc.gain().cols(); i += p) {
      const auto block = mpc.gain().middleCols(i, p);
      sum_ += block;
      moment_ += static_cast<double>(i / p + 1) * block;
    }
    integrating_ = (plant_.slopes.array() != 0.0).rowwise().any();
    const Eigen::Index m = sum_.rows();
    const Eigen::Index q = integrating_.count();
    const Eigen::Index twice = std::min(m, q);
    surplus_outputs_ =
        static_cast<double>(p + q - 2 * twice - std::min(m - twice, p - q));
    scale_ = mpc.options().output_weight.diagonal().cwiseSqrt();
    for (double& value : scale_) {
      if (value == 0.0) value = 1.0;
    }
  }

  Eigen::Index degree() const { return degree_; }
  Eigen::Index entries() const {
    return predictor_.entries() + model_.decaying.entries() +
           plant_.decaying.entries();
  }
  int surplus_inputs() const {
    return std::max(
        0, static_cast<int>(sum_.rows()) - static_cast<int>(sum_.cols()));
  }
  // The slowest pole of the observer; its inverse is a pole of D.
  double slowest_observer() const {
    double slowest = 0.0;
    for (Eigen::Index i = 0; i < gains_.size(); ++i) {
      const double kept = 1.0 - gains_[i];
      slowest =
          std::max(slowest, slope_gains_[i] > 0.0 ? std::sqrt(kept) : kept);
    }
    return slowest;
  }

  // ln D, up to a multiple of 2πi: D of many outputs has no size that numbers
  // of eight bytes could hold.
  Complex LogDeterminant(Complex w) const {
    const VectorXcd powers = Powers(w);
    return LogDeterminant(w, predictor_(powers), model_.decaying(powers),
                          plant_.decaying(powers));
  }
  // At r e^{iπk/n}, k = 0 … n.
  VectorXcd LogDeterminantsOnHalfCircle(double radius, int n) const {
    const MatrixXcd predictor = predictor_.OnHalfCircle(radius, n);
    const MatrixXcd model = model_.decaying.OnHalfCircle(radius, n);
    const MatrixXcd plant = plant_.decaying.OnHalfCircle(radius, n);
    VectorXcd values(n + 1);
    for (int k = 0; k <= n; ++k) {
      values(k) = LogDeterminant(std::polar(radius, kPi * k / n),
                                 predictor_.Matrix(predictor.col(k)),
                                 model_.decaying.Matrix(model.col(k)),
                                 plant_.decaying.Matrix(plant.col(k)));
    }
    return values;
  }

  // S at e^{−iθ} for angles θ ≠ 0, in scaled outputs.
  std::vector<MatrixXcd> Sensitivities(
      const std::vector<double>& angles) const {
    const auto count = static_cast<Eigen::Index>(angles.size());
    MatrixXcd powers(degree_, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      powers.col(k) = Powers(std::polar(1.0, -angles[k]));
    }
    const MatrixXcd predictor = predictor_.AtAll(powers);
    const MatrixXcd model = model_.decaying.AtAll(powers);
    const MatrixXcd plant = plant_.decaying.AtAll(powers);
    std::vector<MatrixXcd> sensitivities;
    for (Eigen::Index k = 0; k < count; ++k) {
      sensitivities.push_back(
          Sensitivity(powers(0, k), predictor_.Matrix(predictor.col(k)),
                      model_.decaying.Matrix(model.col(k)),
                      plant_.decaying.Matrix(plant.col(k))));
    }
    return sensitivities;
  }
  // S at e^{iπk/n}, k = 1 … n: the conjugates of those at e^{−iπk/n}.
  std::vector<MatrixXcd> SensitivitiesOnHalfCircle(int n) const {
    const MatrixXcd predictor = predictor_.OnHalfCircle(1.0, n);
    const MatrixXcd model = model_.decaying.OnHalfCircle(1.0, n);
    const MatrixXcd plant = plant_.decaying.OnHalfCircle(1.0, n);
    std::vector<MatrixXcd> sensitivities;
    for (int k = 1; k <= n; ++k) {
      sensitivities.push_back(Sensitivity(
          std::polar(1.0, kPi * k / n), predictor_.Matrix(predictor.col(k)),
          model_.decaying.Matrix(model.col(k)),
          plant_.decaying.Matrix(plant.col(k))));
    }
    return sensitivities;
  }

 private:
  // The observer's answer, for each output, to its innovation i periods ahead,
  // W_i = φ + iψ, to a level that the model is off by, (1 − W_i) w/(1 − w) =
  // α + iβ, and to a ramp, (1 − W_i) w²/(1 − w)² + i w/(1 − w) = γ + iδ.
  struct ObserverAt {
    VectorXcd phi, psi, alpha, beta, gamma, delta;
  };

  VectorXcd Powers(Complex w) const {
    VectorXcd powers(degree_);
    Complex power = 1.0;
    for (Complex& value : powers) value = power *= w;
    return powers;
  }

  ObserverAt Observe(Complex w) const {
    const Eigen::Index p = gains_.size();
    ObserverAt at;
    for (VectorXcd* values :
         {&at.phi, &at.psi, &at.alpha, &at.beta, &at.gamma, &at.delta}) {
      values->setZero(p);
    }
    const Complex rest = 1.0 - w;
    for (Eigen::Index o = 0; o < p; ++o) {
      const double g = gains_[o];
      const double h = slope_gains_[o];
      const double kept = 1.0 - g;
      if (h == 0.0) {
        const Complex pole = 1.0 - kept * w;
        at.phi(o) = g / pole;
        at.alpha(o) = kept * w / pole;
        at.gamma(o) = kept * w * w / (rest * pole);
        at.delta(o) = w / rest;
        continue;
      }
      const Complex pole = 1.0 - std::sqrt(kept) * w;
      const Complex scale = 1.0 / (pole * pole);
      at.phi(o) = 1.0 - kept * rest * rest * scale;
      at.psi(o) = h * rest * scale;
      at.alpha(o) = kept * w * rest * scale;
      at.beta(o) = -h * w * scale;
      at.gamma(o) = kept * w * w * scale;
      at.delta(o) = w * (1.0 - kept * w) * scale;
    }
    return at;
  }

  // V = Σ K_i W_i.
  MatrixXcd Feedback(const ObserverAt& at) const {
    return sum_ * at.phi.asDiagonal() + moment_ * at.psi.asDiagonal();
  }
  // I + Σ K_i (F_i − W_i F_0) + V (`innovation` + c_0).
  MatrixXcd Controller(const ObserverAt& at, const MatrixXcd& predictor,
                       const MatrixXcd& innovation) const {
    const MatrixXd& L = model_.level;
    const MatrixXd& R = model_.slopes;
    MatrixXcd once =
        at.alpha.asDiagonal() * L + at.phi.asDiagonal() * innovation;
    MatrixXcd result = predictor;
    if (!slope_gains_.isZero(0.0) || !R.isZero(0.0)) {
      once += at.gamma.asDiagonal() * R;
      result +=
          moment_ * (at.beta.asDiagonal() * L + at.delta.asDiagonal() * R +
                     at.psi.asDiagonal() * innovation);
    }
    result += sum_ * once;
    result.diagonal().array() += 1.0;
    return result;
  }
  MatrixXcd Sensitivity(Complex w, const MatrixXcd& predictor,
                        const MatrixXcd& model, const MatrixXcd& plant) const {
    const ObserverAt at = Observe(w);
    const Complex sum = w / (1.0 - w);
    const MatrixXcd PC =
        (plant + sum * plant_.level + sum * sum * plant_.slopes) *
        Controller(at, predictor, -model).partialPivLu().solve(Feedback(at));
    const Eigen::Index p = PC.rows();
    const MatrixXcd S = (MatrixXcd::Identity(p, p) + PC).inverse();
    return scale_.asDiagonal() * S * scale_.cwiseInverse().asDiagonal();
  }
  Complex LogDeterminant(Complex w, const MatrixXcd& predictor,
                         const MatrixXcd& model, const MatrixXcd& plant) const {
    const ObserverAt at = Observe(w);
    const Complex rest = 1.0 - w;
    const Eigen::Index m = sum_.rows();
    const Eigen::Index p = sum_.cols();
    MatrixXcd bordered = MatrixXcd::Zero(m + p, m + p);
    bordered.topLeftCorner(m, m) =
        Controller(at, predictor, plant - model + plant_.slopes - plant_.level);
    bordered.topRightCorner(m, p) = Feedback(at);
    for (Eigen::Index o = 0; o < p; ++o) {
      const auto L = plant_.level.row(o);
      const auto R = plant_.slopes.row(o);
      if (integrating_(o)) {
        bordered.row(m + o).head(m) = -R - rest * (L - 2.0 * R);
      } else {
        bordered.row(m + o).head(m) = -L;
      }
      bordered(m + o, m + o) = integrating_(o) ? rest * rest : rest;
    }
    const Eigen::PartialPivLU<MatrixXcd> factors(bordered);
    const auto sign = static_cast<double>(factors.permutationP().determinant());
    return std::log(Complex(sign)) +
           factors.matrixLU().diagonal().array().log().sum() -
           surplus_outputs_ * std::log(rest);
  }

  VectorXd gains_;
  VectorXd slope_gains_;
  Decomposed model_;
  Decomposed plant_;
  MatrixSeries predictor_;  // Σ K_i c_i
  Eigen::Index degree_;
  MatrixXd sum_;                                       // Σ K_i
  MatrixXd moment_;                                    // Σ i K_i
  Eigen::Array<bool, Eigen::Dynamic, 1> integrating_;  // outputs of the plant
  double surplus_outputs_ = 0.0;                       // s
  VectorXd scale_;                                     // of the outputs
};

// The change of arg D along a circle, halving until neighbours are close enough
// to be told apart.
class PhaseChange {
 public:
  PhaseChange(const Loop& loop, double radius) : loop_(loop), radius_(radius) {}

  // Between two angles.
  double Between(double from, Complex log_from, double to, Complex log_to,
                 int depth = 30) {
    const Complex ratio = log_to - log_from;
    const double change = std::remainder(ratio.imag(), 2.0 * kPi);
    if (std::abs(change) < 0.7 && std::abs(ratio.real()) < std::log(2.5)) {
      return change;
    }
    // D is zero on the circle.
    if (depth == 0) return std::isfinite(change) ? change : 0.0;
    if (halvings_left_-- <= 0) return 0.0;
    const double middle = 0.5 * (from + to);
    const Complex log_D = loop_.LogDeterminant(std::polar(radius_, middle));
    return Between(from, log_from, middle, log_D, depth - 1) +
           Between(middle, log_D, to, log_to, depth - 1);
  }

  // Not where D is mostly rounding, or no number: its argument then jumps
  // everywhere.
  bool is_known() const { return halvings_left_ > 0; }

 private:
  const Loop& loop_;
  double radius_;
  int halvings_left_ = 100'000;
};

// Zeros of D in |w| < radius. D is real on the real axis, so that half the
// circle tells all. FailedPrecondition where D is not known well enough.
absl::StatusOr<int> CountZeros(const Loop& loop, double radius) {
  constexpr Eigen::Index kFewest = 64;
  const int intervals = FastLength(static_cast<int>(std::clamp(
      2 * loop.degree(), kFewest,
      std::max(kMostNumbers / std::max<Eigen::Index>(loop.entries(), 1),
               kFewest))));
  const VectorXcd on_circle =
      loop.LogDeterminantsOnHalfCircle(radius, intervals);
  PhaseChange phase(loop, radius);
  double change = 0.0;
  for (int i = 1; i <= intervals; ++i) {
    change += phase.Between(kPi * (i - 1) / intervals, on_circle(i - 1),
                            kPi * i / intervals, on_circle(i));
  }
  if (!phase.is_known()) {
    return absl::FailedPreconditionError(
        "the loop's modes cannot be counted: in numbers of double precision "
        "nothing is left of its characteristic function; the gains of plant "
        "and controller are too far from each other");
  }
  return static_cast<int>(std::lround(change / kPi));
}

// The smallest |w| of a zero, of those between `low`, below which there is
// none, and `high`; `high` if there is none.
absl::StatusOr<double> SmallestZero(const Loop& loop, double low, double high) {
  MLE_ASSIGN_OR_RETURN(const int zeros, CountZeros(loop, high));
  if (zeros == 0) return high;
  for (int step = 0; step < 30 && high - low > 1e-5; ++step) {
    const double middle = 0.5 * (low + high);
    MLE_ASSIGN_OR_RETURN(const int within, CountZeros(loop, middle));
    (within > 0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

// The largest singular value by MᴴM, whose largest eigenvalue has all digits.
double LargestSingularValue(const MatrixXcd& matrix) {
  if (!matrix.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::SelfAdjointEigenSolver<MatrixXcd> eigen(
      matrix.adjoint() * matrix, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(eigen.eigenvalues().maxCoeff(), 0.0));
}

// The peaks over frequencies up to the Nyquist frequency: on a grid, then finer
// around the largest.
void FindPeaks(const Loop& loop, double control_period,
               LoopAnalysis& analysis) {
  double best = kPi;
  const auto look = [&](const std::vector<double>& angles,
                        const std::vector<MatrixXcd>& all) {
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const MatrixXcd& S = all[k];
      const double peak = LargestSingularValue(S);
      if (peak > analysis.sensitivity_peak) {
        analysis.sensitivity_peak = peak;
        best = angles[k];
      }
      const MatrixXcd T = MatrixXcd::Identity(S.rows(), S.cols()) - S;
      analysis.complementary_peak =
          std::max(analysis.complementary_peak, LargestSingularValue(T));
    }
  };
  // Evenly, by Fourier transforms, and by decades.
  constexpr int kPoints = 300;
  std::vector<double> even;
  for (int i = 1; i <= kPoints; ++i) even.push_back(kPi * i / kPoints);
  look(even, loop.SensitivitiesOnHalfCircle(kPoints));
  // Some at a time: of a large plant all together would not fit into memory.
  constexpr int kTogether = 60;
  for (int first = 0; first < kPoints; first += kTogether) {
    std::vector<double> angles;
    for (int i = first; i < first + kTogether; ++i) {
      angles.push_back(kPi * std::pow(10.0, -4.0 * i / kPoints));
    }
    look(angles, loop.Sensitivities(angles));
  }
  for (double width = kPi / kPoints; width > 1e-7; width *= 0.1) {
    std::vector<double> angles;
    for (int i = -10; i <= 10; ++i) {
      const double angle = best + 0.1 * i * width;
      if (angle > 0.0 && angle <= kPi) angles.push_back(angle);
    }
    look(angles, loop.Sensitivities(angles));
  }
  analysis.peak_frequency = best / control_period;
}

absl::Status CheckLoop(const Mpc& mpc, const PredictionModel& plant) {
  MLE_RETURN_IF_ERROR(plant.Validate());
  const PredictionModel& model = mpc.model();
  if (plant.num_outputs != model.num_outputs || plant.roles != model.roles ||
      !(std::abs(plant.control_period - model.control_period) <=
        1e-9 * model.control_period)) {
    return InvalidArgument(
        "the plant has ", plant.num_outputs, " outputs, ", plant.num_inputs(),
        " inputs and control_period = ", plant.control_period,
        ", the controller ", model.num_outputs, ", ", model.num_inputs(),
        " and ", model.control_period,
        "; these and the inputs' roles must be the same");
  }
  if (mpc.observer().has_model()) {
    return absl::FailedPreconditionError(
        "the controller has a disturbance model; loops with bias filters alone "
        "are analysed");
  }
  const int periods = std::max(plant.periods(), model.periods());
  if (periods > kMostAnalysedPeriods) {
    return InvalidArgument(
        "responses settle only after ", periods,
        " control periods, and loops of up to ", kMostAnalysedPeriods,
        " are analysed; a pair that hardly settles (a small damping, a time "
        "constant far beyond the others) or a short control period makes them "
        "long");
  }
  return absl::OkStatus();
}

}  // namespace

std::string LoopAnalysis::Brief() const {
  if (!stable) {
    return absl::StrFormat("unstable, growing by a factor of %.3g per period",
                           spectral_radius);
  }
  return absl::StrFormat(
      "stable, slowest mode %.3f per period, sensitivity peak %.2f",
      spectral_radius, sensitivity_peak);
}

absl::StatusOr<LoopAnalysis> AnalyseLoop(const Mpc& mpc,
                                         const PredictionModel& plant,
                                         bool find_fastest) {
  MLE_RETURN_IF_ERROR(CheckLoop(mpc, plant));
  const Loop loop(mpc, plant);
  LoopAnalysis analysis;
  MLE_ASSIGN_OR_RETURN(analysis.growing_modes, CountZeros(loop, 1.0 - kMargin));
  analysis.stable = analysis.growing_modes == 0;
  const double slowest_observer = loop.slowest_observer();
  if (!analysis.stable) {
    analysis.spectral_radius = std::numeric_limits<double>::infinity();
    if (find_fastest) {
      MLE_ASSIGN_OR_RETURN(const double smallest,
                           SmallestZero(loop, 0.0, 1.0 - kMargin));
      analysis.spectral_radius = 1.0 / smallest;
    }
    return analysis;
  }
  // Beyond the plant's own decay the cut-off ends of its responses would be
  // taken for modes.
  const double degree = static_cast<double>(loop.degree());
  double high = std::pow(10.0, 3.0 / std::max(degree, 10.0));
  if (slowest_observer > 0.0) {
    high = std::min(high, 0.999 / slowest_observer);
  }
  if (loop.surplus_inputs() > 0 || high <= 1.0) {
    analysis.spectral_radius = 1.0;
  } else {
    MLE_ASSIGN_OR_RETURN(const double smallest,
                         SmallestZero(loop, 1.0 - kMargin, high));
    analysis.spectral_radius = 1.0 / smallest;
  }
  FindPeaks(loop, mpc.model().control_period, analysis);
  return analysis;
}

}  // namespace mle::control
