#include "mle/trial/model_trial.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "mle/base/status.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/select_output.h"
#include "mle/trial/change_window.h"
#include "mle/trial/set_point_shapes.h"
#include "mle/trial/trial_rows.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of a settling time, which is five slowest time constants.
constexpr double kRowsOfSettling = 40.0;
constexpr double kTimeConstants = 5.0;  // of a settling time
// Time constant of the shapes over the slowest one.
constexpr double kShapeTime = 0.6;
// Of a settling time: what is used before a change and after it.
constexpr double kBefore = 0.25;
constexpr double kAfter = 1.25;
// Horizons of the loss, in settling times.
constexpr double kHorizons[] = {0.04, 0.2, 0.6};
// Elements change where their step responses differ by more than this.
constexpr double kSameResponse = 1e-3;
// Of the regression on shapes: a share of each, and of the largest.
constexpr double kShapeRidge = 1e-3;
constexpr double kLeastShape = 1e-9;
constexpr double kMostRows = 1e6;

int InRows(double share, double rows_of_settling) {
  return std::max(1, static_cast<int>(std::lround(share * rows_of_settling)));
}

// Outputs whose responses differ.
std::vector<int> ChangedOutputs(const ProcessModel& in_use,
                                const ProcessModel& proposed) {
  const MatrixXd distances = CompareElements(in_use, proposed);
  std::vector<int> changed;
  for (int i = 0; i < in_use.num_outputs(); ++i) {
    if (distances.row(i).maxCoeff() > kSameResponse) changed.push_back(i);
  }
  return changed;
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

}  // namespace

MatrixXd CompareElements(const ProcessModel& from, const ProcessModel& to) {
  constexpr int kSamples = 201;
  const double step =
      std::max(SettlingTime(from), SettlingTime(to)) / (kSamples - 1);
  return CompareResponses(from.ComputeStepResponse(step, kSamples),
                          to.ComputeStepResponse(step, kSamples))
      .elements;
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
  if (HasTransforms(in_use) || HasTransforms(proposed)) {
    return absl::InvalidArgumentError(
        "trial: it compares linear models, and one of these has a transform; "
        "correct records of the next weeks instead");
  }
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
  models.outputs = ChangedOutputs(in_use, proposed);
  if (models.outputs.empty()) {
    return absl::InvalidArgumentError(
        "trial: the proposed model is the model in use: no step response "
        "differs by more than 0.1 %");
  }
  models.in_use = SelectPart(in_use, models.outputs);
  models.proposed = SelectPart(proposed, models.outputs);
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
  trial.PlanRows(settling);
  return trial;
}

void ModelTrial::PlanRows(double settling) {
  plan_.samples = std::max(
      1, static_cast<int>(settling / (kRowsOfSettling * sample_time_)));
  const double rows = settling / (plan_.samples * sample_time_);
  plan_.forgetting = static_cast<int>(std::ceil(settling / sample_time_)) + 1;
  plan_.pole = std::exp(-kTimeConstants / (kShapeTime * rows));
  before_ = InRows(kBefore, rows);
  after_ = InRows(kAfter, rows);
  for (const double horizon : kHorizons) {
    const int ahead = InRows(horizon, rows);
    if (horizons_.empty() || ahead > horizons_.back()) {
      horizons_.push_back(ahead);
    }
  }
  const auto r = static_cast<Index>(models_.outputs.size());
  state_.differences.resize(r, 0);
  state_.in_use.resize(r, 0);
  state_.proposed.resize(r, 0);
  const Index lags = before_ + after_;
  const Variogram nothing = {VectorXd::Zero(lags), VectorXd::Zero(lags)};
  state_.noise.assign(models_.outputs.size(), nothing);
  state_.always = state_.noise;
  const std::vector<double> zeros(horizons_.size(), 0.0);
  state_.losses.assign(models_.outputs.size(), {zeros, zeros, zeros});
}

absl::StatusOr<ModelTrial> ModelTrial::Resume(const ProcessModel& in_use,
                                              const ProcessModel& proposed,
                                              double sample_time,
                                              const TrialOptions& options,
                                              TrialState state) {
  MLE_ASSIGN_OR_RETURN(ModelTrial trial,
                       Create(in_use, proposed, sample_time, options));
  if (!Fits(state, trial.models_.outputs.size(),
            trial.before_ + 1 + trial.after_, trial.horizons_.size())) {
    return absl::DataLossError("trial: its state is one of other models");
  }
  if (state.adopted) {
    std::swap(trial.models_.in_use, trial.models_.proposed);
  }
  trial.state_ = std::move(state);
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
  TrialResponse response = {.time = state_.end, .changes = state_.changes};
  const MatrixXd shapes = state_.shapes.middleCols(begin, length);
  const MatrixXd moving = MovingShapes(shapes);
  MatrixXd normal = state_.normal;
  const double size = normal.diagonal().maxCoeff();
  MatrixXd driven = MatrixXd::Zero(state_.moments.cols(), length);  // z
  if (size > 0.0) {
    normal.diagonal() *= 1.0 + kShapeRidge;
    normal.diagonal().array() += kLeastShape * size;
    driven = normal.ldlt().solve(state_.moments).transpose() * shapes;
  }
  for (std::size_t i = 0; i < models_.outputs.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const OutputComparison output =
        CompareOutput(state_.noise[i], state_.always[i],
                      state_.in_use.row(at).segment(begin, length),
                      state_.proposed.row(at).segment(begin, length),
                      driven.row(at).transpose(), moving);
    response.gains.push_back(output.gain);
    response.sizes.push_back(output.size);
    response.deviations.push_back(output.deviation);
    response.in_use.push_back(output.in_use);
    response.proposed.push_back(output.proposed);
    if (output.compared) {
      response.shapes += static_cast<int>(moving.rows());
    }
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
  (judge ? state_.responses : state_.learned).push_back(Compare(begin, length));
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

void ModelTrial::BeginAnew(const TrialRows& rows) {
  state_.rows = 0;
  state_.response = state_.last_move = TrialState::kLongAgo;
  state_.changes = 0;
  for (Index k = 0; k < rows.first; ++k) {
    if (rows.changes[static_cast<std::size_t>(k)] > 0) {
      state_.last_move = k - rows.first;
    }
  }
  for (MatrixXd* values : {&state_.shapes, &state_.differences, &state_.in_use,
                           &state_.proposed}) {
    values->conservativeResize(Eigen::NoChange, 0);
  }
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
  if (first < 0 || first > record.samples()) {
    return InvalidArgument("trial: the first sample is ", first,
                           "; the record has ", record.samples());
  }
  if (first == record.samples()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const TrialRows rows,
                       MakeTrialRows(models_, record, first, plan_));
  const bool by_hand = record.set_points.size() == 0;
  if (state_.normal.size() == 0) {
    const Index q = rows.shapes.rows();
    state_.shapes.resize(q, 0);
    state_.normal.setZero(q, q);
    state_.moments.setZero(q, state_.in_use.rows());
    state_.by_hand = by_hand;
  }
  if (state_.by_hand != by_hand) {
    return absl::InvalidArgumentError(
        "trial: some records have set points, others have not");
  }
  const bool goes_on =
      state_.rows > 0 &&
      std::abs(record.time(first) - state_.end) <= 1.5 * sample_time_;
  if (!goes_on) BeginAnew(rows);
  for (Index k = rows.first; k < rows.shapes.cols(); ++k) {
    const auto end = static_cast<int>(std::min<Index>(
        first + (k - rows.first + 1) * plan_.samples, record.samples()));
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
  state_.learned.clear();
}

}  // namespace mle
