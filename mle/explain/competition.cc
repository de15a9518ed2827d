#include "mle/explain/competition.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/explain/output_competition.h"

namespace mle {
namespace {

// What a parameter more has to explain, in units of M, where one of an input
// stands beside several of its elements.
constexpr double kParameter = 3.0;

bool AnyTaken(const OutputExplanation& output, bool ageing) {
  return std::any_of(output.taken.begin(), output.taken.end(),
                     [ageing](const TakenExplanation& one) {
                       return IsAgeing(one.explanation.kind) == ageing;
                     });
}

// An explanation of input j, or of its element.
bool IsOf(const Explanation& one, int j) {
  return TypeOf(one.kind).place != ExplanationPlace::kOutput && one.index == j;
}

std::vector<Explanation> WithoutInput(const std::vector<Explanation>& from,
                                      int j) {
  std::vector<Explanation> others;
  for (const Explanation& one : from) {
    if (!IsOf(one, j)) others.push_back(one);
  }
  return others;
}

using Competitions = std::vector<std::unique_ptr<OutputCompetition>>;

// The outputs that input j reaches.
std::vector<OutputCompetition*> OutputsOf(const Competitions& all, int j) {
  std::vector<OutputCompetition*> outputs;
  for (const auto& competition : all) {
    if (competition == nullptr) continue;
    const std::vector<int>& inputs = competition->output().inputs();
    if (std::find(inputs.begin(), inputs.end(), j) != inputs.end()) {
      outputs.push_back(competition.get());
    }
  }
  return outputs;
}

// Σ E/M over the outputs, each with what was taken of other inputs and `one`.
// The clock is in half τ of each output; it is one time for all.
double EnergyTogether(const std::vector<OutputCompetition*>& outputs, int j,
                      Explanation one, double tau) {
  double sum = 0.0;
  for (const OutputCompetition* output : outputs) {
    std::vector<Explanation> explanations =
        WithoutInput(output->Explanations(), j);
    Explanation own = one;
    if (one.kind == ExplanationKind::kInputClock ||
        one.kind == ExplanationKind::kRateLimit) {
      own.value *= tau / output->output().tau();
    }
    explanations.push_back(own);
    sum += output->Energy(explanations) / output->unit();
  }
  return sum;
}

struct Together {
  Explanation explanation;
  double energy = 0.0;
};

// The likeliest θ of one explanation: the best of a grid, refined.
Together BestTogether(const std::vector<OutputCompetition*>& outputs, int j,
                      const ExplanationType& type, double tau) {
  std::vector<double> grid = type.start;
  if (grid.empty()) grid = TypeOf(ExplanationKind::kOutputClock).start;
  Together best = {{type.kind, j, 0.0}, EnergyTogether(outputs, j, {type.kind, j, 0.0}, tau)};
  const auto try_value = [&](double value) {
    const Explanation one = {type.kind, j,
                             std::clamp(value, type.lower, type.upper)};
    const double energy = EnergyTogether(outputs, j, one, tau);
    if (energy < best.energy) best = {one, energy};
  };
  for (const double value : grid) try_value(value);
  double step = 0.5 * std::abs(best.explanation.value);
  for (int i = 0; i < 6; ++i, step *= 0.5) {
    const double center = best.explanation.value;
    try_value(center - step);
    try_value(center + step);
  }
  return best;
}

// One explanation of an input in place of several of its elements, where it
// explains as much.
void CompeteTogether(const ProcessModel& model, const Competitions& all) {
  for (int j = 0; j < model.num_inputs(); ++j) {
    const std::vector<OutputCompetition*> outputs = OutputsOf(all, j);
    if (outputs.size() < 2) continue;
    int parameters = 0;
    int touched = 0;
    double apart = 0.0;
    double tau = 0.0;
    for (const OutputCompetition* output : outputs) {
      int own = 0;
      for (const Explanation& one : output->Explanations()) {
        own += IsOf(one, j) ? 1 : 0;
      }
      parameters += own;
      touched += own > 0 ? 1 : 0;
      apart += output->Energy(output->Explanations()) / output->unit();
      tau = std::max(tau, output->output().tau());
    }
    if (touched < 2) continue;
    Together best;
    best.energy = apart + kParameter * (parameters - 1);
    bool found = false;
    for (const ExplanationType& type : ExplanationTable()) {
      if (type.place != ExplanationPlace::kInput) continue;
      const Together together = BestTogether(outputs, j, type, tau);
      if (together.energy < best.energy) {
        best = together;
        found = true;
      }
    }
    if (!found) continue;
    for (OutputCompetition* output : outputs) {
      std::vector<Explanation> explanations =
          WithoutInput(output->Explanations(), j);
      explanations.push_back(best.explanation);
      if (best.explanation.kind == ExplanationKind::kInputClock ||
          best.explanation.kind == ExplanationKind::kRateLimit) {
        explanations.back().value *= tau / output->output().tau();
      }
      output->Adopt(std::move(explanations));
    }
  }
}

}  // namespace

absl::Status ExplainOptions::Validate() const {
  if (!(evidence > 0.0) || !std::isfinite(evidence)) {
    return absl::InvalidArgumentError(
        absl::StrCat("explain.evidence = ", evidence,
                     ": it must be finite and greater than 0"));
  }
  if (most < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("explain.most = ", most, ": it must be at least 1"));
  }
  return absl::OkStatus();
}

