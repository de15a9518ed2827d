#include "mle/maintain/correct.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/segments.h"
#include "mle/exchange/model_file.h"
#include "mle/maintain/built_result.h"
#include "mle/maintain/candidates.h"
#include "mle/maintain/certificates.h"
#include "mle/maintain/curves_held.h"
#include "mle/maintain/evidence.h"
#include "mle/maintain/explained.h"
#include "mle/maintain/usual_residuals.h"

namespace mle {
namespace {

// Curves of a channel that are put one upon the other, at most.
constexpr int kMostCurved = 3;

// The correction within the curves that model and records hold; nothing where
// it leaves doubt of outputs that they act on.
absl::StatusOr<std::optional<CorrectionResult>> CorrectBent(
    const ProcessModel& model, RecordData data, const CorrectOptions& options,
    const std::vector<FoundCurve>& held, int rounds);

absl::Status NotPositive(const char* field, double value) {
  return absl::InvalidArgumentError(absl::StrCat(
      field, " = ", value, ": it must be finite and greater than 0"));
}

// Changes in the first window, at different times: of set points or, in a whole
// record without any, of inputs.
int ChangesOf(const RecordData& data) {
  const SetPointWindow& window = data.windows.front();
  std::set<int> samples;
  for (const SetPointChange& change : window.changes) {
    samples.insert(change.sample);
  }
  if (!samples.empty()) return static_cast<int>(samples.size());
  const Eigen::MatrixXd& inputs = window.record.inputs;
  int moves = 0;
  for (Eigen::Index k = 1; k < inputs.cols(); ++k) {
    if ((inputs.col(k).array() != inputs.col(k - 1).array()).any()) ++moves;
  }
  return moves;
}

absl::StatusOr<Validation> Judge(const Candidates& candidates) {
  const CorrectOptions& options = candidates.options;
  return ValidateByHoldOut(candidates.estimate, candidates.windows,
                           ChangesOf(candidates.data), candidates.order(),
                           options.hold_out, options.in_use, options.threads,
                           options.progress);
}

// Whether reasons are told of an output that a curve acts on.
bool IsDoubtful(const ProcessModel& model, const std::vector<Message>& reasons,
                const FoundCurve& curve) {
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (curve.is_output ? i != curve.channel
                        : model.element(i, curve.channel).IsZero()) {
      continue;
    }
    const std::string& name = model.outputs()[i].name;
    for (const Message& reason : reasons) {
      if (reason.place == name) return true;
    }
  }
  return false;
}

// What is decided of a model that holds curves: it is another one, whether its
// elements have changed or not; nothing where outputs that a curve acts on are
// in doubt.
std::optional<Verdict> OfCurves(const ProcessModel& model, Verdict verdict,
                                const std::vector<FoundCurve>& held) {
  if (held.empty() || verdict.decision == Decision::kCorrected) return verdict;
  if (verdict.decision == Decision::kNoChange) verdict.reasons.clear();
  for (const FoundCurve& curve : held) {
    if (IsDoubtful(model, verdict.reasons, curve)) return std::nullopt;
  }
  verdict.decision = Decision::kCorrected;
  std::fill(verdict.outputs.begin(), verdict.outputs.end(),
            Acceptance::kNothing);
  return verdict;
}

// What the elements are between the variables that curves make linear; nothing
// where the records have no such values, or leave doubt.
absl::StatusOr<std::optional<CorrectionResult>> CorrectWithin(
    const Candidates& candidates, const std::vector<FoundCurve>& curves,
    int rounds) {
  absl::StatusOr<BentPlant> bent =
      WithCurves(candidates.initial, candidates.given, curves);
  if (!bent.ok()) return std::optional<CorrectionResult>();
  MLE_ASSIGN_OR_RETURN(std::optional<CorrectionResult> within,
                       CorrectBent(bent->model, std::move(bent->data),
                                   candidates.options, curves, rounds));
  if (!within.has_value()) return within;
  CorrectionResult& result = *within;
  // One reason for each channel, whatever the rounds in which it was found.
  result.curves = Upon(curves, std::move(result.curves));
  std::erase_if(result.reasons, [](const Message& reason) {
    return reason.code == MessageCode::kCurved;
  });
  std::vector<Message> reasons;
  for (const FoundCurve& curve : result.curves) {
    reasons.push_back({MessageCode::kCurved,
                       curve.is_output
                           ? candidates.initial.outputs()[curve.channel].name
                           : candidates.initial.inputs()[curve.channel].name,
                       absl::StrCat(DescribeCurve(candidates.initial, curve),
                                    ". The corrected model has it as a "
                                    "transform."),
                       {}});
  }
  result.reasons.insert(result.reasons.begin(), reasons.begin(), reasons.end());
  // What is explained is told whole: the curves, and what was left beside them.
  for (std::size_t i = 0; i < result.explanations.size(); ++i) {
    std::vector<TakenExplanation> all =
        candidates.competition->outputs()[i].taken;
    std::erase_if(all, [](const TakenExplanation& one) {
      return !IsCurve(one.explanation.kind);
    });
    std::vector<TakenExplanation>& taken = result.explanations[i].taken;
    taken.insert(taken.begin(), all.begin(), all.end());
  }
  return within;
}

// Further curves, so many at most, are put into the model that is corrected.
absl::StatusOr<std::optional<CorrectionResult>> CorrectBent(
    const ProcessModel& model, RecordData data, const CorrectOptions& options,
    const std::vector<FoundCurve>& held, int rounds) {
  MLE_ASSIGN_OR_RETURN(Candidates candidates,
                       FindCandidates(model, std::move(data), options));
  MLE_ASSIGN_OR_RETURN(Validation validation, Judge(candidates));
  const Verdict verdict =
      Decide(GatherEvidence(candidates, validation), options.decision);
  const std::vector<FoundCurve> curves =
      rounds > 0 ? CurvesToHold(candidates) : std::vector<FoundCurve>();
  if (!curves.empty()) {
    MLE_ASSIGN_OR_RETURN(std::optional<CorrectionResult> within,
                         CorrectWithin(candidates, curves, rounds - 1));
    if (within.has_value()) return within;
  }
  std::optional<Verdict> decided = OfCurves(model, verdict, held);
  if (!decided.has_value()) return std::optional<CorrectionResult>();
  MLE_ASSIGN_OR_RETURN(CorrectionResult result,
                       BuildResult(std::move(candidates), std::move(validation),
                                   *std::move(decided)));
  return std::optional<CorrectionResult>(std::move(result));
}

RecordOptions RecordOptionsOf(const CorrectOptions& options) {
  RecordOptions records = options.records;
  records.examination.threads = options.threads;
  return records;
}

absl::Status CheckModel(const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(model.Validate());
  if (SettlingTime(model) > 0.0 || IsIntegrating(model)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the model '", model.name(),
      "' has no element with a time constant or a dead time: there is nothing "
      "to correct"));
}

}  // namespace

