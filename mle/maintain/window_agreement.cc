#include "mle/maintain/window_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/data/stretches.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/whitened_fit.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/innovations_filter.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFalseAlarms = 1e-6;
constexpr double kLeastDifference = 0.05;
constexpr int kLeastWindows = 4;  // to say what differences follow
constexpr double kExplained = 0.5;
constexpr double kLeastWindowNats = 10.0;
constexpr double kMostWindowSamples = 8000.0;
constexpr double kLeastWindowSamples = 100.0;
constexpr double kCollinearGains = 1e-6;
// That a window is long at least, and for each gain of its own.
constexpr double kMemories = 5.0;
constexpr double kMemoriesOfAGain = 1.5;
constexpr double kNoiseParameters = 13.0;  // of whitened_fit.h, and the drift
// From none to that of an output that is hardly more than a walk.
constexpr double kDriftRatios[] = {0.0,  1e-6, 1e-5, 1e-4, 3e-4, 1e-3,
                                   3e-3, 1e-2, 3e-2, 0.1,  1.0};

// Responses of all windows one below the other, times `factors` (one for each
// window), columns of unit length.
MatrixXd Stack(const WhitenedData& data, const VectorXd& factors) {
  Eigen::Index rows = 0;
  for (const VectorXd& output : data.outputs) rows += output.size();
  MatrixXd columns(rows, data.responses.front().cols());
  Eigen::Index row = 0;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    columns.middleRows(row, data.outputs[w].size()) =
        factors(static_cast<Eigen::Index>(w)) * data.responses[w];
    row += data.outputs[w].size();
  }
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    const double norm = columns.col(j).norm();
    if (norm > 0.0) columns.col(j) /= norm;
  }
  return columns;
}

struct LeastSquares {
  double squares = 0.0;  // of the residuals
  double parameters = 0.0;
  VectorXd fitted;
};

LeastSquares Fit(const std::vector<MatrixXd>& blocks, const VectorXd& y) {
  Eigen::Index columns = 0;
  for (const MatrixXd& block : blocks) columns += block.cols();
  MatrixXd all(y.size(), columns);
  // Columns of zeros explain nothing.
  Eigen::Index kept = 0;
  for (const MatrixXd& block : blocks) {
    for (const auto& column : block.colwise()) {
      if (!column.isZero(0.0)) all.col(kept++) = column;
    }
  }
  all.conservativeResize(Eigen::NoChange, kept);
  if (kept == 0) {
    return {.squares = y.squaredNorm(),
            .parameters = 0.0,
            .fitted = VectorXd::Zero(y.size())};
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr;
  qr.setThreshold(kCollinearGains);
  qr.compute(all);
  LeastSquares fit;
  fit.parameters = static_cast<double>(qr.rank());
  fit.fitted = all * qr.solve(y);
  fit.squares = (y - fit.fitted).squaredNorm();
  return fit;
}

// Every window with gains of its own.
WhitenedData Separate(const WhitenedData& row) {
  WhitenedData separate = row;
  const Eigen::Index m = row.responses.front().cols();
  for (std::size_t w = 0; w < row.outputs.size(); ++w) {
    const auto n = static_cast<Eigen::Index>(row.outputs.size());
    separate.responses[w] = MatrixXd::Zero(row.outputs[w].size(), m * n);
    separate.responses[w].middleCols(static_cast<Eigen::Index>(w) * m, m) =
        row.responses[w];
  }
  return separate;
}

// How long a window has to be, in the model's longest dead times and lags.
double LeastMemories(const ProcessModel& model) {
  int most = 0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    int gains = 0;
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (!model.element(i, j).IsZero()) ++gains;
    }
    most = std::max(most, gains);
  }
  return std::max(kMemories, kMemoriesOfAGain * most);
}

