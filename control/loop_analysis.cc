#include "control/loop_analysis.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "Eigen/Eigenvalues"
#include "Eigen/LU"
#include "absl/strings/str_cat.h"
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

// (1 − w) Σ_{a≥1} S_{a−1} w^a = Σ (S_{a−1} − S_{a−2}) w^a, which ends in the
// slopes.
MatrixSeries Differences(const PredictionModel& model,
                         const std::vector<int>& inputs) {
  const int p = model.num_outputs;
  const int n = model.periods();
  const MatrixXd slopes = model.SlopesOf(inputs);
  MatrixSeries result(slopes, n + 1);
  result.SetTerm(1, MatrixXd::Zero(p, slopes.cols()));
  for (Eigen::Index a = 2; a <= n + 1; ++a) {
    result.SetTerm(a, model.responses(Eigen::seqN(p * (a - 1), p), inputs) -
                          model.responses(Eigen::seqN(p * (a - 2), p), inputs));
  }
  result.Trim();
  return result;
}

// The loop's transfer matrices, times 1 − w where they have a pole at w = 1.
class Loop {
 public:
  Loop(const Mpc& mpc, const PredictionModel& plant)
      : gains_(mpc.observer().gains()),
        slope_gains_(mpc.observer().slope_gains()),
        manipulated_(mpc.model().InputsOf(InputRole::kManipulated)),
        model_(Differences(mpc.model(), manipulated_)),
        plant_(Differences(plant, manipulated_)),
        predictor_(Predictor(mpc)),
        degree_(
            std::max({model_.degree(), plant_.degree(), predictor_.degree()})) {
    const int p = mpc.model().num_outputs;
    sum_ = MatrixXd::Zero(mpc.gain().rows(), p);
    moment_ = sum_;
    for (Eigen::Index i = 0; i < mpc.gain().cols(); i += p) {
      const auto block = mpc.gain().middleCols(i, p);
      sum_ += block;
      moment_ += static_cast<double>(i / p + 1) * block;
    }
    const MatrixXd slopes = plant.SlopesOf(manipulated_);
    for (const auto& row : slopes.rowwise()) ramps_ += row.isZero(0.0) ? 0 : 1;
    ramps_ = std::min(ramps_, static_cast<int>(sum_.rows()));
    scale_ = mpc.options().output_weight.diagonal().cwiseSqrt();
    for (double& value : scale_) {
      if (value == 0.0) value = 1.0;
    }
  }

