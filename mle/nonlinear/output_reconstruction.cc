#include "mle/nonlinear/output_reconstruction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/robust_statistics.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/amplitude_fit.h"
#include "mle/nonlinear/innovations_filter.h"
#include "mle/nonlinear/robust_loss.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Elements = std::vector<std::optional<ElementResponse>>;

// Samples on each side of the median at the beginning: so many that bursts of
// nearly as many are the smaller part.
constexpr int kMedianHalfWidth = 25;
constexpr int kMaxReweightings = 50;
// ρ of an output without elements, if the noise's own is smaller.
constexpr double kSmallestNoiseRatio = 1e-4;

// The elements of one output.
absl::StatusOr<Elements> ElementsOf(const ProcessModel& model, int i) {
  Elements elements(model.num_inputs());
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.element(i, j).IsZero()) continue;
    absl::StatusOr<ElementResponse> element =
        ElementResponse::Create(model.element(i, j));
    if (!element.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "expected outputs: element of output \"", model.outputs()[i].name,
          "\", input \"", model.inputs()[j].name,
          "\": ", element.status().message()));
    }
    elements[j] = *std::move(element);
  }
  return elements;
}

double RatioOf(const Elements& elements, const NoiseEstimate& noise,
               double sample_time) {
  double ratio = kSmallestNoiseRatio;
  double fastest = std::numeric_limits<double>::infinity();
  for (const auto& element : elements) {
    if (element.has_value()) {
      fastest = std::min(fastest, element->initial_values().time_scale);
    }
  }
  if (std::isfinite(fastest)) ratio = std::pow(sample_time / fastest, 2);
  return std::max(ratio, noise.ratio);
}

// x over samples begin … end − 1, whose inputs are known.
VectorXd ResponseOfElements(const Elements& elements, const Record& record,
                            int begin, int end) {
  VectorXd response = VectorXd::Zero(end - begin);
  MatrixXd columns(end - begin, 3);
  for (std::size_t j = 0; j < elements.size(); ++j) {
    if (!elements[j].has_value()) continue;
    const ElementValues& values = elements[j]->initial_values();
    const double samples = values.delay / record.sample_time;
    const int whole = static_cast<int>(samples);
    const VectorXd inputs =
        record.inputs.row(static_cast<Index>(j)).segment(begin, end - begin);
    elements[j]->Simulate(values.time_scale, record.sample_time,
                          {.whole = whole, .fraction = samples - whole}, inputs,
                          inputs(0), columns);
    response += values.gain * columns.col(0);
  }
  return response;
}

// The median of up to kMedianHalfWidth values on each side.
VectorXd RunningMedian(const VectorXd& values) {
  VectorXd medians(values.size());
  std::vector<double> around;
  for (Index k = 0; k < values.size(); ++k) {
    const Index first = std::max<Index>(k - kMedianHalfWidth, 0);
    const Index last = std::min<Index>(k + kMedianHalfWidth, values.size() - 1);
    around.assign(values.data() + first, values.data() + last + 1);
    medians(k) = MedianInPlace(around);
  }
  return medians;
}

// The free responses of all elements over `samples` samples, side by side, and
// of an integrating output a ramp.
MatrixXd FreeResponses(const Elements& elements, double sample_time,
                       Index samples) {
  Index order = 0;
  bool integrating = false;
  for (const auto& element : elements) {
    if (!element.has_value()) continue;
    order += element->order();
    integrating = integrating || element->is_integrating();
  }
  MatrixXd modes = MatrixXd::Zero(samples, order + (integrating ? 1 : 0));
  MatrixXd own;
  MatrixXd derivatives;
  Index begin = 0;
  for (const auto& element : elements) {
    if (!element.has_value()) continue;
    element->FreeResponses(element->initial_values().time_scale, sample_time,
                           samples, own, derivatives);
    modes.block(0, begin, own.rows(), own.cols()) = own;
    begin += own.cols();
  }
  if (integrating) modes.col(begin).setLinSpaced(samples, 0.0, 1.0);
  return modes;
}

// The disturbance in a record's run of known inputs, the response to them taken
// off.
struct SmoothedDisturbance {
  std::vector<int> times;  // of the samples that were measured
  VectorXd measured;       // φa + w + e there
  MatrixXd modes;          // φ of all samples
};

// φa + w at the samples measured.
struct Smoothed {
  VectorXd amplitudes;  // a
  VectorXd level;       // w, at the times measured
};

Smoothed SmoothOnce(const SmoothedDisturbance& n, const VectorXd& weights,
                    double ratio) {
  const InnovationsFilter filter(n.times, {.ratio = ratio}, weights);
  const MatrixXd modes = n.modes(n.times, Eigen::all);
  Smoothed smoothed;
  smoothed.amplitudes = VectorXd::Zero(modes.cols());
  VectorXd rest = n.measured;
  if (modes.cols() > 0 && n.measured.size() > modes.cols() + 1) {
    MatrixXd whitened(rest.size(), modes.cols() + 1);
    whitened << modes, rest;
    filter.Apply(whitened);
    // Modes that are alike share: the shortest amplitudes.
    const VectorXd inverse_norms = whitened.leftCols(modes.cols())
                                       .colwise()
                                       .norm()
                                       .cwiseMax(1e-300)
                                       .cwiseInverse();
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
    decomposition.setThreshold(kAmplitudeTolerance);
    decomposition.compute(whitened.leftCols(modes.cols()) *
                          inverse_norms.asDiagonal());
    smoothed.amplitudes = inverse_norms.cwiseProduct(
        decomposition.solve(whitened.col(modes.cols())));
    rest -= modes * smoothed.amplitudes;
  }
  smoothed.level = rest - filter.WhitePart(rest);
  return smoothed;
}

