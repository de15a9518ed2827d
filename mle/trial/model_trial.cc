#include "mle/trial/model_trial.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "Eigen/Cholesky"
#include "mle/base/status.h"
#include "mle/maintain/correct.h"
#include "mle/trial/set_point_shapes.h"
#include "mle/trial/trial_evidence.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of a settling time, which is five slowest time constants.
constexpr double kRowsOfSettling = 40.0;
constexpr double kRowsOfTimeConstant = kRowsOfSettling / 5.0;
// Time constant of the shapes over the slowest one.
constexpr double kShapeTime = 0.6;
// Of a settling time: what is used before a change and after it.
constexpr double kBefore = 0.25;
constexpr double kAfter = 1.25;
// Horizons of the loss, in settling times.
constexpr double kHorizons[] = {0.04, 0.2, 0.6};
// Elements change where their step responses differ by more than this.
constexpr double kSameResponse = 1e-3;
// Windows' lengths at rest before any response is judged.
constexpr double kLeastAtRest = 5.0;
// The same of all rows, where there is too little rest.
constexpr double kLeastOfAll = 20.0;
// Share of the rows of a response that must be known.
constexpr double kLeastKnown = 0.8;
constexpr double kRidge = 1e-3;
constexpr double kMostRows = 1e6;

int InRows(double share, double rows_of_settling) {
  return std::max(1, static_cast<int>(std::lround(share * rows_of_settling)));
}

// Outputs whose responses differ.
std::vector<int> ChangedOutputs(const ProcessModel& in_use,
                                const ProcessModel& proposed, double settling) {
  constexpr int kSamples = 201;
  const double step = settling / (kSamples - 1);
  const ResponseDistance distance =
      CompareResponses(in_use.ComputeStepResponse(step, kSamples),
                       proposed.ComputeStepResponse(step, kSamples));
  std::vector<int> changed;
  for (int i = 0; i < in_use.num_outputs(); ++i) {
    if (distance.elements.row(i).maxCoeff() > kSameResponse) {
      changed.push_back(i);
    }
  }
  return changed;
}

ProcessModel RowsOf(const ProcessModel& model,
                    const std::vector<int>& outputs) {
  std::vector<OutputChannel> channels;
  for (const int i : outputs) channels.push_back(model.outputs()[i]);
  ProcessModel rows(model.name(), model.time_unit(), model.inputs(), channels);
  for (std::size_t r = 0; r < outputs.size(); ++r) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      rows.element(static_cast<int>(r), j) = model.element(outputs[r], j);
    }
  }
  return rows;
}

double SumOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// The last column of `values` becomes `column`; of more than `most` columns the
// first goes.
void Append(const VectorXd& column, Index most, MatrixXd& values) {
  if (values.cols() == most) {
    values.leftCols(most - 1) = values.rightCols(most - 1).eval();
  } else {
    values.conservativeResize(column.size(), values.cols() + 1);
  }
  values.rightCols(1) = column;
}

// Those that move in the window.
MatrixXd MovingShapes(const MatrixXd& shapes) {
  std::vector<Index> moving;
  for (Index q = 0; q < shapes.rows(); ++q) {
    if ((shapes.row(q).array() != shapes(q, 0)).any()) moving.push_back(q);
  }
  return shapes(moving, Eigen::all);
}

VectorXd ZeroUnknown(const VectorXd& values) {
  return values.array().isFinite().select(values, 0.0);
}

// What set points drive of the residuals in a response.
struct Left {
  double in_use = 0.0;
  double proposed = 0.0;
  int shapes = 0;
};

// Without the eighth of the responses in which the proposed model leaves most:
// a disturbance that comes in one by chance is not the model's.
void TakeShare(std::vector<Left> left, TrialVerdict& verdict) {
  std::sort(left.begin(), left.end(), [](const Left& a, const Left& b) {
    return a.proposed < b.proposed;
  });
  left.resize(left.size() - left.size() / 8);
  Left sum;
  for (const Left& response : left) {
    sum.in_use += response.in_use;
    sum.proposed += response.proposed;
    sum.shapes += response.shapes;
  }
  if (!(sum.in_use > 0.0)) return;
  verdict.left_share = std::max(sum.proposed, 0.0) / sum.in_use;
  // Of χ² with as many degrees of freedom.
  verdict.left_error = std::sqrt(2.0 * sum.shapes) / sum.in_use;
}

}  // namespace

