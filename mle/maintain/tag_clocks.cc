#include "mle/maintain/tag_clocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/Core"
#include "absl/strings/str_format.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/whitened_fit.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

constexpr double kLeastClockSamples = 100.0;
// Most samples of the elements' responses, each of which is delayed some thirty
// times.
constexpr double kMostClockSamples = 2e7;
constexpr double kLeastClockNats = 10.0;
constexpr double kSignificantClock = 0.01;
constexpr double kClockDeviations = 3.0;
// Samples, tried on both sides; between the best and its neighbours it is
// searched.
constexpr std::array<double, 10> kClockDelays = {0.5, 1,  2,  3,  5,
                                                 8,   12, 18, 27, 40};
constexpr double kPrecision = 0.02;  // samples
constexpr double kCurvatureStep = 0.5;

// Column `column` of the responses `delay` samples later, between samples on
// straight lines.
Eigen::VectorXd Delayed(const Eigen::MatrixXd& responses, Eigen::Index column,
                        double delay) {
  const auto whole = static_cast<Eigen::Index>(std::floor(delay));
  const double fraction = delay - static_cast<double>(whole);
  const Eigen::Index n = responses.rows();
  Eigen::VectorXd result(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index newer = std::clamp<Eigen::Index>(k - whole, 0, n - 1);
    const Eigen::Index older = std::max<Eigen::Index>(newer - 1, 0);
    result(k) = (1.0 - fraction) * responses(newer, column) +
                fraction * responses(older, column);
  }
  return result;
}

// `delays` (m), in samples.
WhitenedData Delay(const WhitenedData& row, const Eigen::VectorXd& delays) {
  WhitenedData delayed = row;
  for (Eigen::MatrixXd& responses : delayed.responses) {
    const Eigen::MatrixXd before = responses;
    for (Eigen::Index j = 0; j < delays.size(); ++j) {
      if (delays(j) != 0.0) responses.col(j) = Delayed(before, j, delays(j));
    }
  }
  return delayed;
}

// A row with the model's gains, some of its elements delayed.
class DelayedRow {
 public:
  // `which` (m): 1 where delayed.
  DelayedRow(const WhitenedData& row, const Eigen::RowVectorXd& which)
      : row_(row) {
    for (Eigen::Index j = 0; j < which.size(); ++j) {
      if (which(j) != 0.0) columns_.push_back(j);
    }
    const Eigen::VectorXd others = 1.0 - which.transpose().array();
    sum_.outputs = row.outputs;
    for (const Eigen::MatrixXd& responses : row.responses) {
      others_.emplace_back(responses * others);
      sum_.responses.emplace_back(others_.back());
    }
  }

  double LogLikelihood(double delay) {
    for (std::size_t w = 0; w < others_.size(); ++w) {
      sum_.responses[w] = others_[w];
      for (const Eigen::Index j : columns_) {
        sum_.responses[w] += Delayed(row_.responses[w], j, delay);
      }
    }
    return WhitenedLogLikelihood(sum_, Eigen::VectorXd::Ones(1));
  }

 private:
  const WhitenedData& row_;
  std::vector<Eigen::Index> columns_;
  std::vector<Eigen::VectorXd> others_;  // what all others make of the inputs
  WhitenedData sum_;                     // what all do, one column
};

// With free gains and, to first order, delays.
double FreeLogLikelihood(const WhitenedData& row) {
  const Eigen::Index m = row.responses.front().cols();
  WhitenedData more = row;
  for (Eigen::MatrixXd& responses : more.responses) {
    responses.conservativeResize(Eigen::NoChange, 2 * m);
    for (Eigen::Index j = 0; j < m; ++j) {
      responses.col(m + j) =
          Delayed(responses, j, 1.0) - Delayed(responses, j, -1.0);
    }
  }
  Eigen::VectorXd start = Eigen::VectorXd::Zero(2 * m);
  start.head(m).setOnes();
  return FitWhitenedGains(more, start).log_likelihood;
}

struct BestDelay {
  double delay = 0.0;  // samples
  double error = 0.0;
  double log_likelihood = 0.0;
};

