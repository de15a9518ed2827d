#include "mle/maintain/operator_mistakes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/maintain/common_factor.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/simulated_share.h"
#include "mle/maintain/whitened_fit.h"

namespace mle {
namespace {

// Samples; what is no better in long blocks is soon known.
constexpr std::array<int, 3> kBlocks = {20, 5, 1};
constexpr double kLeastBlocks = 100.0;
// Samples of the responses of all elements to all inputs that are simulated.
constexpr double kMostResponses = 1e9;
constexpr double kLeastMistakeRatio = 10.0;
constexpr double kCompleteRatio = 6.0;
constexpr double kSameFactor = 0.1;
// The model must explain more than this share of what outputs do, on average,
// with the tags swapped back.
constexpr double kLeastShare = 0.25;
constexpr double kLeastShareOfOthers = 0.6;  // of another unit or role
constexpr double kSameShare = 0.05;
constexpr std::array<double, 4> kTimeUnits = {60.0, 1.0 / 60.0, 3600.0,
                                              1.0 / 3600.0};

using Kind = OperatorMistake::Kind;
using Series = std::vector<Eigen::VectorXd>;  // of each part

// A model without free parameters that may be behind the records.
struct Hypothesis {
  OperatorMistake mistake;
  // Free gains must not be better: all that tells is one length of blocks.
  bool complete = false;
};

// An output of the model under a hypothesis.
struct HypotheticalRow {
  int output = 0;
  int measured = 0;  // the tag that is taken for it
  Series claimed;    // what the elements make of the inputs
  Series without;    // the same, the channels concerned having no effect
};

// A hypothesis to be judged, and how the rows that it changes are made when it
// is.
struct Candidate {
  Hypothesis hypothesis;
  std::function<absl::StatusOr<std::vector<HypotheticalRow>>()> rows;
};

// The model as it is, at one length of blocks.
struct AsRecorded {
  int block = 1;
  Eigen::VectorXd fixed;    // p: log-likelihoods, with the model's gains
  double free_gains = 0.0;  // of all outputs, by how much free ones are better
  GainEstimates gains;
};

class MistakeSearch {
 public:
  MistakeSearch(const ProcessModel& model, const std::vector<Record>& parts,
                int threads)
      : model_(model), parts_(parts), threads_(threads) {}

  absl::StatusOr<std::optional<OperatorMistake>> Run();

 private:
  int p() const { return model_.num_outputs(); }
  int m() const { return model_.num_inputs(); }

  // The log-likelihood of the innovations of the tag `measured`, taken for this
  // output of the model, that responds so.
  double LogLikelihood(int output, int measured, const Series& responses,
                       int block) const;
  // Whether the exchange is the better account also where some elements of the
  // rows that it changes may have aged, with the tags as they are and
  // exchanged.
  absl::StatusOr<bool> BeatsAgeing(
      const OperatorMistake& exchange,
      const std::vector<HypotheticalRow>& rows) const;
  void FitAsRecorded();
  bool AreAlike(bool outputs, int a, int b) const;
  void AddExchanges(bool outputs);
  // Adds rows (outputs) or columns (inputs) with a common factor.
  void AddFactors(bool outputs);
  void AddTimeUnits();
  absl::StatusOr<std::vector<HypotheticalRow>> InputsExchanged(int a,
                                                               int b) const;
  std::vector<HypotheticalRow> OutputsExchanged(int a, int b) const;
  std::vector<HypotheticalRow> Multiplied(const OperatorMistake& mistake) const;
  std::vector<HypotheticalRow> WithTimes(double scale) const;
  // Whether the model, simulated without the mistake, follows the outputs
  // better than with it: a poor element has likelihoods of its own.
  bool Follows(const Hypothesis& hypothesis,
               const std::vector<HypotheticalRow>& rows) const;
  double ShareOf(int output, int measured, const Series& responses) const;
  // The log-likelihood ratio of the hypothesis to the model as it is, on its
  // rows, the least of all lengths of blocks; nothing if it is not proved.
  std::optional<double> Judge(const Hypothesis& hypothesis,
                              const std::vector<HypotheticalRow>& rows) const;
  // The best of the candidates; of equals the first.
  absl::Status JudgeAll();