// The same with Cauchy's weights. At first all samples count alike, for the
// amplitudes; beside these the level begins at a running median.
Smoothed Smooth(const SmoothedDisturbance& n, double ratio) {
  const MatrixXd modes = n.modes(n.times, Eigen::all);
  Smoothed smoothed = SmoothOnce(n, VectorXd::Ones(n.measured.size()), ratio);
  smoothed.level = RunningMedian(n.measured - modes * smoothed.amplitudes);
  VectorXd weights = VectorXd::Zero(n.measured.size());
  for (int round = 0; round < kMaxReweightings; ++round) {
    const VectorXd former = std::exchange(
        weights, ComputeRobustWeights(
                     RobustLoss::kCauchy,
                     n.measured - modes * smoothed.amplitudes - smoothed.level)
                     .weights);
    if ((weights - former).cwiseAbs().maxCoeff() <= kWeightTolerance) break;
    smoothed = SmoothOnce(n, weights, ratio);
  }
  return smoothed;
}

// Adds φa + w to all samples: between two that were measured the expected
// random walk is the line, beyond the last it stands.
void AddDisturbance(const SmoothedDisturbance& n, const Smoothed& smoothed,
                    Eigen::Ref<VectorXd> expected) {
  expected += n.modes * smoothed.amplitudes;
  std::size_t next = 0;  // the first time not before k
  for (Index k = 0; k < expected.size(); ++k) {
    while (next < n.times.size() && n.times[next] < k) ++next;
    const auto at = [&](std::size_t i) {
      return smoothed.level(static_cast<Index>(i));
    };
    if (next == 0 || next == n.times.size()) {
      expected(k) += at(next == 0 ? 0 : next - 1);
      continue;
    }
    const double share = static_cast<double>(k - n.times[next - 1]) /
                         static_cast<double>(n.times[next] - n.times[next - 1]);
    expected(k) += (1.0 - share) * at(next - 1) + share * at(next);
  }
}

absl::StatusOr<VectorXd> ExpectedOutput(const ProcessModel& model,
                                        const NoiseEstimate& noise,
                                        const Record& record, int output) {
  MLE_ASSIGN_OR_RETURN(const Elements elements, ElementsOf(model, output));
  const double ratio = RatioOf(elements, noise, record.sample_time);
  VectorXd expected = VectorXd::Constant(record.samples(), kNaN);
  const auto inputs_known = [&](int k) {
    for (std::size_t j = 0; j < elements.size(); ++j) {
      if (elements[j].has_value() &&
          !std::isfinite(record.inputs(static_cast<Index>(j), k))) {
        return false;
      }
    }
    return true;
  };
  for (int begin = 0; begin < record.samples();) {
    int end = begin;
    while (end < record.samples() && inputs_known(end)) ++end;
    SmoothedDisturbance n;
    for (int k = begin; k < end; ++k) {
      if (std::isfinite(record.outputs(output, k))) {
        n.times.push_back(k - begin);
      }
    }
    if (!n.times.empty()) {
      auto part = expected.segment(begin, end - begin);
      part = ResponseOfElements(elements, record, begin, end);
      const VectorXd measured =
          record.outputs.row(output).segment(begin, end - begin);
      n.measured = (measured - part)(n.times);
      n.modes = FreeResponses(elements, record.sample_time, part.size());
      AddDisturbance(n, Smooth(n, ratio), part);
    }
    begin = end + 1;
  }
  return expected;
}

absl::Status CheckShapes(const ProcessModel& model,
                         const std::vector<NoiseEstimate>& noise,
                         const Record& record) {
  MLE_RETURN_IF_ERROR(record.Validate());
  const int p = model.num_outputs();
  if (record.num_outputs() != p || record.num_inputs() != model.num_inputs() ||
      static_cast<int>(noise.size()) != p) {
    return absl::InvalidArgumentError(absl::StrCat(
        "expected outputs: the record has ", record.num_outputs(),
        " outputs and ", record.num_inputs(), " inputs, noise is given for ",
        noise.size(), " outputs; the model has ", p, " and ",
        model.num_inputs()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MatrixXd> ExpectedOutputs(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    const Record& record) {
  MLE_RETURN_IF_ERROR(CheckShapes(model, noise, record));
  MatrixXd expected(model.num_outputs(), record.samples());
  for (int i = 0; i < model.num_outputs(); ++i) {
    MLE_ASSIGN_OR_RETURN(const VectorXd one,
                         ExpectedOutput(model, noise[i], record, i));
    // Without samples there is no row to be filled.
    if (one.size() > 0) expected.row(i) = one;
  }
  return expected;
}

absl::StatusOr<int> FillOutputs(const ProcessModel& model,
                                const std::vector<NoiseEstimate>& noise,
                                int max_gap, std::vector<Record>& records) {
  if (max_gap < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "expected outputs: max_gap is ", max_gap, ", must not be negative"));
  }
  int filled = 0;
  for (Record& record : records) {
    MLE_RETURN_IF_ERROR(CheckShapes(model, noise, record));
    for (int i = 0; i < record.num_outputs(); ++i) {
      if (record.outputs.row(i).allFinite()) continue;
      MLE_ASSIGN_OR_RETURN(const VectorXd expected,
                           ExpectedOutput(model, noise[i], record, i));
      int last = -1;  // good sample
      for (int k = 0; k < record.samples(); ++k) {
        if (!std::isfinite(record.outputs(i, k))) continue;
        const int gap = k - last - 1;
        for (int a = 1; last >= 0 && gap <= max_gap && a <= gap; ++a) {
          record.outputs(i, last + a) = expected(last + a);
          filled += std::isfinite(expected(last + a)) ? 1 : 0;
        }
        last = k;
      }
    }
  }
  return filled;
}

}  // namespace mle
