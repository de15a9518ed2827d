#include "mle/explain/output_competition.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/QR"
#include "mle/base/status.h"
#include "mle/explain/feedback.h"
#include "mle/explain/held_out_errors.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Candidates that are estimated after the first look.
constexpr int kEstimated = 6;
// Exchanges at most, and by how many M one has to do better.
constexpr int kRounds = 4;
constexpr double kBetter = 0.5;
// Directions nearer than this to those of what was taken are none of their own.
constexpr double kLeastOwn = 0.05;
// Rivals that are nearer than this share of N are ties.
constexpr double kTie = 0.1;
// Evidence of two explanations at once, in that of one.
constexpr double kPair = 2.0;
// Placebos nearer to each other than this many τ are not independent.
constexpr double kIndependent = 3.0;
constexpr double kFewestIndependent = 2.0;
// More evidence where inputs stand for set points.
constexpr double kWithoutSetPoints = 2.0;
// The evidence of one hypothesis, which is not the best of a table: 5 %.
constexpr double kExpected = 3.0;
// An energy below this share of the model's is rounding: no placebo shows
// anything.
constexpr double kRounding = 1e-20;

std::vector<Explanation> Without(const std::vector<Explanation>& from,
                                 std::size_t i) {
  std::vector<Explanation> others = from;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
  return others;
}

// Whether θ = 0 is that nothing has happened.
bool HasNothing(ExplanationKind kind) {
  return kind != ExplanationKind::kRateLimit &&
         kind != ExplanationKind::kReversed;
}

}  // namespace

absl::StatusOr<std::unique_ptr<OutputCompetition>> OutputCompetition::Create(
    const ProcessModel& model, const std::vector<Record>& records, int output,
    std::shared_ptr<const FilledInputs> inputs, const ExplainOptions& options) {
  MLE_ASSIGN_OR_RETURN(
      ExplainedOutput explained,
      ExplainedOutput::Create(model, records, output, std::move(inputs)));
  MLE_ASSIGN_OR_RETURN(Instruments instruments,
                       Instruments::Create(model, explained));
  std::unique_ptr<OutputCompetition> competition(new OutputCompetition(
      std::move(explained), std::move(instruments), options));
  const ExplainedOutput& made = competition->output_;
  const VectorXd residual = made.Residual({});
  if (!competition->instruments_.by_set_points()) {
    competition->feedback_p_value_ =
        FeedbackPValue(made, competition->instruments_.Undriven(residual));
    competition->options_.evidence *= kWithoutSetPoints;
  }
  competition->independent_ =
      std::max(kFewestIndependent,
               static_cast<double>(made.rows().size()) * made.samples_a_row() *
                   made.sample_time() / (kIndependent * made.tau()));
  competition->rounding_ =
      kRounding * (1.0 + (made.Measured() - residual).squaredNorm());
  competition->initial_energy_ = competition->Energy({});
  return competition;
}

double OutputCompetition::Energy(
    const std::vector<Explanation>& explanations) const {
  return projected_(explanations).squaredNorm();
}

MatrixXd OutputCompetition::Jacobian(
    const std::vector<Explanation>& explanations) const {
  return JacobianOf(output_, std::cref(projected_), explanations,
                    projected_(explanations));
}

OutputCompetition::Fit OutputCompetition::Estimate(
    std::vector<Explanation> explanations) const {
  return FitExplanations(output_, std::cref(projected_),
                         std::move(explanations));
}

double OutputCompetition::Score(const std::vector<Explanation>& explanations,
                                double energy, double chance) const {
  for (const Explanation& one : explanations) {
    energy += TypeOf(one.kind).improbability * chance;
  }
  return energy;
}