// Searches the delay of elements `which` (p × m, 1 where delayed) of all rows
// together, of no less than `least` samples.
class DelaySearch {
 public:
  DelaySearch(const std::vector<WhitenedData>& rows, Eigen::MatrixXd which,
              double least = -std::numeric_limits<double>::infinity())
      : rows_(rows), which_(std::move(which)), least_(least) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (!which_.row(row).isZero()) {
        delayed_.emplace_back(rows_[i], which_.row(row));
      }
    }
  }

  // With the model's gains.
  double At(double delay) {
    double sum = 0.0;
    for (DelayedRow& row : delayed_) sum += row.LogLikelihood(delay);
    return sum;
  }

  double FreeAt(double delay) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (which_.row(row).isZero()) continue;
      sum += FreeLogLikelihood(
          Delay(rows_[i], delay * which_.row(row).transpose()));
    }
    return sum;
  }

  BestDelay Find() {
    BestDelay best{.delay = 0.0, .log_likelihood = At(0.0)};
    double low = std::max(least_, -kClockDelays[0]);
    double high = kClockDelays[0];
    for (const double sign : {-1.0, 1.0}) {
      for (std::size_t d = 0; d < kClockDelays.size(); ++d) {
        const double delay = std::max(least_, sign * kClockDelays[d]);
        const double likelihood = At(delay);
        if (likelihood <= best.log_likelihood) continue;
        best = {.delay = delay, .log_likelihood = likelihood};
        const double less = d > 0 ? kClockDelays[d - 1] : 0.0;
        const double more =
            kClockDelays[std::min(d + 1, kClockDelays.size() - 1)];
        low = std::max(least_, std::min(sign * less, sign * more));
        high = std::max(sign * less, sign * more);
      }
    }
    Refine(low, high, best);
    const double curvature =
        (2.0 * best.log_likelihood - At(best.delay - kCurvatureStep) -
         At(best.delay + kCurvatureStep)) /
        (kCurvatureStep * kCurvatureStep);
    best.error = 1.0 / std::sqrt(std::max(curvature, 1e-12));
    return best;
  }

 private:
  // Golden section.
  void Refine(double low, double high, BestDelay& best) {
    constexpr double kGolden = 0.381966;
    while (high - low > kPrecision) {
      const bool upper = high - best.delay > best.delay - low;
      const double at = upper ? best.delay + kGolden * (high - best.delay)
                              : best.delay - kGolden * (best.delay - low);
      const double likelihood = At(at);
      if (likelihood > best.log_likelihood) {
        (upper ? low : high) = best.delay;
        best.delay = at;
        best.log_likelihood = likelihood;
      } else {
        (upper ? high : low) = at;
      }
    }
  }

  const std::vector<WhitenedData>& rows_;
  Eigen::MatrixXd which_;
  double least_;
  std::vector<DelayedRow> delayed_;
};

// The number of elements that the model has in the rows of `which`.
double FreeElements(const Eigen::MatrixXd& dead_times,
                    const Eigen::MatrixXd& which) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < which.rows(); ++i) {
    if (!which.row(i).isZero()) {
      sum += static_cast<double>((dead_times.row(i).array() >= 0.0).count());
    }
  }
  return sum;
}

// The delay of a row or column if it explains everything. `dead_times` (p × m)
// are the model's, in samples, −1 where it has no element: that of an element
// by itself does not fall below 0. `free` (p): FreeLogLikelihood() of the rows.
std::optional<BestDelay> ExplainByDelay(const std::vector<WhitenedData>& rows,
                                        const Eigen::VectorXd& free,
                                        const Eigen::MatrixXd& which,
                                        const Eigen::MatrixXd& dead_times) {
  DelaySearch search(rows, which);
  const double before = search.At(0.0);
  // Free elements gain too little: no delay explains the records, or needs to.
  const double free_of_all = free.dot(which.rowwise().maxCoeff());
  if (free_of_all < before + kLeastClockNats / 2.0) return std::nullopt;
  BestDelay best = search.Find();
  if (best.log_likelihood < before + kLeastClockNats ||
      std::abs(best.delay) < kClockDeviations * best.error ||
      ChiSquareTail(2.0 * (search.FreeAt(best.delay) - best.log_likelihood),
                    2.0 * FreeElements(dead_times, which)) <
          kSignificantClock) {
    return std::nullopt;
  }
  for (Eigen::Index i = 0; i < which.rows(); ++i) {
    for (Eigen::Index j = 0; j < which.cols(); ++j) {
      if (which(i, j) == 0.0) continue;
      Eigen::MatrixXd one = Eigen::MatrixXd::Zero(which.rows(), which.cols());
      one(i, j) = 1.0;
      DelaySearch alone(rows, one, -dead_times(i, j));
      const double gain = alone.Find().log_likelihood - alone.At(0.0);
      if (before + gain > best.log_likelihood - kLeastClockNats) {
        return std::nullopt;
      }
    }
  }
  best.log_likelihood -= before;
  return best;
}