// Windows joined to the next ones of their stretch until they are `least`
// samples long. In short ones the inputs are mostly what a controller makes of
// noise that has not been forgotten, and gains of their own are biased by it.
std::vector<StretchPart> JoinShort(const std::vector<StretchPart>& windows,
                                   double least) {
  std::vector<StretchPart> joined;
  bool open = false;  // the last one takes more
  for (const StretchPart& window : windows) {
    if (open && Adjoin(joined.back(), window)) {
      joined.back().samples += window.samples;
    } else {
      joined.push_back(window);
    }
    open = joined.back().samples < least;
  }
  // What a stretch ends with belongs to what comes before it.
  std::vector<StretchPart> long_ones;
  for (const StretchPart& part : joined) {
    if (part.samples < least && !long_ones.empty() &&
        Adjoin(long_ones.back(), part)) {
      long_ones.back().samples += part.samples;
    } else {
      long_ones.push_back(part);
    }
  }
  return long_ones;
}

// The windows of stretches, without the first samples of a stretch, which moves
// before it disturb.
WhitenedData Later(const WhitenedData& row,
                   const std::vector<StretchPart>& windows, int forgetting) {
  WhitenedData later;
  for (const StretchPart& window : windows) {
    const int n = window.samples;
    const int lost = std::min(std::max(forgetting - window.first, 0), n / 4);
    later.outputs.emplace_back(
        row.outputs[window.stretch].segment(window.first + lost, n - lost));
    later.responses.emplace_back(row.responses[window.stretch].middleRows(
        window.first + lost, n - lost));
  }
  return later;
}

// Mean 0, standard deviation 1; zero if all are alike.
VectorXd Standardised(VectorXd values) {
  values.array() -= values.mean();
  const double size =
      std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
  return size > 0.0 ? VectorXd(values / size) : values;
}

// What windows differ in.
struct Circumstances {
  VectorXd times;                // W
  std::vector<VectorXd> levels;  // p: W
};

WindowAgreement::Cause CauseOf(const WhitenedData& white, const VectorXd& y,
                               const Circumstances& of, int output,
                               const LeastSquares& common,
                               const LeastSquares& free, double variance) {
  using Cause = WindowAgreement::Cause;
  const auto count = static_cast<int>(of.times.size());
  if (count < kLeastWindows) return Cause::kUnknown;
  const MatrixXd base = Stack(white, VectorXd::Ones(count));
  const LeastSquares by_time = Fit({base, Stack(white, of.times)}, y);
  std::vector<MatrixXd> blocks = {base};
  const int outputs = static_cast<int>(of.levels.size());
  for (int o = 0; o < outputs; ++o) {
    if (o == output || count >= outputs + 3) {
      blocks.push_back(Stack(white, of.levels[o]));
    }
  }
  const LeastSquares by_point = Fit(blocks, y);
  const double penalty = std::log(static_cast<double>(y.size()));
  const auto nats = [&](const LeastSquares& fit) {
    return 0.5 * ((common.squares - fit.squares) / variance -
                  (fit.parameters - common.parameters) * penalty);
  };
  const auto explains = [&](const LeastSquares& fit) {
    return common.squares - fit.squares >=
           kExplained * (common.squares - free.squares);
  };
  const double more = nats(by_time) - nats(by_point);
  if (more > kLeastWindowNats && explains(by_time)) return Cause::kTime;
  if (more < -kLeastWindowNats && explains(by_point)) {
    return Cause::kOperatingPoint;
  }
  return Cause::kUnknown;
}

struct Filtered {
  WhitenedData data;
  double log_determinant = 0.0;  // of the noise of all outputs
};

// Every window through the filter of a random walk in white noise.
Filtered WithoutDrift(const WhitenedData& data, double ratio) {
  Filtered filtered{.data = data};
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    if (data.outputs[w].size() == 0) continue;
    std::vector<int> times(data.outputs[w].size());
    std::iota(times.begin(), times.end(), 0);
    const InnovationsFilter filter(times, {.ratio = ratio});
    filtered.log_determinant += filter.log_determinant();
    filter.Apply(filtered.data.outputs[w]);
    for (Eigen::Index j = 0; j < data.responses[w].cols(); ++j) {
      if (data.responses[w].col(j).isZero(0.0)) continue;
      filter.Apply(filtered.data.responses[w].col(j));
    }
  }
  return filtered;
}

