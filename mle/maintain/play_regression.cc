#include "mle/maintain/play_regression.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/maintain/play_filters.h"
#include "mle/maintain/ranked_qr.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr int kOrder = 24;
constexpr double kLeastDegrees = 100.0;
constexpr double kEnough = 0.25;  // nats that another round of a fit may gain
constexpr double kOutlier = 5.0;  // robust standard deviations
constexpr std::array<double, 5> kDrifts = {0.0, 0.01, 0.03, 0.1, 0.3};
constexpr double kCollinearPlay = 1e-7;
constexpr double kLeastSquares = 1e-300;  // have a logarithm
constexpr std::array<double, 13> kWidths = {0.01, 0.015, 0.02, 0.03, 0.04,
                                            0.06, 0.08,  0.11, 0.15, 0.2,
                                            0.27, 0.36,  0.5};

// A series of all parts, one after the other, through the filter.
Eigen::VectorXd Whitened(const Eigen::VectorXd& filter,
                         const std::vector<Eigen::VectorXd>& series) {
  const Eigen::Index order = filter.size() - 1;
  Eigen::Index rows = 0;
  for (const Eigen::VectorXd& part : series) rows += part.size() - order;
  Eigen::VectorXd whitened(rows);
  Eigen::Index at = 0;
  for (const Eigen::VectorXd& part : series) {
    whitened.segment(at, part.size() - order) = ApplyFilter(filter, part);
    at += part.size() - order;
  }
  return whitened;
}

std::vector<Eigen::VectorXd> ColumnOf(
    const std::vector<Eigen::MatrixXd>& matrices, Eigen::Index column) {
  std::vector<Eigen::VectorXd> series;
  for (const Eigen::MatrixXd& matrix : matrices) {
    series.emplace_back(matrix.col(column));
  }
  return series;
}

// Whitened columns of unit length, those that are zero left out; rows that are
// not used are zero.
Eigen::MatrixXd ColumnsThroughFilter(const WhitenedData& data,
                                     const Eigen::VectorXd& filter,
                                     const Eigen::VectorXd& used) {
  const Eigen::Index width = data.responses.front().cols();
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(used.size(), std::max<Eigen::Index>(width, 1));
  Eigen::Index kept = 0;
  for (Eigen::Index c = 0; c < width; ++c) {
    const std::vector<Eigen::VectorXd> series = ColumnOf(data.responses, c);
    if (std::all_of(series.begin(), series.end(),
                    [](const auto& part) { return part.isZero(0.0); })) {
      continue;
    }
    columns.col(kept) = Whitened(filter, series).cwiseProduct(used);
    const double norm = columns.col(kept).norm();
    if (!(norm > 0.0)) continue;
    columns.col(kept++) /= norm;
  }
  columns.conservativeResize(Eigen::NoChange, std::max<Eigen::Index>(kept, 1));
  return columns;
}

double MedianSize(const Eigen::VectorXd& values) {
  Eigen::VectorXd sizes = values.cwiseAbs();
  double* const middle = sizes.data() + sizes.size() / 2;
  std::nth_element(sizes.data(), middle, sizes.data() + sizes.size());
  return *middle;
}

}  // namespace

Eigen::RowVectorXd PassThroughPlay(const Eigen::RowVectorXd& input,
                                   double width) {
  Eigen::RowVectorXd valve(input.size());
  double at = input.size() > 0 ? input(0) : 0.0;
  for (Eigen::Index k = 0; k < input.size(); ++k) {
    at = std::clamp(at, input(k) - width / 2.0, input(k) + width / 2.0);
    valve(k) = at;
  }
  return valve;
}

