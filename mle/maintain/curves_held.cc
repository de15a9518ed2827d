#include "mle/maintain/curves_held.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/data/linearise.h"
#include "mle/maintain/explained.h"

namespace mle {
namespace {

// Points of two transforms one after the other.
constexpr int kPoints = 65;
// Where in the range visited gains are told.
constexpr double kLow = 0.1;
constexpr double kHigh = 0.9;

// What the output has taken of this curve, or nothing.
const TakenExplanation* TakenOf(const OutputExplanation& output,
                                const FoundCurve& curve) {
  for (const TakenExplanation& one : output.taken) {
    const ExplanationKind kind = one.explanation.kind;
    if (IsCurve(kind) && one.explanation.index == curve.channel &&
        (kind != ExplanationKind::kCurvedInput) == curve.is_output) {
      return &one;
    }
  }
  return nullptr;
}

// By how many M other explanations do worse than a curve that was taken; 0
// where one does better.
double MarginOf(const OutputExplanation& output, const Explanation& curve) {
  double margin = kRivalMargin;
  for (const OutputExplanation::Tie& tie : output.ties) {
    if (tie.taken.SameAs(curve)) margin = std::min(margin, tie.margin);
  }
  return std::max(0.0, margin);
}

// `second` of what `first` makes of x, for x from `low` to `high`.
Transform Composed(const Transform& first, const Transform& second, double low,
                   double high) {
  Transform both;
  both.kind = TransformKind::kPiecewiseLinear;
  both.at = first.at;
  for (int i = 0; i < kPoints; ++i) {
    const double x = low + (high - low) * i / (kPoints - 1.0);
    both.points.emplace_back(x, second.Linear(first.Linear(x)));
  }
  return both;
}

// The element's numerator times `factor`.
void Scale(double factor, TransferFunction& element) {
  std::vector<double> numerator = element.numerator();
  for (double& b : numerator) b *= factor;
  element = TransferFunction(std::move(numerator), element.denominator(),
                             element.delay());
}

void AddCurve(const FoundCurve& curve, ProcessModel& model) {
  const Transform own = curve.AsTransform();
  const Transform given = curve.is_output
                              ? model.outputs()[curve.channel].transform
                              : model.inputs()[curve.channel].transform;
  Transform both = own;
  double slope = 1.0;  // of `both` at its operating point, if it is composed
  if (!given.IsNone()) {
    both = Composed(given, own, given.Engineering(curve.low),
                    given.Engineering(curve.high));
    slope = own.Slope(given.at);
  }
  if (curve.is_output) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      TransferFunction& element = model.element(curve.channel, j);
      if (!element.IsZero() && slope != 1.0) Scale(1.0 / slope, element);
    }
    model.set_output_transform(curve.channel, std::move(both));
    return;
  }
  for (int i = 0; i < model.num_outputs(); ++i) {
    TransferFunction& element = model.element(i, curve.channel);
    if (!element.IsZero() && slope != 1.0) Scale(slope, element);
  }
  model.set_input_transform(curve.channel, std::move(both));
}

absl::Status Change(const ProcessModel& from, const ProcessModel& to,
                    Record& record) {
  Delinearise(from, record);
  return Linearise(to, record);
}

}  // namespace

std::vector<FoundCurve> CurvesToHold(const Candidates& candidates) {
  if (!candidates.competition.has_value() || candidates.options.in_use ||
      !candidates.data.obstacles.empty()) {
    return {};
  }
  const Competition& competition = *candidates.competition;
  std::vector<FoundCurve> held;
  for (const FoundCurve& curve : competition.Curves()) {
    bool holds = true;
    // In place of a curve of an input another has to explain all its outputs.
    double margin = 0.0;
    for (int i = 0; i < candidates.initial.num_outputs(); ++i) {
      const OutputExplanation& output = competition.outputs()[i];
      const TakenExplanation* const taken = TakenOf(output, curve);
      if (taken == nullptr) continue;
      margin += MarginOf(output, taken->explanation);
      // Of outputs that have evidence of their own.
      if (!(taken->evidence > candidates.options.explain.evidence)) continue;
      holds = holds && !Misleads(competition, i) && PredictsBetter(output);
    }
    holds = holds && margin >= kRivalMargin;
    if (holds) held.push_back(curve);
  }
  return held;
}

absl::StatusOr<BentPlant> WithCurves(const ProcessModel& model,
                                     const RecordData& data,
                                     const std::vector<FoundCurve>& curves) {
  BentPlant bent = {model, data};
  for (const FoundCurve& curve : curves) AddCurve(curve, bent.model);
  MLE_RETURN_IF_ERROR(bent.model.Validate());
  for (Record& record : bent.data.records) {
    MLE_RETURN_IF_ERROR(Change(model, bent.model, record));
  }
  for (SetPointWindow& window : bent.data.windows) {
    MLE_RETURN_IF_ERROR(Change(model, bent.model, window.record));
  }
  return bent;
}

std::vector<FoundCurve> Upon(std::vector<FoundCurve> curves,
                             std::vector<FoundCurve> later) {
  for (FoundCurve& one : later) {
    const auto same =
        std::find_if(curves.begin(), curves.end(), [&](const FoundCurve& c) {
          return c.is_output == one.is_output && c.channel == one.channel;
        });
    if (same == curves.end()) {
      curves.push_back(std::move(one));
    } else {
      same->upon.push_back(std::move(one));
    }
  }
  return curves;
}

std::string DescribeCurve(const ProcessModel& model, const FoundCurve& curve) {
  const std::string& name = curve.is_output
                                ? model.outputs()[curve.channel].name
                                : model.inputs()[curve.channel].name;
  const std::string& unit = curve.is_output
                                ? model.outputs()[curve.channel].unit
                                : model.inputs()[curve.channel].unit;
  const auto at = [&](double share) {
    const double value = curve.low + share * (curve.high - curve.low);
    return absl::StrFormat("× %.2g at %.3g%s%s", curve.GainAt(value).value,
                           value, unit.empty() || unit == "-" ? "" : " ",
                           unit == "-" ? "" : unit);
  };
  return absl::StrCat(
      curve.is_output ? "All gains of " : "The gain of ", name,
      curve.is_output ? " follow its own level: " : " follows its position: ",
      at(kLow), ", ", at(kHigh));
}

}  // namespace mle