// The likeliest ratio of a random walk's increments to white noise in what
// gains of each window leave of the output, an autoregression beside it.
double LikeliestDrift(const WhitenedData& separate, const VectorXd& gains) {
  WhitenedData rest;
  for (std::size_t w = 0; w < separate.outputs.size(); ++w) {
    rest.outputs.emplace_back(separate.outputs[w] -
                              separate.responses[w] * gains);
    rest.responses.emplace_back(rest.outputs.back().size(), 0);
  }
  double best_ratio = 0.0;
  double best = -std::numeric_limits<double>::infinity();
  for (const double ratio : kDriftRatios) {
    const Filtered filtered = WithoutDrift(rest, ratio);
    const double likelihood = WhitenedLogLikelihood(filtered.data, {}) -
                              0.5 * filtered.log_determinant;
    if (likelihood > best) {
      best = likelihood;
      best_ratio = ratio;
    }
  }
  return best_ratio;
}

// Of a window's response by its own gains from that by common ones, less what
// noise makes of it, relative to the response, or to that of an average window
// where that is larger.
double LargestDifference(const WhitenedData& white, const LeastSquares& common,
                         const LeastSquares& free, double noise) {
  const double average =
      common.fitted.squaredNorm() / static_cast<double>(white.outputs.size());
  double largest = 0.0;
  Eigen::Index first = 0;
  for (const VectorXd& window : white.outputs) {
    const auto part = [&](const LeastSquares& one) {
      return one.fitted.segment(first, window.size());
    };
    const double size = std::max(part(common).squaredNorm(), average);
    const double squares = (part(free) - part(common)).squaredNorm() - noise;
    if (size > 0.0 && squares > 0.0) {
      largest = std::max(largest, std::sqrt(squares / size));
    }
    first += window.size();
  }
  return largest;
}

WindowAgreement TestOutput(const WhitenedData& row, const Circumstances& of,
                           int output) {
  WindowAgreement agreement;
  agreement.windows = static_cast<int>(of.times.size());
  const WhitenedData separate = Separate(row);
  const Eigen::Index m = row.responses.front().cols();
  // With common gains first: gains of each window take drift for responses, and
  // from what they leave at first none would be seen. By the gains that they
  // are with this drift then, for what common gains leave may look like drift.
  VectorXd gains = VectorXd::Ones(m * agreement.windows);
  WhitenedData filtered;
  for (int round = 0; round < 2; ++round) {
    filtered = WithoutDrift(separate, LikeliestDrift(separate, gains)).data;
    gains = FitWhitenedGains(filtered, gains).gains;
  }
  const WhitenedData whole = Whiten(filtered, gains);
  WhitenedData white = whole;
  std::vector<double> values;
  for (std::size_t w = 0; w < whole.outputs.size(); ++w) {
    white.responses[w] =
        whole.responses[w].middleCols(static_cast<Eigen::Index>(w) * m, m);
    values.insert(values.end(), whole.outputs[w].begin(),
                  whole.outputs[w].end());
  }
  const VectorXd y = Eigen::Map<VectorXd>(
      values.data(), static_cast<Eigen::Index>(values.size()));
  const VectorXd ones = VectorXd::Ones(agreement.windows);
  const LeastSquares common = Fit({Stack(white, ones)}, y);
  const LeastSquares free = Fit({Stack(whole, ones)}, y);
  const double more = free.parameters - common.parameters;
  const double left =
      static_cast<double>(y.size()) - free.parameters - kNoiseParameters;
  if (!(more > 0.0) || !(left > 0.0) || !(free.squares > 0.0)) return agreement;
  const double variance = free.squares / left;
  agreement.p_value =
      FisherTail(std::max(common.squares - free.squares, 0.0) / more / variance,
                 more, left);
  agreement.difference = LargestDifference(
      whole, common, free, variance * more / (agreement.windows - 1.0));
  agreement.possible = LargestDifference(whole, common, free, 0.0);
  if (!agreement.agree()) {
    agreement.cause = CauseOf(white, y, of, output, common, free, variance);
  }
  return agreement;
}

}  // namespace