absl::StatusOr<PlayRegression> PlayRegression::Create(
    const ProcessModel& model, const std::vector<Record>& parts,
    const std::vector<Eigen::MatrixXd>& bad, int threads) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  PlayRegression regression;
  regression.parts_ = &parts;
  regression.bad_ = &bad;
  regression.threads_ = threads;
  regression.model_ = model;
  regression.ranges_.resize(m);
  for (int j = 0; j < m; ++j) {
    double low = parts.front().inputs(j, 0);
    double high = low;
    for (const Record& part : parts) {
      low = std::min(low, part.inputs.row(j).minCoeff());
      high = std::max(high, part.inputs.row(j).maxCoeff());
    }
    regression.ranges_(j) = high - low;
  }
  regression.widths_ = Eigen::VectorXd::Constant(m, -1.0);
  regression.responses_.resize(m);
  regression.differences_.resize(m);
  regression.merits_.assign(m, std::vector<Merits>(p));
  regression.outputs_.resize(p);
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      if (model.element(i, j).IsZero()) continue;
      regression.outputs_[i].inputs.push_back(j);
    }
  }
  MLE_RETURN_IF_ERROR(regression.SetWidths(Eigen::VectorXd::Zero(m)));
  return regression;
}

bool PlayRegression::empty() const {
  return std::none_of(outputs_.begin(), outputs_.end(),
                      [](const OutputState& output) {
                        return output.degrees >= kLeastDegrees;
                      });
}

bool PlayRegression::IsUsed(int output, int input) const {
  return outputs_[output].degrees >= kLeastDegrees &&
         !model_.element(output, input).IsZero();
}

absl::StatusOr<std::vector<Eigen::MatrixXd>> PlayRegression::Simulate(
    int input, const std::vector<int>& outputs,
    const std::vector<Eigen::RowVectorXd>& moves) const {
  std::vector<OutputChannel> channels;
  for (const int i : outputs) channels.push_back(model_.outputs()[i]);
  ProcessModel column("column", model_.time_unit(), {model_.inputs()[input]},
                      std::move(channels));
  for (std::size_t n = 0; n < outputs.size(); ++n) {
    column.element(static_cast<int>(n), 0) = model_.element(outputs[n], input);
  }
  std::vector<Eigen::MatrixXd> responses;
  for (std::size_t w = 0; w < moves.size(); ++w) {
    MLE_ASSIGN_OR_RETURN(
        const Eigen::MatrixXd simulated,
        SimulateResponse(column, (*parts_)[w].sample_time, moves[w]));
    responses.emplace_back(simulated.transpose());
  }
  return responses;
}

absl::StatusOr<std::shared_ptr<const PlayRegression::Responses>>
PlayRegression::RespondTo(int input, double width) const {
  std::vector<Eigen::RowVectorXd> moves;
  std::vector<Eigen::RowVectorXd> squares;
  const double range = ranges_(input) > 0.0 ? ranges_(input) : 1.0;
  for (const Record& part : *parts_) {
    moves.push_back(PassThroughPlay(part.inputs.row(input), width));
    squares.emplace_back((moves.back().array() - moves.back().mean()).square() /
                         range);
  }
  auto responses = std::make_shared<Responses>();
  std::vector<int> all(model_.num_outputs());
  std::iota(all.begin(), all.end(), 0);
  MLE_ASSIGN_OR_RETURN(responses->linear, Simulate(input, all, moves));
  MLE_ASSIGN_OR_RETURN(responses->square, Simulate(input, all, squares));
  return responses;
}

absl::StatusOr<std::shared_ptr<const PlayRegression::Differences>>
PlayRegression::Differ(int input, const std::vector<int>& outputs) const {
  auto differences = std::make_shared<Differences>();
  for (const double share : kWidths) {
    const double width = share * ranges_(input);
    std::vector<Eigen::RowVectorXd> moves;
    for (const Record& part : *parts_) {
      const Eigen::RowVectorXd asked = part.inputs.row(input);
      moves.emplace_back(PassThroughPlay(asked, width) -
                         PassThroughPlay(asked, widths_(input)));
    }
    MLE_ASSIGN_OR_RETURN(differences->emplace_back(),
                         Simulate(input, outputs, moves));
  }
  return differences;
}