bool TrialResponse::judged() const {
  return std::any_of(deviations.begin(), deviations.end(),
                     [](double deviation) { return deviation > 0.0; });
}

double TrialResponse::difference() const {
  return judged() ? SumOf(gains) / SumOf(deviations) : 0.0;
}

double TrialResponse::size() const {
  return judged() ? SumOf(sizes) / SumOf(deviations) : 0.0;
}

std::string_view NameOf(TrialAdvice advice) {
  switch (advice) {
    case TrialAdvice::kWait:
      return "wait";
    case TrialAdvice::kAdopt:
      return "adopt";
    case TrialAdvice::kDrop:
      return "drop";
    case TrialAdvice::kKeep:
      return "keep";
    case TrialAdvice::kRollBack:
      return "roll_back";
  }
  return "";
}

absl::StatusOr<ModelTrial> ModelTrial::Create(const ProcessModel& in_use,
                                              const ProcessModel& proposed,
                                              double sample_time,
                                              const TrialOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(in_use.Validate());
  MLE_RETURN_IF_ERROR(proposed.Validate());
  MLE_RETURN_IF_ERROR(CheckSameChannels(in_use, "the model in use", proposed,
                                        "the proposed model"));
  const double settling =
      std::max(SettlingTime(in_use), SettlingTime(proposed));
  if (!(sample_time > 0.0) || !(settling / sample_time <= kMostRows)) {
    return InvalidArgument("trial: the sample time is ", sample_time,
                           "; it must be > 0, and the models settle in ",
                           settling, " ", in_use.time_unit(), ", at most ",
                           kMostRows, " samples");
  }
  ModelTrial trial;
  trial.num_outputs_ = in_use.num_outputs();
  trial.sample_time_ = sample_time;
  trial.options_ = options;
  TrialModels& models = trial.models_;
  models.outputs = ChangedOutputs(in_use, proposed, settling);
  if (models.outputs.empty()) {
    return absl::InvalidArgumentError(
        "trial: the proposed model is the model in use: no step response "
        "differs by more than 0.1 %");
  }
  models.in_use = RowsOf(in_use, models.outputs);
  models.proposed = RowsOf(proposed, models.outputs);
  MLE_RETURN_IF_ERROR(CheckNotIntegrating(models.in_use, "a trial"));
  MLE_RETURN_IF_ERROR(CheckNotIntegrating(models.proposed, "a trial"));
  for (int j = 0; j < in_use.num_inputs(); ++j) {
    for (int i = 0; i < models.in_use.num_outputs(); ++i) {
      if (models.in_use.element(i, j).IsZero() &&
          models.proposed.element(i, j).IsZero()) {
        continue;
      }
      models.inputs.push_back(j);
      break;
    }
  }
  RowPlan& plan = trial.plan_;
  plan.samples = std::max(
      1, static_cast<int>(settling / (kRowsOfSettling * sample_time)));
  const double row = plan.samples * sample_time;
  plan.forgetting = static_cast<int>(std::ceil(settling / sample_time)) + 1;
  plan.pole = std::exp(-row * kRowsOfSettling /
                       (settling * kShapeTime * kRowsOfTimeConstant));
  const double rows_of_settling = settling / row;
  trial.before_ = InRows(kBefore, rows_of_settling);
  trial.after_ = InRows(kAfter, rows_of_settling);
  for (const double horizon : kHorizons) {
    const int rows = InRows(horizon, rows_of_settling);
    if (trial.horizons_.empty() || rows > trial.horizons_.back()) {
      trial.horizons_.push_back(rows);
    }
  }
  const Index window = trial.before_ + 1 + trial.after_;
  const auto r = static_cast<Index>(models.outputs.size());
  const Index q = Index{kShapesOfSetPoint} * trial.num_outputs_;
  TrialState& state = trial.state_;
  state.shapes.resize(q, 0);
  state.differences.resize(r, 0);
  state.in_use.resize(r, 0);
  state.proposed.resize(r, 0);
  state.normal.setZero(q, q);
  state.moments.setZero(q, r);
  const Variogram nothing = {VectorXd::Zero(window - 1),
                             VectorXd::Zero(window - 1)};
  state.noise.assign(models.outputs.size(), nothing);
  state.always = state.noise;
  const std::vector<double> zeros(trial.horizons_.size(), 0.0);
  state.losses.assign(models.outputs.size(), {zeros, zeros, zeros});
  return trial;
}

