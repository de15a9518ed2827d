#include "mle/monitor/next_change.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/QR"
#include "absl/status/status.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Below this health an output's evidence says something.
constexpr double kSaysSomething = 0.9;
// A change that should be seen within so many batches.
constexpr double kToBeSeen = 0.1;
constexpr int kWithin = 30;
// More than these are not asked for.
constexpr int kMostChanges = 32;
constexpr int kHalvings = 2;

// A change of one set point.
struct CandidateChange {
  int set_point = 0;
  double size = 0.0;
  std::vector<MatrixXd> informations;  // p
};

// A change of one parameter of the output, that is in question.
struct ChangeInQuestion {
  int output = 0;
  LikelyChange change;
  NextChange::Question kind = NextChange::Question::kUnseen;
};

class ChangeSearch {
 public:
  ChangeSearch(const ModelWatch& watch, const WatchReference& reference,
               const std::vector<ScoredOutput>& outputs,
               const NextChangeOptions& options)
      : watch_(watch),
        reference_(reference),
        outputs_(outputs),
        options_(options) {}

  absl::StatusOr<NextChange> Run();

 private:
  absl::Status MakeCandidates();
  std::optional<ChangeInQuestion> LikeliestChange() const;
  std::vector<ChangeInQuestion> UnseenChanges() const;
  // The batches so far, as `question` has them.
  std::vector<ScoredBatch> Past(const ChangeInQuestion& question) const;
  // ln E of the element after `count` batches of the information more, with all
  // batches or confirmed.
  using Evidence = decltype(ConfirmedElementEvidenceOf);
  double After(const ChangeInQuestion& question, const MatrixXd& information,
               int count,
               Evidence evidence_of = ConfirmedElementEvidenceOf) const;
  // Whether that raises an alarm: what is not confirmed, which takes a quarter
  // of the time, is never less.
  bool Raises(const ChangeInQuestion& question, const MatrixXd& information,
              int count) const {
    return After(question, information, count, ElementEvidenceOf) >=
               log_alarm() &&
           After(question, information, count) >= log_alarm();
  }
  const CandidateChange* Best(const ChangeInQuestion& question) const;
  // Without the evidence that there is now, which takes time: see Told().
  NextChange Answer(const ChangeInQuestion& question) const;
  NextChange Told(const ChangeInQuestion& question, NextChange next) const {
    next.log_evidence = After(question, MatrixXd(), 0);
    return next;
  }
  double log_alarm() const { return -std::log(options_.share_of_element); }

  const ModelWatch& watch_;
  const WatchReference& reference_;
  const std::vector<ScoredOutput>& outputs_;
  const NextChangeOptions& options_;
  std::vector<CandidateChange> candidates_;
};

absl::Status ChangeSearch::MakeCandidates() {
  const ProcessModel& model = watch_.model();
  const int p = model.num_outputs();
  MatrixXd gains = StaticGains(model);
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.inputs()[j].role != InputRole::kManipulated) {
      gains.col(j).setZero();
    }
  }
  const MatrixXd inverse =
      gains.completeOrthogonalDecomposition().pseudoInverse();
  const VectorXd range = reference_.high - reference_.low;
  for (int i = 0; i < p; ++i) {
    // Inputs for Δ = 1, and how far they bring the output itself.
    const VectorXd inputs = inverse.col(i);
    const bool reaches = std::abs(gains.row(i).dot(inputs) - 1.0) < 1e-6;
    if (!reaches || !(range(i) > 0.0)) continue;
    double size = range(i);
    for (int j = 0; j < model.num_inputs(); ++j) {
      const double moved = std::abs(inputs(j));
      // The range of an input that stood still does not limit the change.
      if (moved > 0.0 && range(p + j) > 0.0) {
        size = std::min(size, range(p + j) / moved);
      }
    }
    MLE_ASSIGN_OR_RETURN(std::vector<MatrixXd> informations,
                         watch_.ExpectedInformation(reference_, size * inputs));
    candidates_.push_back({i, size, std::move(informations)});
  }
  return absl::OkStatus();
}