WhitenedData PlayRegression::DataOf(int output,
                                    const AllResponses& responses) const {
  WhitenedData data;
  const double sample_time = parts_->front().sample_time;
  const std::vector<int>& inputs = outputs_[output].inputs;
  for (std::size_t w = 0; w < parts_->size(); ++w) {
    data.outputs.emplace_back((*parts_)[w].outputs.row(output).transpose());
    Eigen::MatrixXd& columns = data.responses.emplace_back(
        (*parts_)[w].samples(), (kPlayFilters + 1) * inputs.size());
    Eigen::Index at = 0;
    for (const int j : inputs) {
      for (const Eigen::VectorXd& column :
           ThroughPlayFilters(model_.element(output, j), sample_time,
                              responses[j]->linear[w].col(output))) {
        columns.col(at++) = column;
      }
      columns.col(at++) = responses[j]->square[w].col(output);
    }
  }
  return data;
}

Eigen::VectorXd PlayRegression::UsedRows(
    int output, int order, const Eigen::VectorXd& innovations) const {
  const double limit = kOutlier * 1.4826 * MedianSize(innovations);
  Eigen::VectorXd used = Eigen::VectorXd::Ones(innovations.size());
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& bad : *bad_) {
    const Eigen::Index rows = bad.cols() - order;
    // A row needs its own sample and `order` before.
    Eigen::Index good_from = 0;
    for (Eigen::Index k = 0; k < bad.cols(); ++k) {
      if (bad(output, k) != 0.0) good_from = k + order + 1;
      if (k < order) continue;
      if (std::abs(innovations(at + k - order)) > limit) {
        good_from = k + order + 1;
      }
      if (k < good_from) used(at + k - order) = 0.0;
    }
    at += rows;
  }
  return used;
}

void PlayRegression::Fit(int output, OutputState& state) const {
  const WhitenedData with_drift = DataOf(output, responses_);
  const auto elements = static_cast<Eigen::Index>(state.inputs.size());
  if (state.start.size() == 0) {
    state.start = Eigen::VectorXd::Zero((kPlayFilters + 1) * elements);
    for (Eigen::Index e = 0; e < elements; ++e) {
      state.start((kPlayFilters + 1) * e) = 1.0;
    }
  }
  WhitenedData data;
  WhitenedFit fit;
  int worse = 0;  // in a row: the likelihood has one hill
  for (const double drift : kDrifts) {
    WhitenedData tried = InnovationsOfDrift(with_drift, drift);
    WhitenedFit fit_tried =
        FitWhitenedGains(tried, state.start, kOrder, kEnough);
    // Others begin where this one has ended.
    state.start = fit_tried.gains;
    if (drift > 0.0 && fit_tried.log_likelihood <= fit.log_likelihood) {
      if (++worse == 2) break;
      continue;
    }
    worse = 0;
    state.drift = drift;
    data = std::move(tried);
    fit = std::move(fit_tried);
  }
  state.filter = WhiteningFilter(data, fit.gains, kOrder);
  state.gains = Eigen::VectorXd::Zero(model_.num_inputs());
  for (Eigen::Index e = 0; e < elements; ++e) {
    state.gains(state.inputs[e]) =
        fit.gains.segment((kPlayFilters + 1) * e, kPlayFilters).sum();
  }
  const Eigen::VectorXd whitened = Whitened(state.filter, data.outputs);
  std::vector<Eigen::VectorXd> rest;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    rest.emplace_back(data.outputs[w] - data.responses[w] * fit.gains);
  }
  state.used = UsedRows(output, kOrder, Whitened(state.filter, rest));
  state.basis = RankedQr(ColumnsThroughFilter(data, state.filter, state.used),
                         kCollinearPlay)
                    .Basis();
  state.residual = whitened.cwiseProduct(state.used);
  // Twice: UpdateMerits() counts on residuals that hold none of the basis.
  for (int time = 0; time < 2; ++time) {
    state.residual -= state.basis * (state.basis.transpose() * state.residual);
  }
  state.degrees =
      state.used.sum() - static_cast<double>(state.basis.cols()) - kOrder;
  state.variance =
      std::max(state.residual.squaredNorm() / std::max(state.degrees, 1.0),
               kLeastSquares);
  ++state.fits;
}