absl::Status CorrectOptions::Validate() const {
  MLE_RETURN_IF_ERROR(records.Validate());
  MLE_RETURN_IF_ERROR(estimation.Validate());
  MLE_RETURN_IF_ERROR(hold_out.Validate());
  MLE_RETURN_IF_ERROR(explain.Validate());
  MLE_RETURN_IF_ERROR(decision.Validate());
  MLE_RETURN_IF_ERROR(filter.Validate());
  if (!(response_horizon >= 0.0) || !std::isfinite(response_horizon)) {
    return OptionError(
        "response_horizon",
        absl::StrCat("response_horizon = ", response_horizon,
                     ": it must be a time > 0, or 0 for the default"));
  }
  if (!(accepted_gap > 0.0) || !std::isfinite(accepted_gap)) {
    return NotPositive("accepted_gap", accepted_gap);
  }
  if (!(accepted_gradient > 0.0) || !std::isfinite(accepted_gradient)) {
    return NotPositive("accepted_gradient", accepted_gradient);
  }
  if (threads < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("threads = ", threads, ": it must not be negative"));
  }
  return absl::OkStatus();
}

ResponseDistance CompareResponses(const StepResponse& from,
                                  const StepResponse& to) {
  ResponseDistance distance;
  distance.total = SquaredDistance(from, to);
  const double size = from.values.squaredNorm();
  distance.relative = size > 0.0 ? std::sqrt(distance.total / size) : 0.0;
  distance.elements = Eigen::MatrixXd::Zero(from.num_outputs, from.num_inputs);
  for (int i = 0; i < from.num_outputs; ++i) {
    double largest = 0.0;
    for (int j = 0; j < from.num_inputs; ++j) {
      largest = std::max(largest, from.element(i, j).norm());
    }
    for (int j = 0; j < from.num_inputs; ++j) {
      const double own = from.element(i, j).norm();
      const double norm = own > 0.0 ? own : largest;
      if (!(norm > 0.0)) continue;
      distance.elements(i, j) =
          (from.element(i, j) - to.element(i, j)).norm() / norm;
    }
  }
  return distance;
}

absl::StatusOr<CorrectionResult> CorrectFromData(
    const ProcessModel& model, RecordData data, const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckModel(model));
  if (data.windows.empty()) {
    return absl::InvalidArgumentError("there are no windows");
  }
  MLE_ASSIGN_OR_RETURN(
      std::optional<CorrectionResult> result,
      CorrectBent(model, std::move(data), options, {}, kMostCurved));
  return *std::move(result);
}

double DetectableGain(const CorrectionResult& result, int i, int j) {
  return DetectableGain(result.explanations, result.estimate, i, j);
}

double PValue(const CorrectionResult& result) {
  double p_value = result.estimate.fit.test.p_value;
  if (result.estimate.fit.change_proposed) return p_value;
  const auto outputs = static_cast<double>(result.explanations.size());
  for (const OutputExplanation& output : result.explanations) {
    for (const TakenExplanation& one : output.taken) {
      p_value = std::min(p_value, outputs * std::exp(-one.evidence));
    }
  }
  return p_value;
}

bool HasOtherShape(const CorrectionResult& result, int i, int j) {
  if (!result.corrected.process.has_value()) return false;
  const TransferFunction& from = result.initial.element(i, j);
  const TransferFunction& to = result.corrected.process->element(i, j);
  return from.IsZero() != to.IsZero() ||
         from.numerator().size() != to.numerator().size() ||
         from.denominator().size() != to.denominator().size();
}

absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const ProcessModel& model, std::vector<Record> records,
    const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckModel(model));
  MLE_ASSIGN_OR_RETURN(
      RecordData data,
      PrepareRecords(std::move(records), model, RecordOptionsOf(options)));
  return CorrectFromData(model, std::move(data), options);
}

absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const std::string& model_path, const std::vector<std::string>& record_paths,
    const HistorianOptions& import, const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile(model_path));
  const ProcessModel& model = file.process;
  MLE_RETURN_IF_ERROR(CheckModel(model));
  MLE_ASSIGN_OR_RETURN(RecordData data,
                       LoadRecords(record_paths, model, import,
                                   RecordOptionsOf(options), options.progress));
  return CorrectFromData(model, std::move(data), options);
}

}  // namespace mle
