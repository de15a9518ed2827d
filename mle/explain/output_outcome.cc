// What is told of an output once the competition is over: whether a dead time
// may be a clock's, standard errors, hold-out validation, ties, and the change
// of a gain that would have shown.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "mle/base/random.h"
#include "mle/data/sampling.h"
#include "mle/explain/curves.h"
#include "mle/explain/held_out_errors.h"
#include "mle/explain/output_competition.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The share of a sample by which means of what lies between samples shift it,
// with what they seem to.
constexpr double kMostOfSample = 0.75;
constexpr int kStampDraws = 32;

}  // namespace

// The dead time of the only element is as well a clock's, by what averages
// between samples that are measured make it.
void OutputCompetition::TakeForClock() {
  if (output_.inputs().size() != 1) return;
  const int every = MeasuredEvery(output_.records(), output_.output());
  const double most =
      (every > 1 ? every : kMostOfSample) * output_.sample_time();
  const ElementValues& before = output_.values(output_.inputs().front());
  const double change =
      output_.Aged(output_.inputs().front(), Explanations()).delay -
      before.delay;
  for (TakenExplanation& one : taken_) {
    if (!one.explanation.SameAs(
            {ExplanationKind::kDeadTime, output_.inputs().front()}) ||
        !(std::abs(change) <= most)) {
      continue;
    }
    one.explanation = {ExplanationKind::kOutputClock, output_.output(),
                       change / (0.5 * output_.tau())};
  }
}

void OutputCompetition::HoldOut() {
  held_out_.clear();
  if (taken_.empty()) return;
  held_out_ =
      HeldOutErrors(output_, instruments_, [this](const VectorXd& weights) {
        const ProjectedResidual kept(output_,
                                     instruments_.ProjectionOf(weights));
        return FitExplanations(output_, std::cref(kept), Explanations())
            .explanations;
      });
}

OutputCompetition::Fit OutputCompetition::WithShapeOf(
    const std::vector<Explanation>& explanations, const Explanation& curve,
    int part) const {
  Fit best;
  best.energy = std::numeric_limits<double>::infinity();
  for (const Explanation& start : InShape(curve, part)) {
    std::vector<Explanation> others = explanations;
    for (Explanation& one : others) {
      if (one.SameAs(curve)) one = start;
    }
    Fit fit = Estimate(std::move(others));
    if (fit.energy < best.energy) best = std::move(fit);
  }
  return best;
}

OutputCompetition::Fit OutputCompetition::InBestShape(const Fit& fit,
                                                      double unit) const {
  const Explanation curve = fit.explanations.back();
  if (!IsCurve(curve.kind)) return fit;
  Fit best;
  double left = std::numeric_limits<double>::infinity();
  for (const int part : ShapesOf(curve.kind)) {
    Fit other = WithShapeOf(fit.explanations, curve, part);
    const double cost = ShapeCost(part) * unit;
    if (!(other.energy + cost < left)) continue;
    left = other.energy + cost;
    best = std::move(other);
  }
  return best.explanations.empty() ? fit : best;
}

void OutputCompetition::TakeShape(
    const ExplanationFit& fit, const Explanation& curve,
    const std::vector<Explanation>& alternatives) {
  bool changed = false;
  for (std::size_t i = 0; i < taken_.size(); ++i) {
    Explanation& taken = taken_[i].explanation;
    changed = changed || taken.part != fit.explanations[i].part;
    taken = fit.explanations[i];
    if (taken.SameAs(curve)) taken_[i].alternatives = alternatives;
  }
  energy_ = fit.energy;
  if (changed) HoldOut();
}

MatrixXd OutputCompetition::CovarianceOfTheta() const {
  if (together_) return covariance_together_;
  const std::vector<Explanation> explanations = Explanations();
  const auto n = static_cast<Index>(explanations.size());
  if (n == 0) return MatrixXd(0, 0);
  const MatrixXd placebos =
      instruments_.ProjectPlacebos(output_.Residual(explanations));
  const MatrixXd C =
      placebos.transpose() * placebos / static_cast<double>(placebos.rows());
  const MatrixXd J = Jacobian(explanations);
  MatrixXd H = J.transpose() * J;
  H.diagonal().array() += 1e-12 * std::max(H.diagonal().maxCoeff(), 1e-300);
  const MatrixXd A = H.ldlt().solve(J.transpose());
  const VectorXd kept = KeptByPlacebos(explanations, A);
  return kept.cwiseInverse().asDiagonal() * A * C * A.transpose() *
         kept.cwiseInverse().asDiagonal();
}