bool PlayRegression::IsMoved(int output, const Eigen::VectorXd& widths) const {
  const std::vector<int>& inputs = outputs_[output].inputs;
  return std::any_of(inputs.begin(), inputs.end(),
                     [&](int j) { return widths(j) != widths_(j); });
}

absl::Status PlayRegression::SetWidths(const Eigen::VectorXd& widths) {
  std::vector<int> moved;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    if (outputs_[i].fits == 0 || IsMoved(i, widths)) moved.push_back(i);
  }
  std::vector<absl::Status> simulated(model_.num_inputs());
  ParallelFor(model_.num_inputs(), threads_, [&](int j) {
    if (widths(j) == widths_(j)) return;
    absl::StatusOr<std::shared_ptr<const Responses>> responses =
        RespondTo(j, widths(j));
    simulated[j] = responses.status();
    if (responses.ok()) responses_[j] = *std::move(responses);
    differences_[j] = nullptr;
  });
  for (const absl::Status& status : simulated) MLE_RETURN_IF_ERROR(status);
  widths_ = widths;
  ParallelFor(static_cast<int>(moved.size()), threads_,
              [&](int n) { Fit(moved[n], outputs_[moved[n]]); });
  return absl::OkStatus();
}

absl::Status PlayRegression::UpdateMerits(int input) {
  const auto is_old = [&](int i) {
    return IsUsed(i, input) && merits_[input][i].fit != outputs_[i].fits;
  };
  std::vector<int> outputs;  // of its elements
  for (int i = 0; i < model_.num_outputs(); ++i) {
    if (!model_.element(i, input).IsZero()) outputs.push_back(i);
  }
  if (std::none_of(outputs.begin(), outputs.end(), is_old)) {
    return absl::OkStatus();
  }
  if (differences_[input] == nullptr) {
    MLE_ASSIGN_OR_RETURN(differences_[input], Differ(input, outputs));
  }
  for (std::size_t n = 0; n < outputs.size(); ++n) {
    const int i = outputs[n];
    if (!is_old(i)) continue;
    const OutputState& state = outputs_[i];
    Eigen::MatrixXd columns(state.residual.size(), kWidths.size());
    for (std::size_t c = 0; c < kWidths.size(); ++c) {
      std::vector<Eigen::VectorXd> series =
          ColumnOf((*differences_[input])[c], static_cast<Eigen::Index>(n));
      for (Eigen::VectorXd& part : series) {
        part = InnovationsOfDrift(part, state.drift);
      }
      columns.col(static_cast<Eigen::Index>(c)) =
          Whitened(state.filter, series).cwiseProduct(state.used);
    }
    const Eigen::MatrixXd explained = state.basis.transpose() * columns;
    const double gain = state.gains(input);
    Merits& merits = merits_[input][i];
    merits.fit = state.fits;
    merits.products =
        columns.transpose() * state.residual * (gain / state.variance);
    merits.sizes =
        (columns.colwise().squaredNorm() - explained.colwise().squaredNorm()) *
        (gain * gain / state.variance);
  }
  return absl::OkStatus();
}

absl::StatusOr<PlayScore> PlayRegression::Score(int input) {
  PlayScore best{.width = widths_(input), .nats = 0.0, .factor = 1.0};
  if (!(ranges_(input) > 0.0)) return best;
  MLE_RETURN_IF_ERROR(UpdateMerits(input));
  Eigen::VectorXd products = Eigen::VectorXd::Zero(kWidths.size());
  Eigen::VectorXd sizes = Eigen::VectorXd::Zero(kWidths.size());
  for (int i = 0; i < model_.num_outputs(); ++i) {
    if (!IsUsed(i, input)) continue;
    products += merits_[input][i].products;
    sizes += merits_[input][i].sizes;
  }
  for (std::size_t c = 0; c < kWidths.size(); ++c) {
    const auto at = static_cast<Eigen::Index>(c);
    const double nats = products(at) - sizes(at) / 2.0;
    if (sizes(at) > 0.0 && nats > best.nats) {
      best = {kWidths[c] * ranges_(input), nats, products(at) / sizes(at)};
    }
  }
  return best;
}