void ModelTrial::AddLosses() {
  const Index newest = state_.in_use.cols() - 1;
  for (std::size_t i = 0; i < models_.outputs.size(); ++i) {
    const auto at = static_cast<Index>(i);
    StepLosses& losses = state_.losses[i];
    for (std::size_t h = 0; h < horizons_.size(); ++h) {
      const Index before = newest - horizons_[h];
      if (before < 0) continue;
      const double in_use =
          state_.in_use(at, newest) - state_.in_use(at, before);
      const double proposed =
          state_.proposed(at, newest) - state_.proposed(at, before);
      if (!std::isfinite(in_use) || !std::isfinite(proposed)) continue;
      losses.in_use[h] += in_use * in_use;
      losses.proposed[h] += proposed * proposed;
      losses.counts[h] += 1.0;
    }
  }
}

void ModelTrial::AddNoise() {
  const MatrixXd middle = 0.5 * (state_.in_use + state_.proposed);
  const Index newest = middle.cols() - 1;
  const std::int64_t rest = state_.rows - 1 - (state_.last_move + after_ + 1);
  for (std::size_t i = 0; i < models_.outputs.size(); ++i) {
    const auto at = static_cast<Index>(i);
    for (Index l = 1; l <= newest; ++l) {
      const double change = middle(at, newest) - middle(at, newest - l);
      if (!std::isfinite(change)) continue;
      const double square = 0.5 * change * change;
      state_.always[i].sums(l - 1) += square;
      state_.always[i].counts(l - 1) += 1.0;
      if (l > rest) continue;
      state_.noise[i].sums(l - 1) += square;
      state_.noise[i].counts(l - 1) += 1.0;
    }
  }
}

TrialResponse ModelTrial::Compare(Index begin, Index length) const {
  const std::size_t r = models_.outputs.size();
  TrialResponse response = {.time = state_.end,
                            .changes = state_.changes,
                            .gains = std::vector<double>(r),
                            .sizes = std::vector<double>(r),
                            .deviations = std::vector<double>(r),
                            .in_use = std::vector<double>(r),
                            .proposed = std::vector<double>(r)};
  const MatrixXd shapes = state_.shapes.middleCols(begin, length);
  const MatrixXd moving = MovingShapes(shapes);
  MatrixXd normal = state_.normal;
  const double size = normal.diagonal().maxCoeff();
  if (!(size > 0.0) || moving.rows() == 0) return response;
  normal.diagonal() *= 1.0 + kRidge;
  normal.diagonal().array() += 1e-9 * size;
  const MatrixXd driven =
      normal.ldlt().solve(state_.moments).transpose() * shapes;  // z
  for (std::size_t i = 0; i < r; ++i) {
    const auto at = static_cast<Index>(i);
    const VectorXd in_use = state_.in_use.row(at).segment(begin, length);
    const VectorXd proposed = state_.proposed.row(at).segment(begin, length);
    std::vector<bool> known(static_cast<std::size_t>(length));
    double count = 0.0;
    for (Index k = 0; k < length; ++k) {
      known[k] = std::isfinite(in_use(k)) && std::isfinite(proposed(k));
      count += known[k] ? 1.0 : 0.0;
    }
    const auto windows = [&](const Variogram& noise) {
      return noise.counts(length - 2) / static_cast<double>(length);
    };
    const Variogram& noise = windows(state_.noise[i]) >= kLeastAtRest
                                 ? state_.noise[i]
                                 : state_.always[i];
    const double rest = windows(noise);
    if (count < kLeastKnown * static_cast<double>(length) ||
        rest < (&noise == &state_.noise[i] ? kLeastAtRest : kLeastOfAll)) {
      continue;
    }
    const MatrixXd loss = LossMatrix(noise, known);
    const VectorXd e0 = ZeroUnknown(in_use);
    const VectorXd e1 = ZeroUnknown(proposed);
    const ExplainedLoss of_in_use = ExplainLoss(loss, count - 1.0, moving, e0);
    const ExplainedLoss of_proposed =
        ExplainLoss(loss, count - 1.0, moving, e1);
    response.shapes += static_cast<int>(moving.rows());
    response.in_use[i] = of_in_use.explained;
    response.proposed[i] = of_proposed.explained;
    const VectorXd z = driven.row(at).transpose();
    const VectorXd weights = loss * z;
    response.gains[i] = 0.5 * weights.dot(e0 + e1);
    response.sizes[i] = std::max(weights.dot(z), 0.0);
    const double more =
        std::max(1.0, std::min(of_in_use.unusual, of_proposed.unusual));
    response.deviations[i] =
        std::sqrt(response.sizes[i] * more * rest / (rest - 2.0));
  }
  return response;
}

