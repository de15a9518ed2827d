#include "mle/maintain/operator_mistakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/maintain/common_factor.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/whitened_fit.h"

namespace mle {
namespace {

constexpr std::array<int, 3> kBlocks = {1, 5, 20};
constexpr double kLeastBlocks = 100.0;
constexpr double kLeastMistakeNats = 10.0;
constexpr double kCompleteNats = 6.0;
constexpr double kSameFactor = 0.1;
constexpr std::array<double, 4> kTimeUnits = {60.0, 1.0 / 60.0, 3600.0,
                                              1.0 / 3600.0};

using Kind = OperatorMistake::Kind;

// A model without free parameters that may be behind the records.
struct Hypothesis {
  OperatorMistake mistake;
  Assignment assignment;
  Eigen::MatrixXd gains;    // p × m: factors of the model's elements
  Eigen::MatrixXd without;  // the same, the channels concerned having no effect
  // Free gains must not be better: all that tells is one length of blocks.
  bool complete = false;
};

// The model as it is, at one length of blocks.
struct AsRecorded {
  int block = 1;
  double fixed = 0.0;  // log-likelihoods, with the model's gains
  double free = 0.0;   // and with free ones
  GainEstimates gains;
};

class MistakeSearch {
 public:
  MistakeSearch(const ProcessModel& model, const std::vector<Record>& parts)
      : model_(model), parts_(parts) {}

  absl::StatusOr<std::optional<OperatorMistake>> Run();

 private:
  int p() const { return model_.num_outputs(); }
  int m() const { return model_.num_inputs(); }

  double LogLikelihood(const ElementResponses& responses,
                       const Assignment& assignment,
                       const Eigen::MatrixXd& gains, int block) const;
  void FitAsRecorded();
  Hypothesis AsIs() const;
  void AddExchanges();
  // Of a row (an output) or column (an input) in which all determined gains
  // agree.
  void AddFactors(bool outputs);
  void Judge(const Hypothesis& hypothesis, const ElementResponses& responses);