std::optional<ChangeInQuestion> ChangeSearch::LikeliestChange() const {
  std::optional<ChangeInQuestion> found;
  double least = kSaysSomething;
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const ScoredOutput& output = outputs_[i];
    if (output.batches.empty()) continue;
    const double health =
        HealthOf(output.evidence.log_output, options_.share_of_output);
    const std::vector<double>& elements = output.evidence.log_elements;
    const bool named =
        std::any_of(elements.begin(), elements.end(),
                    [this](double element) { return element >= log_alarm(); });
    if (named || health >= least) continue;
    least = health;
    const int number = static_cast<int>(i);
    found = {number,
             ExplainEvidence(output.batches, watch_.LeastChanges(number),
                             watch_.options()),
             NextChange::Question::kLikely};
  }
  return found;
}

std::vector<ChangeInQuestion> ChangeSearch::UnseenChanges() const {
  const int begin = options_.last - kWithin + 1;
  std::vector<std::pair<double, ChangeInQuestion>> found;
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const int number = static_cast<int>(i);
    const std::vector<int>& inputs = watch_.inputs(number);
    for (std::size_t e = 0; e < inputs.size(); ++e) {
      if (watch_.model().inputs()[inputs[e]].role != InputRole::kManipulated) {
        continue;
      }
      LikelyChange change{
          .element = static_cast<int>(e), .change = kToBeSeen, .begin = begin};
      const double known = OwnInformation(
          outputs_[i].batches, begin, change.element, watch_.options())(0, 0);
      found.push_back({known, {number, change}});
    }
  }
  std::stable_sort(
      found.begin(), found.end(),
      [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<ChangeInQuestion> questions;
  for (auto& [known, question] : found) questions.push_back(question);
  return questions;
}

std::vector<ScoredBatch> ChangeSearch::Past(
    const ChangeInQuestion& question) const {
  std::vector<ScoredBatch> batches = outputs_[question.output].batches;
  if (question.kind == NextChange::Question::kLikely) return batches;
  const LikelyChange& change = question.change;
  const Eigen::Index a = 3 * change.element + change.parameter;
  for (ScoredBatch& batch : batches) {
    const double size = batch.number >= change.begin ? change.change : 0.0;
    batch.score = size * batch.information.col(a);
    if (batch.largest.has_value()) {
      batch.largest->score = size * batch.largest->information.col(a);
    }
  }
  return batches;
}

double ChangeSearch::After(const ChangeInQuestion& question,
                           const MatrixXd& information, int count,
                           Evidence evidence_of) const {
  const int output = question.output;
  const LikelyChange& change = question.change;
  std::vector<ScoredBatch> batches = Past(question);
  const Eigen::Index n =
      3 * static_cast<Eigen::Index>(watch_.inputs(output).size());
  // θ, of the batches before the change; that of a baseline counts as 0.
  const double deviation = watch_.options().model_error;
  MatrixXd before = MatrixXd::Identity(n, n) / (deviation * deviation);
  VectorXd score = VectorXd::Zero(n);
  for (const ScoredBatch& batch : batches) {
    if (batch.number + batch.length > change.begin) break;
    before += batch.information;
    score += batch.score;
  }
  VectorXd mean = before.ldlt().solve(score);
  mean(3 * change.element + change.parameter) += change.change;
  const auto add = [&](int number, const VectorXd& changed) {
    batches.push_back({.number = number,
                       .length = 1,
                       .score = information * changed,
                       .information = information});
  };
  int last = options_.last;
  if (question.kind == NextChange::Question::kBaseline) {
    for (int k = 1; k <= count; ++k) add(++last, VectorXd::Zero(n));
  }
  for (int k = 1; k <= count; ++k) add(++last, mean);
  return evidence_of(batches, change.element, watch_.LeastChanges(output),
                     watch_.options());
}

const CandidateChange* ChangeSearch::Best(
    const ChangeInQuestion& question) const {
  const CandidateChange* best = nullptr;
  double most = 0.0;
  const auto output = static_cast<std::size_t>(question.output);
  const LikelyChange& change = question.change;
  for (const CandidateChange& candidate : candidates_) {
    const MatrixXd& information = candidate.informations[output];
    if (information.size() == 0) continue;
    std::vector<ScoredBatch> batches = outputs_[output].batches;
    const bool baseline = question.kind == NextChange::Question::kBaseline;
    for (int k = 1; k <= (baseline ? 2 : 1); ++k) {
      batches.push_back({.number = options_.last + k,
                         .length = 1,
                         .score = VectorXd::Zero(information.rows()),
                         .information = information});
    }
    const int begin = baseline ? options_.last + 2 : change.begin;
    const double known =
        OwnInformation(batches, begin, change.element, watch_.options())(
            change.parameter, change.parameter);
    if (known <= most) continue;
    most = known;
    best = &candidate;
  }
  return best;
}

NextChange ChangeSearch::Answer(const ChangeInQuestion& question) const {
  NextChange next;
  next.state = NextChange::State::kNoneTells;
  next.question = question.kind;
  next.output = question.output;
  next.element = question.change.element;
  next.parameter = question.change.parameter;
  next.change = question.change.change;
  next.log_alarm = log_alarm();
  const CandidateChange* best = Best(question);
  if (best == nullptr) return next;
  MatrixXd information =
      best->informations[static_cast<std::size_t>(question.output)];
  // Most questions that no change answers end here.
  if (!Raises(question, information, kMostChanges)) return next;
  int changes = 1;
  double expected = After(question, information, changes);
  while (expected < log_alarm() && changes < kMostChanges) {
    changes *= 2;
    expected = After(question, information, changes);
  }
  // The least between what suffices and half of it.
  for (int step = changes / 4; step > 0; step /= 2) {
    const double fewer = After(question, information, changes - step);
    if (fewer < log_alarm()) continue;
    changes -= step;
    expected = fewer;
  }
  next.state = NextChange::State::kPropose;
  next.set_point = best->set_point;
  next.size = best->size;
  next.changes = changes;
  next.log_expected = expected;
  for (int halving = 0; halving < kHalvings && next.changes <= 2; ++halving) {
    information /= 4.0;
    const double smaller = After(question, information, next.changes);
    if (smaller < log_alarm()) break;
    next.size /= 2.0;
    next.log_expected = smaller;
  }
  return next;
}

absl::StatusOr<NextChange> ChangeSearch::Run() {
  const std::optional<ChangeInQuestion> likely = LikeliestChange();
  if (likely.has_value()) {
    MLE_RETURN_IF_ERROR(MakeCandidates());
    return Told(*likely, Answer(*likely));
  }
  const bool any_named = std::any_of(
      outputs_.begin(), outputs_.end(), [this](const ScoredOutput& output) {
        const std::vector<double>& elements = output.evidence.log_elements;
        return std::any_of(
            elements.begin(), elements.end(),
            [this](double element) { return element >= log_alarm(); });
      });
  if (any_named) return NextChange{.state = NextChange::State::kNamed};
  std::optional<NextChange> first;
  for (const ChangeInQuestion& question : UnseenChanges()) {
    // The others are known better.
    if (Raises(question, MatrixXd(), 0)) break;
    if (candidates_.empty()) MLE_RETURN_IF_ERROR(MakeCandidates());
    const NextChange next = Answer(question);
    if (next.state == NextChange::State::kPropose) return Told(question, next);
    if (!first.has_value()) first = Told(question, next);
    if (candidates_.empty()) break;
    ChangeInQuestion baseline = question;
    baseline.kind = NextChange::Question::kBaseline;
    baseline.change.begin = std::numeric_limits<int>::max();
    const NextChange before = Answer(baseline);
    if (before.state == NextChange::State::kPropose) {
      return Told(baseline, before);
    }
  }
  return first.value_or(NextChange());
}

}  // namespace

absl::StatusOr<NextChange> FindNextChange(
    const ModelWatch& watch, const WatchReference& reference,
    const std::vector<ScoredOutput>& outputs,
    const NextChangeOptions& options) {
  const ProcessModel& model = watch.model();
  const auto p = static_cast<std::size_t>(model.num_outputs());
  const int channels = model.num_outputs() + model.num_inputs();
  if (outputs.size() != p || reference.outputs.size() != p ||
      reference.low.size() != channels || reference.high.size() != channels) {
    return absl::InvalidArgumentError(
        "watch: the reference is that of a model with other channels");
  }
  return ChangeSearch(watch, reference, outputs, options).Run();
}

}  // namespace mle