void ModelTrial::LearnFrom(Index column) {
  for (const int h : horizons_) {
    if (h > column) continue;
    const VectorXd move =
        state_.differences.col(column) - state_.differences.col(column - h);
    const VectorXd shape =
        state_.shapes.col(column) - state_.shapes.col(column - h);
    if (!move.allFinite() || shape.isZero(0.0)) continue;
    state_.normal += shape * shape.transpose() / h;
    state_.moments += shape * move.transpose() / h;
  }
}

void ModelTrial::EndResponse(bool judge) {
  const Index length = before_ + 1 + after_;
  const Index begin = state_.shapes.cols() - length;
  if (judge) state_.responses.push_back(Compare(begin, length));
  for (Index k = before_; k < length; ++k) LearnFrom(begin + k);
  state_.response = TrialState::kLongAgo;
  state_.changes = 0;
}

void ModelTrial::AddRow(const TrialRows& rows, Index k, bool judge) {
  const Index most = before_ + 1 + after_;
  Append(rows.shapes.col(k), most, state_.shapes);
  Append(rows.differences.col(k), most, state_.differences);
  Append(rows.in_use.col(k), most, state_.in_use);
  Append(rows.proposed.col(k), most, state_.proposed);
  const std::int64_t row = state_.rows++;
  const int changes = rows.changes[static_cast<std::size_t>(k)];
  if (changes > 0) {
    state_.last_move = row;
    if (state_.response < 0 && row >= before_) state_.response = row;
  }
  AddLosses();
  AddNoise();
  if (state_.response < 0) {
    LearnFrom(state_.shapes.cols() - 1);
    return;
  }
  state_.changes += changes;
  if (row - state_.response >= after_) EndResponse(judge);
}

absl::Status ModelTrial::Use(const Record& record, int first, bool judge) {
  MLE_RETURN_IF_ERROR(record.Validate());
  if (record.num_outputs() != num_outputs_ ||
      record.num_inputs() != models_.in_use.num_inputs()) {
    return InvalidArgument("trial: the record has ", record.num_outputs(),
                           " outputs and ", record.num_inputs(),
                           " inputs, the models have ", num_outputs_, " and ",
                           models_.in_use.num_inputs());
  }
  if (std::abs(record.sample_time - sample_time_) > 1e-9 * sample_time_) {
    return InvalidArgument("trial: the sample time of the record is ",
                           record.sample_time, ", that of the trial is ",
                           sample_time_);
  }
  if (record.set_points.size() == 0) {
    return absl::InvalidArgumentError(
        "trial: the record has no set points; a trial rests on their changes");
  }
  if (first < 0 || first > record.samples()) {
    return InvalidArgument("trial: the first sample is ", first,
                           "; the record has ", record.samples());
  }
  if (first == record.samples()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const TrialRows rows,
                       MakeTrialRows(models_, record, first, plan_));
  const bool goes_on = state_.rows > 0 && std::abs(record.time(first) -
                                                   state_.end) <= sample_time_;
  if (!goes_on) {
    state_.rows = 0;
    state_.response = state_.last_move = TrialState::kLongAgo;
    state_.changes = 0;
    for (Index k = 0; k < rows.first; ++k) {
      if (rows.changes[static_cast<std::size_t>(k)] > 0) {
        state_.last_move = k - rows.first;
      }
    }
    for (MatrixXd* values : {&state_.shapes, &state_.differences,
                             &state_.in_use, &state_.proposed}) {
      values->conservativeResize(Eigen::NoChange, 0);
    }
  }
  for (Index k = rows.first; k < rows.shapes.cols(); ++k) {
    const auto end = static_cast<int>(
        std::min<Index>(first + (k - rows.first + 1) * plan_.samples,
                        record.samples()));
    state_.end = record.time(end);
    AddRow(rows, k, judge);
  }
  return absl::OkStatus();
}