  const ProcessModel& model_;
  const std::vector<Record>& parts_;
  std::vector<int> moving_;  // outputs that are not constant
  std::optional<ElementResponses> responses_;
  std::vector<AsRecorded> as_recorded_;
  std::vector<Hypothesis> hypotheses_;
  std::optional<OperatorMistake> best_;
};

double MistakeSearch::LogLikelihood(const ElementResponses& responses,
                                    const Assignment& assignment,
                                    const Eigen::MatrixXd& gains,
                                    int block) const {
  double sum = 0.0;
  for (const int i : moving_) {
    sum +=
        WhitenedLogLikelihood(BlockMeans(responses.Row(assignment, i), block),
                              gains.row(i).transpose());
  }
  return sum;
}

void MistakeSearch::FitAsRecorded() {
  double samples = 0.0;
  for (const Record& part : parts_) samples += part.samples();
  const Assignment assignment = Assignment::AsRecorded(model_);
  for (const int block : kBlocks) {
    if (samples / block < kLeastBlocks) continue;
    AsRecorded& fit = as_recorded_.emplace_back();
    fit.block = block;
    fit.gains.values = Eigen::MatrixXd::Ones(p(), m());
    fit.gains.errors = Eigen::MatrixXd::Constant(
        p(), m(), std::numeric_limits<double>::infinity());
    for (const int i : moving_) {
      const WhitenedData row =
          BlockMeans(responses_->Row(assignment, i), block);
      const Eigen::VectorXd ones = Eigen::VectorXd::Ones(m());
      fit.fixed += WhitenedLogLikelihood(row, ones);
      const WhitenedFit free = FitWhitenedGains(row, ones);
      fit.free += free.log_likelihood;
      fit.gains.values.row(i) = free.gains.transpose();
      fit.gains.errors.row(i) = free.errors.transpose();
    }
  }
}

Hypothesis MistakeSearch::AsIs() const {
  Hypothesis hypothesis;
  hypothesis.assignment = Assignment::AsRecorded(model_);
  hypothesis.gains = Eigen::MatrixXd::Ones(p(), m());
  hypothesis.without = hypothesis.gains;
  return hypothesis;
}

void MistakeSearch::AddExchanges() {
  for (const bool outputs : {false, true}) {
    const int channels = outputs ? p() : m();
    for (int a = 0; a < channels; ++a) {
      for (int b = a + 1; b < channels; ++b) {
        Hypothesis hypothesis = AsIs();
        hypothesis.mistake.outputs = outputs;
        hypothesis.mistake.channels = {a, b};
        std::vector<int>& tags = outputs ? hypothesis.assignment.outputs
                                         : hypothesis.assignment.inputs;
        std::swap(tags[a], tags[b]);
        for (const int channel : {a, b}) {
          if (outputs) {
            hypothesis.without.row(channel).setZero();
          } else {
            hypothesis.without.col(channel).setZero();
          }
        }
        hypotheses_.push_back(std::move(hypothesis));
      }
    }
  }
}

void MistakeSearch::AddFactors(bool outputs) {
  const int channels = outputs ? p() : m();
  std::vector<GainEstimates> estimates;
  for (const AsRecorded& fit : as_recorded_) estimates.push_back(fit.gains);
  for (int c = 0; c < channels; ++c) {
    const std::optional<CommonFactor> common =
        FindCommonFactor(estimates, outputs, c);
    if (!common.has_value()) continue;
    Hypothesis alone = AsIs();
    OperatorMistake& mistake = alone.mistake;
    mistake.kind = common->factor < 0.0 ? Kind::kSign : Kind::kFactor;
    mistake.outputs = outputs;
    mistake.channels = {c};
    mistake.factor = common->factor;
    mistake.ambiguous = common->elements == 1;
    alone.complete = common->must_be_complete;
    const auto apply = [&](Hypothesis& to) {
      if (outputs) {
        to.gains.row(c) *= mistake.factor;
        to.without.row(c).setZero();
      } else {
        to.gains.col(c) *= mistake.factor;
        to.without.col(c).setZero();
      }
    };
    apply(alone);
    // The same mistake in several channels is one.
    for (std::size_t h = 0; h < hypotheses_.size(); ++h) {
      const OperatorMistake& other = hypotheses_[h].mistake;
      if (other.kind != mistake.kind || other.outputs != outputs ||
          std::abs(other.factor / mistake.factor - 1.0) > kSameFactor) {
        continue;
      }
      Hypothesis together = hypotheses_[h];
      together.mistake.channels.push_back(c);
      apply(together);
      hypotheses_.push_back(std::move(together));
      break;
    }
    hypotheses_.push_back(std::move(alone));
  }
}

void MistakeSearch::Judge(const Hypothesis& hypothesis,
                          const ElementResponses& responses) {
  const bool other_times = hypothesis.mistake.kind == Kind::kTimeUnit;
  const Assignment recorded = Assignment::AsRecorded(model_);
  bool proved = false;
  double least = std::numeric_limits<double>::infinity();
  for (const AsRecorded& fit : as_recorded_) {
    const double likelihood = LogLikelihood(responses, hypothesis.assignment,
                                            hypothesis.gains, fit.block);
    least = std::min(least, likelihood - fit.fixed);
    if (!(least > 0.0)) return;
    if (hypothesis.complete && fit.block == 1 &&
        likelihood < fit.free - kCompleteNats) {
      return;
    }
    const double rival = std::max(
        other_times ? fit.free : fit.fixed,
        LogLikelihood(*responses_, recorded, hypothesis.without, fit.block));
    proved = proved || likelihood > rival + kLeastMistakeNats;
  }
  if (!proved || (best_.has_value() && best_->log_likelihood >= least)) return;
  best_ = hypothesis.mistake;
  best_->log_likelihood = least;
}

absl::StatusOr<std::optional<OperatorMistake>> MistakeSearch::Run() {
  for (int i = 0; i < p(); ++i) {
    const bool moves =
        std::any_of(parts_.begin(), parts_.end(), [i](const Record& part) {
          return part.outputs.row(i).maxCoeff() >
                 part.outputs.row(i).minCoeff();
        });
    if (moves) moving_.push_back(i);
  }
  MLE_ASSIGN_OR_RETURN(responses_,
                       ElementResponses::Create(model_, parts_, 1.0));
  FitAsRecorded();
  AddExchanges();
  for (const bool outputs : {false, true}) AddFactors(outputs);
  for (const Hypothesis& hypothesis : hypotheses_) {
    Judge(hypothesis, *responses_);
  }
  for (const double scale : kTimeUnits) {
    const absl::StatusOr<ElementResponses> responses = ElementResponses::Create(
        model_, parts_, scale, ElementResponses::Inputs::kOwn);
    // Dead times of too many samples, say: then it is not this unit.
    if (!responses.ok()) continue;
    Hypothesis hypothesis = AsIs();
    hypothesis.mistake.kind = Kind::kTimeUnit;
    hypothesis.mistake.factor = scale;
    hypothesis.without.setZero();
    Judge(hypothesis, *responses);
  }
  return best_;
}

std::string FactorText(double factor) {
  if (factor >= 1.0) return absl::StrFormat("%.4g", factor);
  return absl::StrFormat("1/%.4g", 1.0 / factor);
}

}  // namespace

std::string OperatorMistake::Describe(const ProcessModel& model) const {
  std::vector<std::string> names;
  for (const int c : channels) {
    names.push_back(outputs ? model.outputs()[c].name : model.inputs()[c].name);
  }
  const std::string tags = absl::StrJoin(names, " and ");
  std::string text;
  switch (kind) {
    case Kind::kExchanged:
      text = absl::StrCat("The tags of ", tags, " seem to be exchanged");
      break;
    case Kind::kSign:
      text = absl::StrCat("The sign of ", tags, " seems to be reversed");
      break;
    case Kind::kFactor:
      text = absl::StrCat("The unit of ", tags,
                          " does not seem to be that of the model: the gains "
                          "in the records are ",
                          FactorText(factor), " times the model's");
      if (std::abs(std::abs(std::log(factor)) - std::log(1.8)) < 1e-9) {
        absl::StrAppend(&text, " (degrees Fahrenheit and Celsius, say)");
      }
      break;
    case Kind::kTimeUnit:
      text = absl::StrCat(
          "The model's time unit does not seem to be that of the records: its "
          "times fit when multiplied by ",
          FactorText(factor));
      break;
  }
  absl::StrAppend(&text,
                  absl::StrFormat(". Mended so, the model explains the records "
                                  "better by %.0f nats of log-likelihood.",
                                  log_likelihood));
  if (ambiguous) {
    absl::StrAppend(&text,
                    " Only one element tells, which may as well have aged.");
  }
  return text;
}

absl::StatusOr<std::optional<OperatorMistake>> FindOperatorMistake(
    const ProcessModel& model, const std::vector<Record>& records) {
  const std::vector<Record> parts = AroundSetPointChanges(records);
  double samples = 0.0;
  for (const Record& part : parts) samples += part.samples();
  const double products =
      samples * model.num_outputs() * model.num_inputs() * model.num_inputs();
  if (samples < kLeastBlocks || products > kMostProducts) {
    return std::optional<OperatorMistake>();
  }
  return MistakeSearch(model, parts).Run();
}

}  // namespace mle
