#include "mle/maintain/channel_scales.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/correction/conversion.h"
#include "mle/correction/excitation.h"
#include "mle/nonlinear/ar_component.h"

namespace mle {
namespace {

using Eigen::VectorXd;

constexpr double kPaperNoiseVariance = 0.001;
constexpr double kPaperSignalToNoise = 500.0;
constexpr double kSmallestRelativeNoise = 1e-5;
constexpr int kMostRegressors = 1500;
constexpr int kShortestOrder = 10;
constexpr int kFewestScaleSamples = 100;
constexpr int kMostScaleSamples = 10'000'000;
constexpr int kScaleSamples = 200;

double LargestResponse(const TransferFunction& element) {
  const double horizon = element.delay() + 5.0 * element.SlowestTimeConstant();
  if (!(horizon > 0.0)) return std::abs(element.StaticGain());
  return element.StepResponse(horizon / (kScaleSamples - 1), kScaleSamples)
      .cwiseAbs()
      .maxCoeff();
}

// Largest less smallest finite value of output i.
double RangeOf(const std::vector<Record>& records, int i) {
  double min = std::numeric_limits<double>::infinity();
  double max = -min;
  for (const Record& record : records) {
    for (const double value : record.outputs.row(i)) {
      if (!std::isfinite(value)) continue;
      min = std::min(min, value);
      max = std::max(max, value);
    }
  }
  return max > min ? max - min : 1.0;
}

}  // namespace

ChannelScales ChooseScales(const ProcessModel& model,
                           const std::vector<NoiseEstimate>& noise,
                           const std::vector<Record>& records) {
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  VectorXd deviations(p);
  for (int i = 0; i < p; ++i) {
    deviations(i) = std::max(std::sqrt(noise[i].variance),
                             kSmallestRelativeNoise * RangeOf(records, i));
  }
  ChannelScales scales;
  scales.outputs = deviations / std::sqrt(kPaperNoiseVariance);
  scales.inputs = VectorXd::Ones(m);
  for (int j = 0; j < m; ++j) {
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < p; ++i) {
      const double largest = model.element(i, j).IsZero()
                                 ? 0.0
                                 : LargestResponse(model.element(i, j));
      if (!(largest > 0.0)) continue;
      sum += std::log(deviations(i) / largest);
      ++count;
    }
    if (count > 0) {
      scales.inputs(j) = kPaperSignalToNoise * std::exp(sum / count);
    }
  }
  return scales;
}

Record Scaled(const Record& record, const ChannelScales& scales) {
  Record scaled = record;
  scaled.outputs = scales.outputs.cwiseInverse().asDiagonal() * record.outputs;
  scaled.inputs = scales.inputs.cwiseInverse().asDiagonal() * record.inputs;
  if (record.set_points.size() > 0) {
    scaled.set_points =
        scales.outputs.cwiseInverse().asDiagonal() * record.set_points;
  }
  return scaled;
}

ProcessModel Scaled(const ProcessModel& model, const ChannelScales& scales) {
  ProcessModel scaled = model;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      std::vector<double> numerator = element.numerator();
      for (double& coefficient : numerator) {
        coefficient *= scales.inputs(j) / scales.outputs(i);
      }
      scaled.element(i, j) = TransferFunction(
          std::move(numerator), element.denominator(), element.delay());
    }
  }
  return scaled;
}

ArxModel Unscaled(const ArxModel& model, const ChannelScales& scales) {
  ArxModel unscaled = model;
  VectorXd channels(model.num_channels());
  channels << scales.outputs, scales.inputs;
  for (int lag = 0; lag < model.order; ++lag) {
    auto block =
        unscaled.R.middleCols(lag * model.num_channels(), model.num_channels());
    block = (scales.outputs.asDiagonal() * block *
             channels.cwiseInverse().asDiagonal())
                .eval();
  }
  return unscaled;
}

absl::Status ConversionSettings::Validate() const {
  if (order < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "conversion.order = ", order, ": it must not be negative"));
  }
  if (!(penalty >= 0.0) || !std::isfinite(penalty)) {
    return absl::InvalidArgumentError(
        absl::StrCat("conversion.penalty = ", penalty,
                     ": it must be finite and not negative"));
  }
  if (samples < kFewestScaleSamples || samples > kMostScaleSamples) {
    return absl::InvalidArgumentError(
        absl::StrCat("conversion.samples = ", samples,
                     ": from 100 to 10,000,000 are possible"));
  }
  return absl::OkStatus();
}

int ConversionSettings::OrderFor(const ProcessModel& model,
                                 double sample_time) const {
  return order > 0 ? order : ChooseOrder(model, sample_time);
}

double LongestMemory(const ProcessModel& model) {
  double longest = 0.0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      longest =
          std::max(longest, element.delay() + element.SlowestTimeConstant());
    }
  }
  return longest;
}

int ChooseOrder(const ProcessModel& model, double sample_time) {
  const int most =
      std::max(kMostRegressors / (model.num_outputs() + model.num_inputs()), 1);
  const double wanted = std::ceil(1.25 * LongestMemory(model) / sample_time);
  return static_cast<int>(
      std::min<double>(std::max<double>(wanted, kShortestOrder), most));
}

absl::StatusOr<ConversionSummary> ConvertUnderNoise(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    const ChannelScales& scales, double sample_time,
    const ConversionSettings& settings) {
  ExcitationOptions excitation;
  excitation.sample_time = sample_time;
  excitation.duration = (settings.samples - 1) * sample_time;
  excitation.noise_variance = kPaperNoiseVariance;
  excitation.seed = settings.seed;
  excitation.stream = kConversionStream;
  MLE_ASSIGN_OR_RETURN(Record record,
                       SimulateExcitation(Scaled(model, scales), excitation));
  GaussianNoise walk(settings.seed, kConversionStream, kDriftDisturbance);
  GaussianNoise ar(settings.seed, kConversionStream, kColouredDisturbance);
  for (int i = 0; i < record.num_outputs(); ++i) {
    const double step = std::sqrt(noise[i].ratio * kPaperNoiseVariance);
    double level = 0.0;
    ArSignal coloured(ArComponent(noise[i].ar_pole, noise[i].ar_damping),
                      noise[i].ar_ratio * kPaperNoiseVariance, ar);
    for (int k = 0; k < record.samples(); ++k) {
      record.outputs(i, k) += level + coloured.value();
      level += walk.Draw(step);
      coloured.Advance();
    }
  }
  ConversionOptions options;
  options.order = settings.OrderFor(model, sample_time);
  options.penalty = settings.penalty;
  options.solver = settings.solver;
  return ConvertToArx(record, options);
}

}  // namespace mle