std::vector<OutputCompetition::Fit> OutputCompetition::Candidates(
    const std::vector<Explanation>& taken, double chance,
    MatrixXd& directions) const {
  std::vector<Fit> looks;
  std::vector<VectorXd> tried;
  const VectorXd at = projected_(taken);
  for (const Explanation& one : output_.Applicable(taken)) {
    if (Contains(taken, one)) continue;
    // A path to inputs that answer the output looks like a new one from them.
    if (one.kind == ExplanationKind::kNewPath &&
        !instruments_.by_set_points() && !OpenLoop()) {
      continue;
    }
    const auto [lower, upper] = output_.Bounds(one);
    Fit best;
    best.score = std::numeric_limits<double>::infinity();
    for (const int part : output_.PartsOf(one.kind)) {
      for (const double start : TypeOf(one.kind).start) {
        if (start < lower || start > upper) continue;
        std::vector<Explanation> with = taken;
        with.push_back(one);
        with.back().value = start;
        with.back().part = part;
        const VectorXd value = projected_(with);
        if (!value.allFinite()) continue;
        const VectorXd change = value - at;
        tried.push_back(change);
        double energy = value.squaredNorm();
        // Between nothing and the start, to first order.
        const double share = -at.dot(change) / change.squaredNorm();
        if (HasNothing(one.kind) && share > 0.0 && share < 1.0) {
          with.back().value = share * start;
          energy = (at + share * change).squaredNorm();
        }
        const double score = Score(with, energy, chance);
        if (score < best.score) best = {with, energy, score};
      }
    }
    if (std::isfinite(best.score)) looks.push_back(std::move(best));
  }
  const auto by_score = [](const Fit& a, const Fit& b) {
    return a.score < b.score;
  };
  std::stable_sort(looks.begin(), looks.end(), by_score);
  if (looks.size() > kEstimated) looks.resize(kEstimated);
  for (Fit& fit : looks) {
    fit = Estimate(fit.explanations);
    fit.score = Score(fit.explanations, fit.energy, chance);
  }
  std::stable_sort(looks.begin(), looks.end(), by_score);
  // Directions free of those in which what was taken moves.
  MatrixXd own(at.size(), 0);
  if (!taken.empty()) {
    const MatrixXd J = Jacobian(taken);
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(J);
    own = MatrixXd(qr.householderQ()).leftCols(qr.rank());
  }
  directions.resize(at.size(), 0);
  for (const VectorXd& change : tried) {
    const double length = change.norm();
    if (!(length > 0.0)) continue;
    const VectorXd free = (change - own * (own.transpose() * change)) / length;
    if (free.norm() < kLeastOwn) continue;
    directions.conservativeResize(Eigen::NoChange, directions.cols() + 1);
    directions.rightCols(1) = free.normalized();
  }
  return looks;
}

double OutputCompetition::EvidenceOf(double fall, double unit) const {
  OutputExplanation report;
  report.independent = independent_;
  report.unit = unit;
  return report.EvidenceOf(fall);
}

bool OutputCompetition::OpenLoop() const {
  return feedback_p_value_.has_value() && *feedback_p_value_ >= kFeedback;
}

double OutputCompetition::EvidenceFor(const Explanation& explanation) const {
  const bool expected = OpenLoop() && options_.expected.size() > 0 &&
                        IsAgeing(explanation.kind) &&
                        options_.expected(output_.output(), explanation.index);
  return PriorCost(explanation) +
         (expected ? EvidenceOfOne() : options_.evidence);
}

double OutputCompetition::EvidenceOfOne() const {
  return std::min(kExpected, options_.evidence);
}

OutputCompetition::Chance OutputCompetition::ChanceOf(
    const Fit& fit, const MatrixXd& directions) const {
  return ChanceOf(output_.Residual(fit.explanations), directions);
}

OutputCompetition::Chance OutputCompetition::ChanceOf(
    const VectorXd& residual, const MatrixXd& directions) const {
  const MatrixXd placebos = instruments_.ProjectPlacebos(residual);
  VectorXd energies = placebos.rowwise().squaredNorm();
  Chance chance;
  if (directions.cols() > 0) {
    chance.unit =
        (placebos * directions).array().square().rowwise().maxCoeff().mean();
  }
  std::sort(energies.begin(), energies.end());
  const Index n = energies.size();
  chance.energy = 0.5 * (energies[(n - 1) / 2] + energies[n / 2]);
  chance.energy = std::max(chance.energy, rounding_);
  chance.unit = std::max(chance.unit, rounding_);
  return chance;
}

std::optional<OutputCompetition::Next> OutputCompetition::BestNext(
    const std::vector<Explanation>& taken) {
  // Improbabilities are in units of what chance makes of the best.
  std::vector<Fit> fits = Candidates(taken, 0.0, directions_);
  if (fits.empty()) return std::nullopt;
  const Chance of_best = ChanceOf(fits.front(), directions_);
  for (Fit& fit : fits) {
    fit.score = Score(fit.explanations, fit.energy, CostOf(of_best.energy));
  }
  const auto best = std::min_element(
      fits.begin(), fits.end(),
      [](const Fit& a, const Fit& b) { return a.score < b.score; });
  return Next{*best, ChanceOf(*best, directions_).unit};
}

void OutputCompetition::Forward(const std::vector<Explanation>& given) {
  const Fit start = Estimate(given);
  std::vector<Explanation> taken = start.explanations;
  double energy = start.energy;
  std::vector<double> evidences(taken.size(), 0.0);
  next_.clear();
  const auto most = static_cast<std::size_t>(options_.most);
  while (taken.size() < most) {
    std::optional<Next> next = BestNext(taken);
    if (!next.has_value()) break;
    double evidence = EvidenceOf(energy - next->fit.energy, next->unit);
    if (!(evidence > EvidenceFor(next->fit.explanations.back()))) {
      next_ = {{next->fit.explanations.back(), 0.0, evidence}};
      // Two may hide each other: what one leaves is in what chance makes.
      const double chance = ChanceOf({taken, energy, 0.0}, directions_).energy;
      if (!(energy > kMuchLeft * chance) || taken.size() + 2 > most) break;
      next = BestNext(next->fit.explanations);
      if (!next.has_value()) break;
      evidence = EvidenceOf(energy - next->fit.energy, next->unit);
      if (!(evidence > kPair * options_.evidence)) break;
    }
    const Fit fit = InBestShape(next->fit, next->unit);
    taken = fit.explanations;
    energy = fit.energy;
    evidences.resize(taken.size(), evidence);
  }
  taken_.clear();
  for (std::size_t i = 0; i < taken.size(); ++i) {
    taken_.push_back({taken[i], 0.0, evidences[i]});
  }
  energy_ = energy;
  const Chance last = ChanceOf({taken, energy, 0.0}, directions_);
  chance_ = last.energy;
  unit_ = last.unit;
}