absl::StatusOr<std::vector<PlayScore>> PlayRegression::Scores() {
  const int m = model_.num_inputs();
  std::vector<absl::StatusOr<PlayScore>> scored(m);
  ParallelFor(m, threads_, [&](int j) { scored[j] = Score(j); });
  std::vector<PlayScore> scores;
  for (absl::StatusOr<PlayScore>& score : scored) {
    MLE_ASSIGN_OR_RETURN(scores.emplace_back(), std::move(score));
  }
  return scores;
}

absl::StatusOr<double> PlayRegression::LogLikelihood(
    const Eigen::VectorXd& widths) const {
  AllResponses responses = responses_;
  for (int j = 0; j < model_.num_inputs(); ++j) {
    if (widths(j) == widths_(j)) continue;
    MLE_ASSIGN_OR_RETURN(responses[j], RespondTo(j, widths(j)));
  }
  double sum = 0.0;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    const OutputState& state = outputs_[i];
    if (state.degrees < kLeastDegrees) continue;
    const double squares = IsMoved(i, widths)
                               ? Squares(i, responses, state.used)
                               : SquaresLeft(i, state.used);
    sum -= 0.5 * state.degrees * std::log(squares);
  }
  return sum;
}

absl::StatusOr<double> PlayRegression::OwnNats(int input) {
  if (widths_(input) == 0.0) return 0.0;
  AllResponses without = responses_;
  double sum = 0.0;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    if (!IsUsed(i, input)) continue;
    const OutputState& state = outputs_[i];
    Merits& merits = merits_[input][i];
    if (merits.own_fit != state.fits) {
      if (without[input] == responses_[input]) {
        MLE_ASSIGN_OR_RETURN(without[input], RespondTo(input, 0.0));
      }
      merits.own_fit = state.fits;
      merits.own = 0.5 * state.degrees *
                   std::log(Squares(i, without, state.used) /
                            SquaresLeft(i, state.used));
    }
    sum += merits.own;
  }
  return sum;
}

double PlayRegression::GainOver(const PlayRegression& other) const {
  double gain = 0.0;
  for (int i = 0; i < model_.num_outputs(); ++i) {
    if (!IsMoved(i, other.widths_)) continue;
    const Eigen::VectorXd used =
        outputs_[i].used.cwiseProduct(other.outputs_[i].used);
    const double degrees =
        used.sum() - static_cast<double>(outputs_[i].basis.cols()) - kOrder;
    if (degrees < kLeastDegrees) continue;
    gain += 0.5 * degrees *
            std::log(other.SquaresLeft(i, used) / SquaresLeft(i, used));
  }
  return gain;
}

double PlayRegression::SquaresLeft(int output,
                                   const Eigen::VectorXd& used) const {
  const OutputState& state = outputs_[output];
  return used == state.used ? state.residual.squaredNorm() + kLeastSquares
                            : Squares(output, responses_, used);
}

double PlayRegression::Squares(int output, const AllResponses& responses,
                               const Eigen::VectorXd& used) const {
  const OutputState& state = outputs_[output];
  const WhitenedData data =
      InnovationsOfDrift(DataOf(output, responses), state.drift);
  return RankedQr(ColumnsThroughFilter(data, state.filter, used),
                  kCollinearPlay)
             .SquaresLeft(
                 Whitened(state.filter, data.outputs).cwiseProduct(used)) +
         kLeastSquares;
}

}  // namespace mle
