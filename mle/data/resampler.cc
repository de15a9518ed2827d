#include "mle/data/resampler.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/base/double_limits.h"

namespace mle {
namespace {

// Rows this much farther apart than usual leave nothing out.
constexpr double kUsual = 1.9;
// Rows this many times as frequent as samples are averaged.
constexpr double kAverageFrom = 1.5;
// Times are rounded to a sample within this share of a step.
constexpr double kSampleSnap = 0.01;
// Share of a sample that good rows must cover.
constexpr double kMinCoverage = 0.5 - 1e-9;

}  // namespace

Resampler::Resampler(const ResamplerOptions& options, Sink sink)
    : options_(options),
      sink_(std::move(sink)),
      step_(options.step / options.sample_time),
      split_((options.max_gap + kUsual * options.step) / options.sample_time),
      averages_(kAverageFrom * step_ <= 1.0),
      num_values_(2 * options.num_outputs + options.num_inputs),
      late_(num_values_, 0.0),
      is_point_(num_values_, false),
      empty_{std::vector<double>(num_values_, 0.0),
             std::vector<double>(num_values_, 0.0)},
      sample_(num_values_) {
  for (std::size_t v = 0; v < options_.late.size(); ++v) {
    const double late = options_.late[v] / options_.sample_time;
    const double nearest = std::round(late);
    late_[v] = std::abs(late - nearest) <= kSampleSnap ? nearest : late;
    latest_ = std::max(latest_, late_[v]);
  }
  if (!options_.is_point.empty()) is_point_ = options_.is_point;
}

void Resampler::Begin(double time, const std::vector<double>& values) {
  has_row_ = true;
  begins_ = true;
  origin_ = time;
  at_ = 0.0;
  next_ = 0.0;
  last_ = values;
  SetOutputs(0.0, values);
}

void Resampler::Add(double time, const std::vector<double>& values) {
  if (!has_row_) {
    Begin(time, values);
    return;
  }
  double at = (time - origin_) / options_.sample_time;
  if (at - at_ > split_) {
    Finish();
    Begin(time, values);
    return;
  }
  const double nearest = std::round(at);
  if (std::abs(at - nearest) <= kSampleSnap * std::min(step_, 1.0) &&
      nearest > at_) {
    at = nearest;
  }
  AddSegment(at, &values);
  at_ = at;
  last_ = values;
  EmitUpTo(at - latest_);
}

void Resampler::Finish() {
  if (!has_row_) return;
  const double last = at_;
  AddSegment(at_ + std::max(step_, averages_ ? 0.0 : 1.0), nullptr);
  // Samples whose middle the rows reach.
  EmitUpTo(averages_ ? last + 0.5 * step_ + 0.5 + 1e-9
                     : std::floor(last + 1e-9) + 1.0);
  for (Cell& cell : cells_) {
    std::fill(cell.weight.begin(), cell.weight.end(), 0.0);
    std::fill(cell.sum.begin(), cell.sum.end(), 0.0);
  }
  has_row_ = false;
}

// From the last row to the next, which has `values`, or to nothing.
void Resampler::AddSegment(double to, const std::vector<double>* values) {
  const int p = options_.num_outputs;
  const bool is_usual = to - at_ <= kUsual * step_ + 1e-9;
  // How far a row speaks for the time around it.
  const double reach = is_usual ? to - at_ : std::min(step_, to - at_);
  AddPiece(at_, at_ + reach, 0.0, 2 * p, num_values_, last_);
  if (averages_) AddPiece(at_, at_ + 0.5 * reach, 0.5, 0, p, last_);
  AddSetPoints(to, is_usual);
  if (values == nullptr) return;
  if (!averages_ && is_usual) AddBetween(to, *values);
  // A gap's samples are given away before the row after it takes its own.
  if (!is_usual) EmitUpTo(to - 1.0 - latest_);
  if (averages_) AddPiece(to - 0.5 * reach, to, 0.5, 0, p, *values);
  SetOutputs(to, *values);
}

// `values` hold in [from, to), by their stamps; sample k is the mean over
// [k, k+1) − shift.
void Resampler::AddPiece(double from, double to, double shift, int first,
                         int last, const std::vector<double>& values) {
  for (int v = first; v < last; ++v) {
    if (is_point_[v] || std::isnan(values[v])) continue;
    const double begin = from + shift - late_[v];
    const double end = to + shift - late_[v];
    for (double k = std::max(std::floor(begin), next_); k < end; k += 1.0) {
      const double weight = std::min(end, k + 1.0) - std::max(begin, k);
      if (!(weight > 0.0)) continue;
      // A single row that fills the sample is it, to the last bit.
      Cell& cell = CellAt(k);
      cell.sum[v] += weight * values[v];
      cell.weight[v] += weight;
    }
  }
}

void Resampler::Set(double sample, int value, double to) {
  if (std::isnan(to) || sample < next_) return;
  Cell& cell = CellAt(sample);
  cell.sum[value] = to;
  cell.weight[value] = 1.0;
}

// Set points at the samples from the last row on.
void Resampler::AddSetPoints(double to, bool is_usual) {
  const int p = options_.num_outputs;
  const double held_until = is_usual ? to : std::min(to, at_ + step_);
  for (double k = std::max(std::ceil(at_), next_);
       k < held_until || (k == at_ && k < to); k += 1.0) {
    for (int v = p; v < 2 * p; ++v) Set(k, v, last_[v]);
  }
}

// Outputs that are no means, at the samples between the last row and the next.
void Resampler::AddBetween(double to, const std::vector<double>& values) {
  for (int v = 0; v < options_.num_outputs; ++v) {
    if (is_point_[v]) continue;
    const double begin = at_ - late_[v];
    for (double k = std::floor(begin) + 1.0; k < to - late_[v]; k += 1.0) {
      const double share = (k - begin) / (to - at_);
      Set(k, v, last_[v] + share * (values[v] - last_[v]));
    }
  }
}

// Outputs of a row that stands at a sample, or is taken for the nearest.
void Resampler::SetOutputs(double at, const std::vector<double>& values) {
  for (int v = 0; v < options_.num_outputs; ++v) {
    const double sample = at - late_[v];
    if (is_point_[v]) {
      Set(std::round(sample), v, values[v]);
    } else if (!averages_ && sample == std::floor(sample)) {
      Set(sample, v, values[v]);
    }
  }
}

Resampler::Cell& Resampler::CellAt(double index) {
  const auto at = static_cast<std::size_t>(index - next_);
  while (cells_.size() <= at) {
    cells_.push_back(empty_);
  }
  return cells_[at];
}

// All samples k with k + 1 ≤ end.
void Resampler::EmitUpTo(double end) {
  const double due = std::floor(end - next_);
  if (!(due >= 1.0)) return;
  for (double k = 0.0; k < due; k += 1.0) {
    const auto at = static_cast<std::size_t>(k);
    const Cell& cell = at < cells_.size() ? cells_[at] : empty_;
    for (int v = 0; v < num_values_; ++v) {
      const double weight = cell.weight[v];
      sample_[v] = weight >= kMinCoverage ? cell.sum[v] / weight : kNaN;
    }
    sink_(begins_, origin_ + (next_ + k) * options_.sample_time, sample_);
    begins_ = false;
  }
  next_ += due;
  const auto done = static_cast<std::ptrdiff_t>(
      std::min(due, static_cast<double>(cells_.size())));
  for (std::ptrdiff_t c = 0; c < done; ++c) {
    std::fill(cells_[c].sum.begin(), cells_[c].sum.end(), 0.0);
    std::fill(cells_[c].weight.begin(), cells_[c].weight.end(), 0.0);
  }
  std::rotate(cells_.begin(), cells_.begin() + done, cells_.end());
}

}  // namespace mle