  const ProcessModel& model_;
  const std::vector<Record>& parts_;
  const int threads_;
  std::vector<int> moving_;  // outputs that are not constant
  std::optional<ElementResponses> responses_;
  std::vector<Series> sums_;  // p: what all elements make of the inputs
  std::vector<AsRecorded> as_recorded_;  // the longest blocks first
  std::vector<Candidate> candidates_;
  std::optional<OperatorMistake> best_;
};

// The sum of the responses of each output's elements to all inputs.
std::vector<Series> SumsOf(const ElementResponses& responses,
                           const std::vector<Record>& parts, int outputs,
                           int inputs) {
  std::vector<Series> sums(outputs);
  for (int i = 0; i < outputs; ++i) {
    for (std::size_t w = 0; w < parts.size(); ++w) {
      Eigen::VectorXd& sum =
          sums[i].emplace_back(Eigen::VectorXd::Zero(parts[w].samples()));
      for (int j = 0; j < inputs; ++j) {
        const int column = responses.ColumnOf(i, j);
        if (column >= 0) sum += responses.Of(j)[w].col(column);
      }
    }
  }
  return sums;
}

// Adds `factor` times what an element makes of its input.
void Add(double factor, const ElementResponses::OfInput& of_input, int column,
         Series& series) {
  if (column < 0) return;
  for (std::size_t w = 0; w < series.size(); ++w) {
    series[w] += factor * of_input[w].col(column);
  }
}

Series Times(double factor, Series series) {
  for (Eigen::VectorXd& part : series) part *= factor;
  return series;
}

double MistakeSearch::LogLikelihood(int output, int measured,
                                    const Series& responses, int block) const {
  WhitenedData data;
  for (std::size_t w = 0; w < parts_.size(); ++w) {
    data.outputs.emplace_back(parts_[w].outputs.row(measured).transpose());
    data.responses.emplace_back(responses[w]);
  }
  if (responses_->integrates(output)) data = Increments(data);
  return WhitenedLogLikelihood(BlockMeans(data, block),
                               Eigen::VectorXd::Ones(1));
}

void MistakeSearch::FitAsRecorded() {
  double samples = 0.0;
  for (const Record& part : parts_) samples += part.samples();
  std::vector<WhitenedData> rows;
  for (int i = 0; i < p(); ++i) rows.push_back(responses_->Row(i));
  for (const int block : kBlocks) {
    if (samples / block < kLeastBlocks) continue;
    AsRecorded& fit = as_recorded_.emplace_back();
    fit.block = block;
    fit.fixed = Eigen::VectorXd::Zero(p());
    fit.gains.values = Eigen::MatrixXd::Ones(p(), m());
    fit.gains.errors = Eigen::MatrixXd::Constant(
        p(), m(), std::numeric_limits<double>::infinity());
    Eigen::VectorXd free_gains = fit.fixed;
    ParallelFor(static_cast<int>(moving_.size()), threads_, [&](int n) {
      const int i = moving_[n];
      fit.fixed(i) = LogLikelihood(i, i, sums_[i], block);
      const WhitenedFit free = FitWhitenedGains(BlockMeans(rows[i], block),
                                                Eigen::VectorXd::Ones(m()));
      free_gains(i) = free.log_likelihood - fit.fixed(i);
      fit.gains.values.row(i) = free.gains.transpose();
      fit.gains.errors.row(i) = free.errors.transpose();
    });
    fit.free_gains = free_gains.sum();
  }
}

absl::StatusOr<std::vector<HypotheticalRow>> MistakeSearch::InputsExchanged(
    int a, int b) const {
  MLE_ASSIGN_OR_RETURN(const ElementResponses::OfInput a_by_b,
                       responses_->Of(a, b));
  MLE_ASSIGN_OR_RETURN(const ElementResponses::OfInput b_by_a,
                       responses_->Of(b, a));
  std::vector<HypotheticalRow> rows;
  for (const int i : moving_) {
    const int of_a = responses_->ColumnOf(i, a);
    const int of_b = responses_->ColumnOf(i, b);
    if (of_a < 0 && of_b < 0) continue;
    HypotheticalRow& row = rows.emplace_back(HypotheticalRow{i, i, {}, {}});
    row.without = sums_[i];
    Add(-1.0, responses_->Of(a), of_a, row.without);
    Add(-1.0, responses_->Of(b), of_b, row.without);
    row.claimed = row.without;
    Add(1.0, a_by_b, of_a, row.claimed);
    Add(1.0, b_by_a, of_b, row.claimed);
  }
  return rows;
}

std::vector<HypotheticalRow> MistakeSearch::OutputsExchanged(int a,
                                                             int b) const {
  std::vector<HypotheticalRow> rows;
  for (const int i : moving_) {
    if (i != a && i != b) continue;
    rows.push_back({i, i == a ? b : a, sums_[i], Times(0.0, sums_[i])});
  }
  return rows;
}

std::vector<HypotheticalRow> MistakeSearch::Multiplied(
    const OperatorMistake& mistake) const {
  std::vector<HypotheticalRow> rows;
  for (const int i : moving_) {
    HypotheticalRow row = {i, i, sums_[i], sums_[i]};
    bool concerned = false;
    for (const int c : mistake.channels) {
      if (mistake.outputs) {
        if (c != i) continue;
        row.claimed = Times(mistake.factor, std::move(row.claimed));
        row.without = Times(0.0, std::move(row.without));
        concerned = true;
      } else {
        const int column = responses_->ColumnOf(i, c);
        Add(mistake.factor - 1.0, responses_->Of(c), column, row.claimed);
        Add(-1.0, responses_->Of(c), column, row.without);
        concerned = concerned || column >= 0;
      }
    }
    if (concerned) rows.push_back(std::move(row));
  }
  return rows;
}

// A tag is hardly taken for one of another unit, or what is only measured for
// what the controller moves.
bool MistakeSearch::AreAlike(bool outputs, int a, int b) const {
  if (outputs) return model_.outputs()[a].unit == model_.outputs()[b].unit;
  const InputChannel& first = model_.inputs()[a];
  const InputChannel& second = model_.inputs()[b];
  return first.unit == second.unit && first.role == second.role;
}

void MistakeSearch::AddExchanges(bool outputs) {
  const int channels = outputs ? p() : m();
  for (int a = 0; a < channels; ++a) {
    for (int b = a + 1; b < channels; ++b) {
      candidates_.push_back(
          {{.mistake = {.kind = Kind::kExchanged,
                        .outputs = outputs,
                        .channels = {a, b}}},
           [=, this]() -> absl::StatusOr<std::vector<HypotheticalRow>> {
             if (outputs) return OutputsExchanged(a, b);
             return InputsExchanged(a, b);
           }});
    }
  }
}

void MistakeSearch::AddFactors(bool outputs) {
  const int channels = outputs ? p() : m();
  std::vector<Hypothesis> factors;
  std::vector<GainEstimates> estimates;
  // Short blocks first.
  for (auto fit = as_recorded_.rbegin(); fit != as_recorded_.rend(); ++fit) {
    estimates.push_back(fit->gains);
  }
  for (int c = 0; c < channels; ++c) {
    const std::optional<CommonFactor> common =
        FindCommonFactor(estimates, outputs, c);
    if (!common.has_value()) continue;
    const Hypothesis alone = {
        .mistake = {.kind = common->factor < 0.0 ? Kind::kSign : Kind::kFactor,
                    .outputs = outputs,
                    .channels = {c},
                    .factor = common->factor,
                    .ambiguous = common->elements == 1},
        .complete = common->must_be_complete};
    // The same mistake in several channels is one.
    for (std::size_t h = 0; h < factors.size(); ++h) {
      const OperatorMistake& other = factors[h].mistake;
      const bool is_sign = other.kind == Kind::kSign;
      if (other.kind != alone.mistake.kind ||
          (!is_sign &&
           std::abs(other.factor / alone.mistake.factor - 1.0) > kSameFactor)) {
        continue;
      }
      Hypothesis together = factors[h];
      if (is_sign) together.mistake.factor = -1.0;
      together.mistake.channels.push_back(c);
      factors.push_back(std::move(together));
      break;
    }
    factors.push_back(alone);
  }
  for (const Hypothesis& factor : factors) {
    candidates_.push_back(
        {factor, [=, this] { return Multiplied(factor.mistake); }});
  }
}

void MistakeSearch::AddTimeUnits() {
  for (const double scale : kTimeUnits) {
    candidates_.push_back(
        {{.mistake = {.kind = Kind::kTimeUnit, .factor = scale}},
         [=, this] { return WithTimes(scale); }});
  }
}

absl::StatusOr<bool> MistakeSearch::BeatsAgeing(
    const OperatorMistake& exchange,
    const std::vector<HypotheticalRow>& rows) const {
  std::vector<Record> exchanged = parts_;
  for (Record& part : exchanged) {
    Eigen::MatrixXd& values = exchange.outputs ? part.outputs : part.inputs;
    values.row(exchange.channels[0]).swap(values.row(exchange.channels[1]));
  }
  MLE_ASSIGN_OR_RETURN(const ElementResponses responses,
                       ElementResponses::Create(model_, exchanged));
  bool proved = false;
  for (const AsRecorded& fit : as_recorded_) {
    double better = 0.0;
    for (const HypotheticalRow& row : rows) {
      better += FewGainsLogLikelihood(
                    BlockMeans(responses.Row(row.output), fit.block)) -
                FewGainsLogLikelihood(
                    BlockMeans(responses_->Row(row.output), fit.block));
    }
    if (!(better > 0.0)) return false;
    proved = proved || better > kLeastMistakeRatio;
  }
  return proved;
}

double MistakeSearch::ShareOf(int output, int measured,
                              const Series& responses) const {
  Series outputs;
  for (const Record& part : parts_) {
    outputs.emplace_back(part.outputs.row(measured).transpose());
  }
  return responses_->integrates(output)
             ? SimulatedShareOfIncrements(outputs, responses)
             : SimulatedShare(outputs, responses);
}

bool MistakeSearch::Follows(const Hypothesis& hypothesis,
                            const std::vector<HypotheticalRow>& rows) const {
  double claimed = 0.0;
  double recorded = 0.0;
  for (const HypotheticalRow& row : rows) {
    const double corrected = ShareOf(row.output, row.measured, row.claimed);
    const double before = ShareOf(row.output, row.output, sums_[row.output]);
    // No share may fall clearly below zero, or below what it was where that was
    // negative already.
    if (corrected < std::min(before, 0.0) - kSameShare) return false;
    claimed += corrected;
    recorded += std::max(before, 0.0);
  }
  double least = 0.0;
  if (hypothesis.mistake.kind == Kind::kExchanged) {
    const std::vector<int>& channels = hypothesis.mistake.channels;
    least = AreAlike(hypothesis.mistake.outputs, channels[0], channels[1])
                ? kLeastShare
                : kLeastShareOfOthers;
  }
  return claimed > recorded &&
         claimed > least * static_cast<double>(rows.size());
}

std::optional<double> MistakeSearch::Judge(
    const Hypothesis& hypothesis,
    const std::vector<HypotheticalRow>& rows) const {
  if (!Follows(hypothesis, rows)) return std::nullopt;
  const bool other_times = hypothesis.mistake.kind == Kind::kTimeUnit;
  bool proved = false;
  double least = std::numeric_limits<double>::infinity();
  for (const AsRecorded& fit : as_recorded_) {
    // By how much the claim is better than the model as it is.
    double better = 0.0;
    for (const HypotheticalRow& row : rows) {
      better +=
          LogLikelihood(row.output, row.measured, row.claimed, fit.block) -
          fit.fixed(row.output);
    }
    least = std::min(least, better);
    if (!(least > 0.0)) return std::nullopt;
    if (hypothesis.complete && fit.block == 1 &&
        better < fit.free_gains - kCompleteRatio) {
      return std::nullopt;
    }
    double without = 0.0;
    for (const HypotheticalRow& row : rows) {
      without += LogLikelihood(row.output, row.output, row.without, fit.block) -
                 fit.fixed(row.output);
    }
    const double rival = std::max(other_times ? fit.free_gains : 0.0, without);
    proved = proved || better > rival + kLeastMistakeRatio;
  }
  if (!proved) return std::nullopt;
  return least;
}

absl::Status MistakeSearch::JudgeAll() {
  std::vector<absl::StatusOr<std::optional<double>>> ratios(candidates_.size());
  ParallelFor(static_cast<int>(candidates_.size()), threads_, [&](int c) {
    const auto rows = candidates_[c].rows();
    ratios[c] = rows.ok()
                    ? Judge(candidates_[c].hypothesis, *rows)
                    : absl::StatusOr<std::optional<double>>(rows.status());
  });
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    const OperatorMistake& mistake = candidates_[c].hypothesis.mistake;
    MLE_ASSIGN_OR_RETURN(const std::optional<double> better, ratios[c]);
    if (!better.has_value() ||
        (best_.has_value() && best_->log_likelihood >= *better)) {
      continue;
    }
    if (mistake.kind == Kind::kExchanged) {
      MLE_ASSIGN_OR_RETURN(const std::vector<HypotheticalRow> rows,
                           candidates_[c].rows());
      MLE_ASSIGN_OR_RETURN(const bool beats, BeatsAgeing(mistake, rows));
      if (!beats) continue;
    }
    best_ = mistake;
    if (mistake.kind == Kind::kSign) best_->factor = -1.0;
    best_->log_likelihood = *better;
  }
  return absl::OkStatus();
}

std::vector<HypotheticalRow> MistakeSearch::WithTimes(double scale) const {
  std::vector<HypotheticalRow> rows;
  const absl::StatusOr<ElementResponses> responses =
      ElementResponses::Create(model_, parts_, scale);
  // Dead times of too many samples, say: then it is not this unit.
  if (!responses.ok()) return rows;
  std::vector<Series> sums = SumsOf(*responses, parts_, p(), m());
  for (const int i : moving_) {
    rows.push_back({i, i, std::move(sums[i]), Times(0.0, sums_[i])});
  }
  return rows;
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
  MLE_ASSIGN_OR_RETURN(responses_, ElementResponses::Create(model_, parts_));
  sums_ = SumsOf(*responses_, parts_, p(), m());
  FitAsRecorded();
  for (const bool outputs : {false, true}) AddExchanges(outputs);
  for (const bool outputs : {false, true}) AddFactors(outputs);
  AddTimeUnits();
  MLE_RETURN_IF_ERROR(JudgeAll());
  return best_;
}

}  // namespace

absl::StatusOr<std::optional<OperatorMistake>> FindOperatorMistake(
    const ProcessModel& model, const std::vector<Record>& records,
    int threads) {
  const std::vector<Record> parts = AroundSetPointChanges(
      records, kMostResponses / model.num_inputs() / NumElements(model));
  double samples = 0.0;
  for (const Record& part : parts) samples += part.samples();
  if (samples < kLeastBlocks) return std::optional<OperatorMistake>();
  return MistakeSearch(model, parts, threads).Run();
}

}  // namespace mle