std::string_view NameOf(WindowAgreement::Cause cause) {
  switch (cause) {
    case WindowAgreement::Cause::kUnknown:
      return "unknown";
    case WindowAgreement::Cause::kTime:
      return "time";
    case WindowAgreement::Cause::kOperatingPoint:
      return "operating_point";
  }
  return "";
}

bool WindowAgreement::agree() const {
  return !(p_value < kFalseAlarms) || !(difference > kLeastDifference);
}

std::string WindowAgreement::Describe(const std::string& output) const {
  const std::string begin = absl::StrFormat(
      "The responses of %s differ from window to window, by up to %.2g %% (p = "
      "%.1g for none)",
      output, 100.0 * difference, p_value);
  switch (cause) {
    case Cause::kTime:
      return absl::StrCat(
          begin,
          ". The differences follow time, not the operating point: the plant "
          "changed during the records. Records after the change would settle "
          "it.");
    case Cause::kOperatingPoint:
      return absl::StrCat(
          begin,
          ". The differences follow the operating point, not time: the plant "
          "is "
          "not linear over the records. Records at one operating point would "
          "settle it.");
    case Cause::kUnknown:
      break;
  }
  return absl::StrCat(
      begin, ". From ", windows,
      " windows it cannot be told whether the plant changed during the records "
      "or is not linear over their operating points. ",
      windows < kLeastWindows ? "Four windows or more" : "More windows",
      ", at operating points that come back, would settle it.");
}

absl::StatusOr<std::vector<WindowAgreement>> TestWindowAgreement(
    const ProcessModel& model, const std::vector<Record>& windows) {
  std::vector<WindowAgreement> agreements(model.num_outputs());
  if (windows.size() < 2) return agreements;
  const Stretches stretches = JoinAdjoining(windows);
  std::vector<Record> parts;
  for (const Record& stretch : stretches.records) {
    parts.push_back(WithoutGaps(stretch));
  }
  const double memory =
      std::ceil(LongestMemory(model) / parts.front().sample_time);
  const std::vector<StretchPart> joined =
      JoinShort(stretches.windows, LeastMemories(model) * memory);
  const auto count = static_cast<Eigen::Index>(joined.size());
  if (count < 2) return agreements;
  Circumstances of;
  of.times.resize(count);
  of.levels.assign(model.num_outputs(), VectorXd::Zero(count));
  double samples = 0.0;
  for (Eigen::Index w = 0; w < count; ++w) {
    const StretchPart& window = joined[w];
    const Record& part = parts[window.stretch];
    samples += window.samples;
    of.times(w) = 0.5 * (part.time(window.first) +
                         part.time(window.first + window.samples - 1));
    for (int i = 0; i < model.num_outputs(); ++i) {
      of.levels[i](w) =
          part.outputs.row(i).segment(window.first, window.samples).mean();
    }
  }
  if (samples < kLeastWindowSamples) return agreements;
  of.times = Standardised(of.times);
  for (VectorXd& level : of.levels) level = Standardised(level);
  MLE_ASSIGN_OR_RETURN(const ElementResponses responses,
                       ElementResponses::Create(model, parts));
  const auto length = static_cast<int>(std::ceil(samples / kMostWindowSamples));
  const auto forgetting = static_cast<int>(std::min(memory, 1e9));
  for (int i = 0; i < model.num_outputs(); ++i) {
    const WhitenedData row = Later(responses.Row(i), joined, forgetting);
    agreements[i] = TestOutput(BlockMeans(row, length), of, i);
  }
  return agreements;
}

}  // namespace mle