// An estimate takes its error's share from the placebos, too, where set points
// moved in time are like themselves (moves in a regular turn): of θ_i the share
// ρ_s = A_i Q_sᵀ ∂e/∂θ_i of placebo s, which leaves 1 − ρ_s² of its variance.
// The roots of the means of what is left.
VectorXd OutputCompetition::KeptByPlacebos(
    const std::vector<Explanation>& explanations, const MatrixXd& A) const {
  constexpr double kLeastKept = 0.1;
  const MatrixXd moved = JacobianOf(
      output_,
      [this](const std::vector<Explanation>& at) {
        return output_.Residual(at);
      },
      explanations, output_.Residual(explanations));
  VectorXd kept(A.rows());
  for (Index i = 0; i < A.rows(); ++i) {
    const VectorXd shares =
        instruments_.ProjectPlacebos(moved.col(i)) * A.row(i).transpose();
    const double left = 1.0 - shares.array().square().cwiseMin(1.0).mean();
    kept[i] = std::sqrt(std::max(left, kLeastKept));
  }
  return kept;
}

Eigen::Matrix3d OutputCompetition::Covariance(int input) const {
  const std::vector<Explanation> explanations = Explanations();
  const MatrixXd covariance = CovarianceOfTheta();
  const ElementValues aged = output_.Aged(input, explanations);
  const ElementValues values = output_.Before(input, explanations);
  const double lag = output_.has_lag(input) ? values.time_scale : 0.0;
  const double at_end = GainAtEnd(explanations, input);
  // ∂(K, T, L)/∂θ.
  MatrixXd by = MatrixXd::Zero(3, covariance.cols());
  for (std::size_t i = 0; i < explanations.size(); ++i) {
    const Explanation& one = explanations[i];
    const auto column = static_cast<Index>(i);
    if (one.kind == ExplanationKind::kOutputClock ||
        (one.kind == ExplanationKind::kInputClock && one.index == input)) {
      by(2, column) = 0.5 * output_.tau();
    }
    if (one.index != input) continue;
    if (one.kind == ExplanationKind::kNewPath && one.value != 0.0) {
      by(0, column) = aged.gain / one.value;
    }
    if (one.kind == ExplanationKind::kGain) by(0, column) = aged.gain * at_end;
    if (one.kind == ExplanationKind::kChangeDuringRecord) {
      by(0, column) = aged.gain * ShareOfChange(one.part, 1.0);
    }
    if (one.kind == ExplanationKind::kTimeConstant) {
      by(1, column) = aged.time_scale;
    }
    if (one.kind == ExplanationKind::kDeadTime) {
      by(2, column) = std::max(lag + values.delay, output_.sample_time());
    }
  }
  return by * covariance * by.transpose();
}

double OutputCompetition::Required() const {
  return independent_ * std::expm1(options_.evidence / independent_);
}

OutputExplanation OutputCompetition::Report() const {
  OutputExplanation report;
  report.independent = independent_;
  report.required = Required();
  report.by_set_points = instruments_.by_set_points();
  report.feedback_p_value = feedback_p_value_;
  report.moves = instruments_.moves();
  report.taken = taken_;
  const MatrixXd covariance = CovarianceOfTheta();
  for (std::size_t i = 0; i < taken_.size(); ++i) {
    const auto k = static_cast<Index>(i);
    report.taken[i].standard_error = std::sqrt(std::max(covariance(k, k), 0.0));
  }
  if (!next_.empty()) report.next = next_.front();
  for (const OutputExplanation::Tie& tie : ties_) {
    if (std::any_of(taken_.begin(), taken_.end(),
                    [&](const TakenExplanation& one) {
                      return one.explanation.SameAs(tie.taken);
                    })) {
      report.ties.push_back(tie);
    }
  }
  report.energy = initial_energy_;
  report.remaining = energy_;
  report.chance = chance_;
  report.unit = unit_;
  const auto place = static_cast<std::size_t>(output_.output());
  if (place < options_.averages.size() && options_.averages[place] > 0.0) {
    report.averaging =
        instruments_.Project(output_.LostByAverage(options_.averages[place]))
            .squaredNorm();
  }
  if (place < options_.stamp_errors.size() &&
      options_.stamp_errors[place] > 0.0) {
    GaussianNoise noise(0, kCalibrationStream, kStampErrors);
    const MatrixXd errors = output_.DrawStampErrors(
        options_.stamp_errors[place], kStampDraws, noise);
    for (const auto& one : errors.colwise()) {
      report.stamps += instruments_.Project(one).squaredNorm() / kStampDraws;
    }
  }
  report.together = together_;
  report.held_out = held_out_;
  const Index m = output_.records().front().num_inputs();
  report.detectable.assign(static_cast<std::size_t>(m),
                           std::numeric_limits<double>::infinity());
  const std::vector<Explanation> explanations = Explanations();
  for (const int j : output_.inputs()) {
    std::vector<Explanation> with = explanations;
    const Explanation gain = {ExplanationKind::kGain, j, 0.0};
    std::size_t at = with.size();
    for (std::size_t i = 0; i < with.size(); ++i) {
      if (with[i].SameAs(gain)) at = i;
    }
    if (at == with.size()) with.push_back(gain);
    const double slope = Jacobian(with).col(static_cast<Index>(at)).norm();
    if (slope > 0.0) {
      report.detectable[static_cast<std::size_t>(j)] =
          std::sqrt(Required() * unit_) / slope;
    }
  }
  return report;
}

}  // namespace mle