bool OutputExplanation::AnyAgeing() const { return AnyTaken(*this, true); }
bool OutputExplanation::AnyOther() const { return AnyTaken(*this, false); }

Competition::Competition(Competition&&) noexcept = default;
Competition& Competition::operator=(Competition&&) noexcept = default;
Competition::~Competition() = default;

absl::StatusOr<Competition> Competition::Run(
    const ProcessModel& model, const std::vector<Record>& records,
    const ExplainOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (records.empty()) return absl::InvalidArgumentError("there are no records");
  const int p = model.num_outputs();
  Competition competition;
  competition.competitions_.resize(p);
  competition.results_.resize(p);
  ParallelFor(p, options.threads, [&](int i) {
    absl::StatusOr<OutputCompetition> made =
        OutputCompetition::Create(model, records, i, options);
    if (!made.ok()) {
      competition.results_[i].unjudged = std::string(made.status().message());
      return;
    }
    made->Compete();
    competition.competitions_[i] =
        std::make_unique<OutputCompetition>(*std::move(made));
  });
  CompeteTogether(model, competition.competitions_);
  ParallelFor(p, options.threads, [&](int i) {
    if (competition.competitions_[i] != nullptr) {
      competition.results_[i] = competition.competitions_[i]->Report();
    }
  });
  return competition;
}

ElementValues Competition::Explained(int output, int input) const {
  const OutputCompetition& competition = *competitions_[output];
  return competition.output().Aged(input, competition.Explanations());
}

double Competition::ClockOf(int output, int input) const {
  double clock = 0.0;
  for (const Explanation& one : competitions_[output]->Explanations()) {
    if (one.kind == ExplanationKind::kOutputClock ||
        (one.kind == ExplanationKind::kInputClock && one.index == input)) {
      clock += 0.5 * competitions_[output]->output().tau() * one.value;
    }
  }
  return clock;
}

Eigen::Matrix3d Competition::Covariance(int output, int input) const {
  return competitions_[output]->Covariance(input);
}

Competition::Energies Competition::EnergiesOf(int output,
                                              const ProcessModel& model) const {
  const OutputCompetition& competition = *competitions_[output];
  const absl::StatusOr<Eigen::VectorXd> residual =
      competition.output().ResidualOf(model);
  if (!residual.ok()) return {results_[output].energy, 0.0};
  const Eigen::VectorXd other = competition.instruments().Project(*residual);
  const Eigen::VectorXd own =
      competition.instruments().Project(competition.output().Residual({}));
  return {other.squaredNorm(), (other - own).squaredNorm()};
}

}  // namespace mle
