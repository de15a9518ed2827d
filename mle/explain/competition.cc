#include "mle/explain/competition.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/explain/curve_shapes.h"
#include "mle/explain/output_competition.h"

namespace mle {
namespace {

// One explanation of an input may leave this much more, in units of M, for each
// parameter that it saves in place of several of its elements.
constexpr double kParameter = 3.0;

// Whether an explanation of input j, of this kind, takes the place of `one`: of
// another explanation of the input, or of one of its elements that it looks
// like.
bool Replaces(ExplanationKind kind, const Explanation& one, int j) {
  using Kind = ExplanationKind;
  if (TypeOf(one.kind).place == ExplanationPlace::kOutput || one.index != j) {
    return false;
  }
  if (TypeOf(one.kind).place == ExplanationPlace::kInput) return true;
  switch (kind) {
    case Kind::kInputClock:
      return one.kind == Kind::kDeadTime;
    case Kind::kRateLimit:
    case Kind::kBacklash:
      return one.kind != Kind::kGain && one.kind != Kind::kReversed;
    default:
      return one.kind == Kind::kGain || one.kind == Kind::kDirection ||
             one.kind == Kind::kChangeDuringRecord;
  }
}

std::vector<Explanation> WithoutReplaced(const std::vector<Explanation>& from,
                                         ExplanationKind kind, int j) {
  std::vector<Explanation> others;
  for (const Explanation& one : from) {
    if (!Replaces(kind, one, j)) others.push_back(one);
  }
  return others;
}

// θ of an explanation of an input, which is in τ of one output, for another.
double ValueFor(const Explanation& one, double tau, double other) {
  switch (one.kind) {
    case ExplanationKind::kInputClock:
      return one.value * tau / other;
    case ExplanationKind::kRateLimit:
      return one.value - std::log(tau / other);
    default:
      return one.value;
  }
}

// The mean of two estimates of one curve, by their precision.
void MeanOf(const FoundCurve& one, FoundCurve& other) {
  const auto weight_of = [](const FoundCurve& curve) {
    return 1.0 / std::max(curve.standard_error * curve.standard_error, 1e-300);
  };
  const double own = weight_of(other);
  const double more = weight_of(one);
  other.curvature =
      (own * other.curvature + more * one.curvature) / (own + more);
  other.standard_error = 1.0 / std::sqrt(own + more);
  other.evidence += one.evidence;
}

using Competitions = std::vector<std::unique_ptr<OutputCompetition>>;

// The outputs that input j reaches, where explanations won one by one.
std::vector<OutputCompetition*> OutputsOf(const Competitions& all, int j) {
  std::vector<OutputCompetition*> outputs;
  for (const auto& competition : all) {
    if (competition == nullptr || competition->together()) continue;
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
        WithoutReplaced(output->Explanations(), one.kind, j);
    explanations.push_back(
        {one.kind, j, ValueFor(one, tau, output->output().tau()), one.part});
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
  Together best = {{type.kind, j, 0.0},
                   EnergyTogether(outputs, j, {type.kind, j, 0.0}, tau)};
  const auto try_value = [&](double value, int part) {
    const Explanation one = {type.kind, j,
                             std::clamp(value, type.lower, type.upper), part};
    const double energy = EnergyTogether(outputs, j, one, tau);
    if (energy < best.energy) best = {one, energy};
  };
  for (const int part : outputs.front()->output().PartsOf(type.kind)) {
    for (const double value : type.start) try_value(value, part);
  }
  double step = 0.5 * std::abs(best.explanation.value);
  for (int i = 0; i < 6; ++i, step *= 0.5) {
    const Explanation center = best.explanation;
    try_value(center.value - step, center.part);
    try_value(center.value + step, center.part);
  }
  return best;
}

// One explanation of an input in place of several of its elements, where it
// explains as much.
void CompeteTogether(const ProcessModel& model, const Competitions& all) {
  for (int j = 0; j < model.num_inputs(); ++j) {
    const std::vector<OutputCompetition*> outputs = OutputsOf(all, j);
    if (outputs.size() < 2) continue;
    double apart = 0.0;
    double tau = 0.0;
    for (const OutputCompetition* output : outputs) {
      apart += output->Energy(output->Explanations()) / output->unit();
      tau = std::max(tau, output->output().tau());
    }
    Together best;
    double most = 0.0;  // what it explains beyond what it has to
    for (const ExplanationType& type : ExplanationTable()) {
      if (type.place != ExplanationPlace::kInput) continue;
      int replaced = 0;
      int touched = 0;
      bool of_input = false;
      for (const OutputCompetition* output : outputs) {
        const std::vector<Explanation> all_of = output->Explanations();
        const auto left = WithoutReplaced(all_of, type.kind, j).size();
        replaced += static_cast<int>(all_of.size() - left);
        touched += left < all_of.size() ? 1 : 0;
        for (const Explanation& one : all_of) {
          of_input = of_input || (one.kind == type.kind && one.index == j);
        }
      }
      if (touched < 2 && !of_input) continue;
      const Together together = BestTogether(outputs, j, type, tau);
      const double explained =
          apart + kParameter * (replaced - 1) - together.energy;
      if (explained > most) {
        best = together;
        most = explained;
      }
    }
    if (!(most > 0.0)) continue;
    for (OutputCompetition* output : outputs) {
      output->Compete({{best.explanation.kind, j,
                        ValueFor(best.explanation, tau, output->output().tau()),
                        best.explanation.part}});
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

double OutputExplanation::EvidenceOf(double fall, double by_unit) const {
  if (!(fall > 0.0) || !(by_unit > 0.0)) return 0.0;
  return independent * std::log1p(fall / (by_unit * independent));
}

bool OutputExplanation::HasTie(const Explanation& explanation) const {
  return std::any_of(ties.begin(), ties.end(), [&](const Tie& tie) {
    return tie.taken.SameAs(explanation);
  });
}

Competition::Competition(Competition&&) noexcept = default;
Competition& Competition::operator=(Competition&&) noexcept = default;
Competition::~Competition() = default;

absl::StatusOr<Competition> Competition::Run(const ProcessModel& model,
                                             std::vector<Record> records,
                                             const ExplainOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  if (records.empty())
    return absl::InvalidArgumentError("there are no records");
  const int p = model.num_outputs();
  Competition competition;
  competition.evidence_ = options.evidence;
  competition.records_ =
      std::make_unique<const std::vector<Record>>(std::move(records));
  competition.competitions_.resize(p);
  competition.results_.resize(p);
  const auto inputs =
      std::make_shared<const FilledInputs>(Fill(*competition.records_));
  ParallelFor(p, options.threads, [&](int i) {
    absl::StatusOr<std::unique_ptr<OutputCompetition>> made =
        OutputCompetition::Create(model, *competition.records_, i, inputs,
                                  options);
    if (!made.ok()) {
      competition.results_[i].unjudged = std::string(made.status().message());
      return;
    }
    (*made)->Compete();
    (*made)->output().ForgetResponses();  // those of all outputs are many
    competition.competitions_[i] = *std::move(made);
  });
  CompeteTogether(model, competition.competitions_);
  ChooseShapes(competition.competitions_);
  ParallelFor(p, options.threads, [&](int i) {
    if (competition.competitions_[i] != nullptr) {
      competition.results_[i] = competition.competitions_[i]->Report();
    }
  });
  return competition;
}

ElementValues Competition::Explained(int output, int input) const {
  const OutputCompetition& competition = *competitions_[output];
  const std::vector<Explanation> explanations = competition.Explanations();
  ElementValues values = competition.output().Aged(input, explanations);
  values.gain *= GainAtEnd(explanations, input);
  return values;
}

absl::StatusOr<TransferFunction> Competition::ElementOf(
    int output, int input, const ElementValues& values) const {
  const OutputCompetition& competition = *competitions_[output];
  return competition.output().ElementOf(input, values,
                                        competition.Explanations());
}

std::vector<FoundCurve> Competition::Curves() const {
  std::vector<FoundCurve> curves;
  for (std::size_t i = 0; i < competitions_.size(); ++i) {
    if (competitions_[i] == nullptr) continue;
    for (const TakenExplanation& one : results_[i].taken) {
      if (!IsCurve(one.explanation.kind)) continue;
      FoundCurve found = competitions_[i]->output().CurveOf(
          one.explanation, one.standard_error, one.alternatives);
      found.evidence = one.evidence;
      const auto same = std::find_if(
          curves.begin(), curves.end(), [&](const FoundCurve& other) {
            return other.is_output == found.is_output &&
                   other.channel == found.channel;
          });
      if (same == curves.end()) {
        curves.push_back(std::move(found));
      } else {
        MeanOf(found, *same);
      }
    }
  }
  std::erase_if(curves, [&](const FoundCurve& curve) {
    return !(curve.evidence > evidence_) ||
           (!curve.is_output && IsContradicted(curve));
  });
  return curves;
}

bool Competition::IsContradicted(const FoundCurve& curve) const {
  for (const auto& competition : competitions_) {
    if (competition == nullptr) continue;
    const ExplainedOutput& output = competition->output();
    std::vector<Explanation> explanations = competition->Explanations();
    const std::vector<int>& inputs = output.inputs();
    if (Contains(explanations, output.InputCurve(curve)) ||
        std::find(inputs.begin(), inputs.end(), curve.channel) ==
            inputs.end()) {
      continue;
    }
    const double before = competition->Energy(explanations);
    explanations.push_back(output.InputCurve(curve));
    if (competition->Energy(explanations) >
        before + kAsMuch * competition->unit()) {
      return true;
    }
  }
  return false;
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
  if (!residual.ok()) {
    return {results_[output].energy, 0.0, results_[output].unit};
  }
  const Eigen::VectorXd other = competition.instruments().Project(*residual);
  const Eigen::VectorXd own =
      competition.instruments().Project(competition.output().Residual({}));
  return {other.squaredNorm(), (other - own).squaredNorm(),
          competition.UnitOf(*residual)};
}

double Competition::EnergyWith(
    int output, const std::vector<Explanation>& explanations) const {
  return competitions_[output]->EnergyWith(explanations);
}

}  // namespace mle