// A dead time of the elements `which` becomes negative by the delay.
bool IsImpossible(const ProcessModel& model, const Eigen::MatrixXd& which,
                  double delay, double error) {
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (which(i, j) == 0.0) continue;
      if (model.element(i, j).delay() + delay < -kClockDeviations * error) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

std::string TagClock::Describe(const ProcessModel& model) const {
  const std::string& name =
      is_output ? model.outputs()[channel].name : model.inputs()[channel].name;
  const std::string& unit = model.time_unit();
  std::string text = absl::StrFormat(
      "The time stamps of %s seem to be %.3g %s %s (standard error %.2g %s)",
      name, std::abs(late), unit, late > 0.0 ? "late" : "early", error, unit);
  text += impossible ? ": without that a dead time would have to be negative."
                     : absl::StrFormat(
                           ", or all dead times %s it have changed by as much.",
                           is_output ? "to" : "from");
  return text;
}

void CorrectClock(const TagClock& clock, std::vector<Record>& records) {
  for (Record& record : records) {
    const double late = clock.late / record.sample_time;
    // The time between the sample read at k + whole and the one after it.
    const auto whole = static_cast<Eigen::Index>(
        clock.is_output ? std::floor(late) : std::round(late));
    const double fraction =
        clock.is_output ? late - static_cast<double>(whole) : 0.0;
    Eigen::MatrixXd& rows = clock.is_output ? record.outputs : record.inputs;
    const Eigen::RowVectorXd read = rows.row(clock.channel);
    const auto at = [&](Eigen::Index k) {
      return k >= 0 && k < read.size()
                 ? read(k)
                 : std::numeric_limits<double>::quiet_NaN();
    };
    for (Eigen::Index k = 0; k < read.size(); ++k) {
      rows(clock.channel, k) =
          fraction > 0.0
              ? (1.0 - fraction) * at(k + whole) + fraction * at(k + whole + 1)
              : at(k + whole);
    }
  }
}

absl::StatusOr<std::vector<TagClock>> FindTagClocks(
    const ProcessModel& model, const std::vector<Record>& records,
    int threads) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  const std::vector<Record> parts =
      AroundSetPointChanges(records, kMostClockSamples / NumElements(model));
  double samples = 0.0;
  for (const Record& part : parts) samples += part.samples();
  std::vector<TagClock> clocks;
  if (samples < kLeastClockSamples) return clocks;
  MLE_ASSIGN_OR_RETURN(const ElementResponses responses,
                       ElementResponses::Create(model, parts));
  std::vector<WhitenedData> rows(p);
  Eigen::VectorXd free(p);
  const double sample_time = parts.front().sample_time;
  Eigen::MatrixXd elements = Eigen::MatrixXd::Zero(p, m);
  Eigen::MatrixXd dead_times = Eigen::MatrixXd::Zero(p, m);
  ParallelFor(p, threads, [&](int i) {
    rows[i] = responses.Row(i);
    free(i) = FreeLogLikelihood(rows[i]);
    for (int j = 0; j < m; ++j) {
      elements(i, j) = model.element(i, j).IsZero() ? 0.0 : 1.0;
      dead_times(i, j) = model.element(i, j).IsZero()
                             ? -1.0
                             : model.element(i, j).delay() / sample_time;
    }
  });
  const auto examine = [&](bool output,
                           int channel) -> std::optional<TagClock> {
    Eigen::MatrixXd which = Eigen::MatrixXd::Zero(p, m);
    if (output) {
      which.row(channel) = elements.row(channel);
    } else {
      which.col(channel) = elements.col(channel);
    }
    if (which.sum() < 2.0) return std::nullopt;
    const std::optional<BestDelay> best =
        ExplainByDelay(rows, free, which, dead_times);
    if (!best.has_value()) return std::nullopt;
    const double delay = best->delay * sample_time;
    const double error = best->error * sample_time;
    return TagClock{output,
                    channel,
                    output ? delay : -delay,
                    error,
                    best->log_likelihood,
                    IsImpossible(model, which, delay, error)};
  };
  const auto examine_all = [&](bool outputs, int channels) {
    std::vector<std::optional<TagClock>> found(channels);
    ParallelFor(channels, threads,
                [&](int c) { found[c] = examine(outputs, c); });
    for (const std::optional<TagClock>& clock : found) {
      if (clock.has_value()) clocks.push_back(*clock);
    }
  };
  examine_all(true, p);
  if (!clocks.empty()) return clocks;
  examine_all(false, m);
  const auto likeliest = std::max_element(
      clocks.begin(), clocks.end(), [](const TagClock& a, const TagClock& b) {
        return a.log_likelihood < b.log_likelihood;
      });
  if (clocks.size() > 1) clocks = {*likeliest};
  return clocks;
}

}  // namespace mle