  Eigen::Index degree() const { return degree_; }
  Eigen::Index entries() const {
    return predictor_.entries() + model_.entries() + plant_.entries();
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

  // Of which the zeros are the loop's modes.
  Complex Determinant(Complex w) const {
    const VectorXcd powers = Powers(w);
    return Determinant(w, predictor_(powers), model_(powers), plant_(powers));
  }
  // At r e^{iπk/n}, k = 0 … n.
  VectorXcd DeterminantsOnHalfCircle(double radius, int n) const {
    const MatrixXcd predictor = predictor_.OnHalfCircle(radius, n);
    const MatrixXcd model = model_.OnHalfCircle(radius, n);
    const MatrixXcd plant = plant_.OnHalfCircle(radius, n);
    VectorXcd values(n + 1);
    for (int k = 0; k <= n; ++k) {
      values(k) = Determinant(std::polar(radius, kPi * k / n),
                              predictor_.Column(predictor, k),
                              model_.Column(model, k), plant_.Column(plant, k));
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
    const MatrixXcd model = model_.AtAll(powers);
    const MatrixXcd plant = plant_.AtAll(powers);
    std::vector<MatrixXcd> sensitivities;
    for (Eigen::Index k = 0; k < count; ++k) {
      sensitivities.push_back(
          Sensitivity(powers(0, k), predictor_.Column(predictor, k),
                      model_.Column(model, k), plant_.Column(plant, k)));
    }
    return sensitivities;
  }
  // S at e^{iπk/n}, k = 1 … n: the conjugates of those at e^{−iπk/n}.
  std::vector<MatrixXcd> SensitivitiesOnHalfCircle(int n) const {
    const MatrixXcd predictor = predictor_.OnHalfCircle(1.0, n);
    const MatrixXcd model = model_.OnHalfCircle(1.0, n);
    const MatrixXcd plant = plant_.OnHalfCircle(1.0, n);
    std::vector<MatrixXcd> sensitivities;
    for (int k = 1; k <= n; ++k) {
      sensitivities.push_back(Sensitivity(
          std::polar(1.0, kPi * k / n), predictor_.Column(predictor, k),
          model_.Column(model, k), plant_.Column(plant, k)));
    }
    return sensitivities;
  }

 private:
  // (1 − w) Σ_i K_i F_i = Σ (G_a − G_{a−1}) w^a, G_a = Σ_i K_i S_{a+i−1}: that
  // of the model's differences i ahead but for the first, which is G_1.
  MatrixSeries Predictor(const Mpc& mpc) const {
    PredictionModel model = mpc.model();
    const int p = model.num_outputs;
    const Eigen::Index rows = mpc.gain().cols();
    model.ReachTo(static_cast<int>(rows) / p);
    MatrixSeries result = model_.Ahead(mpc.gain());
    result.SetTerm(
        1, mpc.gain() * model.responses(Eigen::seqN(p, rows), manipulated_));
    result.Trim();
    return result;
  }

  VectorXcd Powers(Complex w) const {
    VectorXcd powers(degree_);
    Complex power = 1.0;
    for (Complex& value : powers) value = power *= w;
    return powers;
  }

  // V = Σ K_i W_i.
  MatrixXcd Feedback(Complex w) const {
    const Complex rest = 1.0 - w;
    MatrixXcd result(sum_.rows(), sum_.cols());
    for (Eigen::Index o = 0; o < sum_.cols(); ++o) {
      const double kept = 1.0 - gains_[o];
      if (slope_gains_[o] == 0.0) {
        result.col(o) = gains_[o] / (1.0 - kept * w) * sum_.col(o);
        continue;
      }
      const Complex pole = 1.0 - std::sqrt(kept) * w;
      const Complex innovation = rest / (pole * pole);
      result.col(o) = (1.0 - kept * rest * innovation) * sum_.col(o) +
                      slope_gains_[o] * innovation * moment_.col(o);
    }
    return result;
  }

  // (1 − w)(I + Σ K_i F_i − V F_0).
  MatrixXcd Controller(Complex w, const MatrixXcd& predictor,
                       const MatrixXcd& model) const {
    MatrixXcd result = predictor - Feedback(w) * model;
    result.diagonal().array() += 1.0 - w;
    return result;
  }
  MatrixXcd Sensitivity(Complex w, const MatrixXcd& predictor,
                        const MatrixXcd& model, const MatrixXcd& plant) const {
    const MatrixXcd PC =
        plant *
        Controller(w, predictor, model).partialPivLu().solve(Feedback(w));
    const Eigen::Index p = PC.rows();
    const MatrixXcd S = (MatrixXcd::Identity(p, p) + PC).inverse();
    return scale_.asDiagonal() * S * scale_.cwiseInverse().asDiagonal();
  }
  Complex Determinant(Complex w, const MatrixXcd& predictor,
                      const MatrixXcd& model, const MatrixXcd& plant) const {
    return std::pow(1.0 - w, ramps_) *
           (Controller(w, predictor, model) + Feedback(w) * plant)
               .determinant();
  }

  VectorXd gains_;
  VectorXd slope_gains_;
  std::vector<int> manipulated_;
  MatrixSeries model_;      // (1 − w) F_0
  MatrixSeries plant_;      // (1 − w) P
  MatrixSeries predictor_;  // (1 − w) Σ K_i F_i
  Eigen::Index degree_;
  MatrixXd sum_;     // K̄
  MatrixXd moment_;  // Σ i K_i
  int ramps_ = 0;    // outputs of the plant that end in one, up to m_c
  VectorXd scale_;   // of the outputs
};

// The change of arg D between two angles on a circle, halving until neighbours
// are close enough to be told apart.
double PhaseChange(const Loop& loop, double radius, double from, Complex D_from,
                   double to, Complex D_to, int depth) {
  const Complex ratio = D_to / D_from;
  const double change = std::arg(ratio);
  const double size = std::abs(ratio);
  if (depth == 0 || (std::abs(change) < 0.7 && size > 0.4 && size < 2.5)) {
    return std::isfinite(change) ? change : 0.0;
  }
  const double middle = 0.5 * (from + to);
  const Complex D = loop.Determinant(std::polar(radius, middle));
  return PhaseChange(loop, radius, from, D_from, middle, D, depth - 1) +
         PhaseChange(loop, radius, middle, D, to, D_to, depth - 1);
}

// Zeros of D in |w| < radius. D is real on the real axis, so that half the
// circle tells all.
int CountZeros(const Loop& loop, double radius) {
  constexpr Eigen::Index kFewest = 64;
  const int intervals = FastLength(static_cast<int>(
      std::clamp(2 * loop.degree(), kFewest,
                 std::max(kMostNumbers / loop.entries(), kFewest))));
  const VectorXcd on_circle = loop.DeterminantsOnHalfCircle(radius, intervals);
  double change = 0.0;
  for (int i = 1; i <= intervals; ++i) {
    change +=
        PhaseChange(loop, radius, kPi * (i - 1) / intervals, on_circle(i - 1),
                    kPi * i / intervals, on_circle(i), 30);
  }
  return static_cast<int>(std::lround(change / kPi));
}

// The smallest |w| of a zero, of those between `low`, below which there is
// none, and `high`; `high` if there is none.
double SmallestZero(const Loop& loop, double low, double high, int spared) {
  if (CountZeros(loop, high) <= spared) return high;
  for (int step = 0; step < 30 && high - low > 1e-5; ++step) {
    const double middle = 0.5 * (low + high);
    (CountZeros(loop, middle) > spared ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

// Of MᴴM: the largest eigenvalue has all digits.
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
      std::abs(plant.control_period - model.control_period) >
          1e-9 * model.control_period) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the plant has ", plant.num_outputs, " outputs, ", plant.num_inputs(),
        " inputs and control_period = ", plant.control_period,
        ", the controller ", model.num_outputs, ", ", model.num_inputs(),
        " and ", model.control_period,
        "; these and the inputs' roles must be the same"));
  }
  const int periods = std::max(plant.periods(), model.periods());
  if (periods > kMostAnalysedPeriods) {
    return absl::InvalidArgumentError(absl::StrCat(
        "responses settle only after ", periods,
        " control periods, and loops of up to ", kMostAnalysedPeriods,
        " are analysed; a pair that hardly settles (a small damping, a time "
        "constant far beyond the others) or a short control period makes them "
        "long"));
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
  analysis.growing_modes = CountZeros(loop, 1.0 - kMargin);
  analysis.stable = analysis.growing_modes == 0;
  const double slowest_observer = loop.slowest_observer();
  if (!analysis.stable) {
    analysis.spectral_radius =
        find_fastest ? 1.0 / SmallestZero(loop, 0.0, 1.0 - kMargin, 0)
                     : std::numeric_limits<double>::infinity();
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
    analysis.spectral_radius = 1.0 / SmallestZero(loop, 1.0 - kMargin, high, 0);
  }
  FindPeaks(loop, mpc.model().control_period, analysis);
  return analysis;
}

}  // namespace mle::control
