#include "mle/maintain/window_agreement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/data/stretches.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/element_responses.h"
#include "mle/maintain/whitened_fit.h"
#include "mle/nonlinear/distributions.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFalseAlarms = 1e-6;
constexpr double kLeastDifference = 0.05;
constexpr int kLeastWindows = 4;  // to say what differences follow
constexpr double kExplained = 0.5;
constexpr double kLeastNats = 10.0;
constexpr double kMostSamples = 8000.0;
constexpr double kLeastSamples = 100.0;
constexpr double kCollinear = 1e-6;
constexpr double kNoiseParameters = 12.0;  // of whitened_fit.h

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
  qr.setThreshold(kCollinear);
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
  if (more > kLeastNats && explains(by_time)) return Cause::kTime;
  if (more < -kLeastNats && explains(by_point)) return Cause::kOperatingPoint;
  return Cause::kUnknown;
}

WindowAgreement TestOutput(const WhitenedData& row, const Circumstances& of,
                           int output) {
  WindowAgreement agreement;
  agreement.windows = static_cast<int>(of.times.size());
  const WhitenedData separate = Separate(row);
  const WhitenedFit fit = FitWhitenedGains(
      separate, VectorXd::Ones(separate.responses.front().cols()));
  const WhitenedData whole = Whiten(separate, fit.gains);
  const Eigen::Index m = row.responses.front().cols();
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
  Eigen::Index first = 0;
  for (const VectorXd& window : whole.outputs) {
    const auto part = [&](const LeastSquares& one) {
      return one.fitted.segment(first, window.size());
    };
    const double size = part(common).norm();
    if (size > 0.0) {
      agreement.difference = std::max(
          agreement.difference, (part(free) - part(common)).norm() / size);
    }
    first += window.size();
  }
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
  Circumstances of;
  const auto count = static_cast<Eigen::Index>(windows.size());
  of.times.resize(count);
  of.levels.assign(model.num_outputs(), VectorXd::Zero(count));
  double samples = 0.0;
  for (Eigen::Index w = 0; w < count; ++w) {
    const StretchPart& window = stretches.windows[w];
    const Record& part = parts[window.stretch];
    samples += window.samples;
    of.times(w) = 0.5 * (part.time(window.first) +
                         part.time(window.first + window.samples - 1));
    for (int i = 0; i < model.num_outputs(); ++i) {
      of.levels[i](w) =
          part.outputs.row(i).segment(window.first, window.samples).mean();
    }
  }
  if (samples < kLeastSamples) return agreements;
  of.times = Standardised(of.times);
  for (VectorXd& level : of.levels) level = Standardised(level);
  MLE_ASSIGN_OR_RETURN(const ElementResponses responses,
                       ElementResponses::Create(model, parts, 1.0));
  const auto length = static_cast<int>(std::ceil(samples / kMostSamples));
  const auto forgetting = static_cast<int>(std::min(
      std::ceil(LongestMemory(model) / parts.front().sample_time), 1e9));
  for (int i = 0; i < model.num_outputs(); ++i) {
    const WhitenedData row =
        Later(responses.Row(Assignment::AsRecorded(model), i),
              stretches.windows, forgetting);
    agreements[i] = TestOutput(BlockMeans(row, length), of, i);
  }
  return agreements;
}

}  // namespace mle