void OutputCompetition::Backward(std::size_t given) {
  bool left = true;
  while (left && taken_.size() > 1) {
    left = false;
    const std::vector<Explanation> all = Explanations();
    for (std::size_t i = given; i + 1 < taken_.size(); ++i) {
      const Fit without = Estimate(Without(all, i));
      if (EvidenceOf(without.energy - energy_, unit_) > EvidenceFor(all[i])) {
        continue;
      }
      taken_.erase(taken_.begin() + static_cast<std::ptrdiff_t>(i));
      for (std::size_t k = 0; k < taken_.size(); ++k) {
        taken_[k].explanation = without.explanations[k];
      }
      energy_ = without.energy;
      left = true;
      break;
    }
  }
}

bool OutputCompetition::Exchange(std::size_t given) {
  const std::vector<Explanation> all = Explanations();
  const double score = Score(all, energy_, CostOf(chance_));
  for (std::size_t i = given; i < all.size(); ++i) {
    MatrixXd directions;
    const std::vector<Fit> fits =
        Candidates(Without(all, i), CostOf(chance_), directions);
    if (fits.empty() || fits.front().explanations.back().SameAs(all[i]) ||
        fits.front().score > score - kBetter * unit_) {
      continue;
    }
    taken_.clear();
    for (const Explanation& one : fits.front().explanations) {
      taken_.push_back({one, 0.0, 0.0});
    }
    energy_ = fits.front().energy;
    return true;
  }
  return false;
}

void OutputCompetition::FindTies() {
  const std::vector<Explanation> all = Explanations();
  const double score = Score(all, energy_, CostOf(chance_));
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool curved = IsCurve(all[i].kind);
    const bool changed =
        curved || all[i].kind == ExplanationKind::kChangeDuringRecord;
    if (!IsAgeing(all[i].kind) && !changed) continue;
    MatrixXd directions;
    for (const Fit& look :
         Candidates(Without(all, i), CostOf(chance_), directions)) {
      const Explanation& found = look.explanations.back();
      if (found.SameAs(all[i]) || (curved && IsCurve(found.kind))) continue;
      const Fit fit = InBestShape(look, unit_);
      const Explanation& rival = fit.explanations.back();
      const bool elements = changed || IsAgeing(rival.kind);
      // Explanations of one element, or its input, do much the same; but a
      // curve is no change.
      if (!changed && TypeOf(rival.kind).place != ExplanationPlace::kOutput &&
          rival.index == all[i].index) {
        continue;
      }
      const double near =
          elements ? kRivalMargin * unit_ : kTie * CostOf(chance_);
      // A curve that explains more, its improbability aside, is one, too.
      const bool more =
          IsCurve(rival.kind) && fit.energy < energy_ - kBetter * unit_;
      const double margin =
          Score(fit.explanations, fit.energy, CostOf(chance_)) - score;
      if (more || margin < near) {
        ties_.push_back({all[i], rival, margin / unit_});
      }
    }
  }
}

void OutputCompetition::Compete(const std::vector<Explanation>& given) {
  ties_.clear();
  together_ = false;
  held_out_.clear();
  Forward(given);
  Backward(given.size());
  for (int round = 0; round < kRounds && Exchange(given.size()); ++round) {
    Forward(Explanations());
    Backward(given.size());
  }
  const Chance last = ChanceOf({Explanations(), energy_, 0.0}, directions_);
  chance_ = last.energy;
  unit_ = last.unit;
  FindTies();
  HoldOut();
  FitTogether();
  TakeForClock();
  // Explanations that were given, or that came by exchange, have no evidence
  // yet.
  for (std::size_t i = 0; i < taken_.size(); ++i) {
    if (taken_[i].evidence > 0.0) continue;
    const Fit without = Estimate(Without(Explanations(), i));
    taken_[i].evidence = EvidenceOf(without.energy - energy_, unit_);
  }
}

std::vector<Explanation> OutputCompetition::Explanations() const {
  std::vector<Explanation> explanations;
  for (const TakenExplanation& one : taken_) {
    explanations.push_back(one.explanation);
  }
  return explanations;
}

}  // namespace mle