absl::Status ModelTrial::Learn(const Record& record, int first) {
  return Use(record, first, /*judge=*/false);
}

absl::Status ModelTrial::Look(const Record& record, int first) {
  return Use(record, first, /*judge=*/true);
}

void ModelTrial::Adopt() {
  if (state_.adopted) return;
  state_.adopted = true;
  std::swap(models_.in_use, models_.proposed);
  std::swap(state_.in_use, state_.proposed);
  state_.differences *= -1.0;
  state_.moments *= -1.0;
  for (StepLosses& losses : state_.losses) {
    for (auto* values : {&losses.in_use, &losses.proposed, &losses.counts}) {
      std::fill(values->begin(), values->end(), 0.0);
    }
  }
  state_.before = std::exchange(state_.responses, {});
}

TrialVerdict ModelTrial::verdict() const {
  TrialVerdict verdict;
  const std::size_t r = models_.outputs.size();
  TrialEvidence better;
  TrialEvidence worse;
  std::vector<TrialEvidence> worse_outputs(r);
  std::vector<Left> left;
  verdict.advice = state_.adopted ? TrialAdvice::kKeep : TrialAdvice::kWait;
  for (const TrialResponse& response : state_.responses) {
    verdict.changes += response.changes;
    ++verdict.responses;
    if (!response.judged()) {
      ++verdict.not_judged;
      continue;
    }
    better.Add(response.difference(), 0.5 * response.size());
    worse.Add(-response.difference(), 0.5 * response.size());
    double against = 0.0;
    for (std::size_t i = 0; i < r; ++i) {
      if (response.deviations[i] > 0.0) {
        worse_outputs[i].Add(-response.gains[i] / response.deviations[i],
                             0.5 * response.sizes[i] / response.deviations[i]);
      }
      against += std::exp(worse_outputs[i].log()) / static_cast<double>(r);
    }
    against = 0.5 * (against + std::exp(worse.log()));
    left.push_back({.in_use = SumOf(response.in_use),
                    .proposed = SumOf(response.proposed),
                    .shapes = response.shapes});
    TakeShare(left, verdict);
    verdict.evidence.push_back(
        {response.time, better.log(), std::log(against)});
    verdict.advice = Advise(verdict);
  }
  double count = 0.0;
  double ratios = 0.0;
  for (const StepLosses& losses : state_.losses) {
    for (std::size_t h = 0; h < losses.counts.size(); ++h) {
      if (!(losses.in_use[h] > 0.0)) continue;
      count += 1.0;
      ratios += losses.proposed[h] / losses.in_use[h];
    }
  }
  if (count > 0.0) verdict.loss_ratio = std::sqrt(ratios / count);
  return verdict;
}

// What follows from the last evidence, the advice before it, and the rest.
TrialAdvice ModelTrial::Advise(const TrialVerdict& verdict) const {
  const int judged = verdict.responses - verdict.not_judged;
  const double limit = -std::log(options_.level);
  const TrialEvidencePoint& last = verdict.evidence.back();
  if (judged < options_.least_changes) return verdict.advice;
  if (state_.adopted) {
    return last.log_for >= limit ? TrialAdvice::kRollBack : verdict.advice;
  }
  if (verdict.advice == TrialAdvice::kDrop) return verdict.advice;
  if (last.log_against >= limit) return TrialAdvice::kDrop;
  if (last.log_for >= limit &&
      verdict.left_share <= options_.left_share + verdict.left_error) {
    return TrialAdvice::kAdopt;
  }
  return verdict.advice == TrialAdvice::kWait &&
                 judged >= options_.most_changes
             ? TrialAdvice::kDrop
             : verdict.advice;
}

}  // namespace mle
