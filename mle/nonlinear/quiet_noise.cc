#include "mle/nonlinear/quiet_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/outliers.h"
#include "mle/data/quiet_stretches.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/element_response.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

constexpr int kLeastSamples = 20;
constexpr double kDerivativeStep = 0.1;  // of ln ρ
// −2 ln likelihood rises by this where a two-sided interval of 95 % ends.
constexpr double kProfileRise = 3.841;

// Restricted likelihood of ρ, maximised over r, with the elements that are free
// estimated in first order.
class RatioLikelihood {
 public:
  RatioLikelihood(const OutputErrorProblem& problem, const OutputPoint& point,
                  const std::vector<bool>& free)
      : problem_(problem),
        columns_(problem.Linearise(point, NoiseShape(), true)) {
    std::vector<int> kept;
    for (std::size_t j = 0; j < free.size(); ++j) {
      for (int k = 0; free[j] && k < 3; ++k) {
        kept.push_back(3 * static_cast<int>(j) + k);
      }
    }
    for (SegmentColumns& segment : columns_) {
      segment.jacobian = Eigen::MatrixXd(segment.jacobian(Eigen::all, kept));
    }
  }

  struct Value {
    double deviance = 0.0;  // −2 ln likelihood less constants
    double squares = 0.0;
    double degrees = 1.0;
  };
  Value At(double ratio) const {
    const NoiseShape shape{.ratio = ratio};
    const WhitenedColumns whitened = problem_.Whiten(columns_, shape);
    Value value;
    value.squares = whitened.residuals.squaredNorm();
    value.deviance = whitened.log_determinant + whitened.log_amplitudes;
    Eigen::Index rank = 0;
    if (whitened.jacobian.cols() > 0) {
      const Eigen::VectorXd norms =
          whitened.jacobian.colwise().norm().cwiseMax(1e-300);
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
      qr.setThreshold(1e-8);
      qr.compute(whitened.jacobian * norms.cwiseInverse().asDiagonal());
      rank = qr.rank();
      const Eigen::VectorXd explained =
          (qr.householderQ().adjoint() * whitened.residuals).head(rank);
      value.squares -= explained.squaredNorm();
      for (Eigen::Index i = 0; i < rank; ++i) {
        value.deviance +=
            2.0 * std::log(std::abs(qr.matrixQR()(i, i)) *
                           norms(qr.colsPermutation().indices()(i)));
      }
    }
    // Exact data leave rounding, which has no likelihood.
    value.squares =
        std::max({value.squares, 1e-26 * problem_.total_squares(), 1e-300});
    value.degrees = std::max<double>(1.0, problem_.num_innovations(shape) -
                                              whitened.num_amplitudes -
                                              static_cast<double>(rank));
    value.deviance += value.degrees * std::log(value.squares / value.degrees);
    return value;
  }

 private:
  const OutputErrorProblem& problem_;
  std::vector<SegmentColumns> columns_;
};

// The elements of an output whose response can be taken off.
OutputErrorProblem::Elements ElementsOf(const ProcessModel& model, int i,
                                        bool use_model) {
  OutputErrorProblem::Elements elements(model.num_inputs());
  for (int j = 0; use_model && j < model.num_inputs(); ++j) {
    if (model.element(i, j).IsZero()) continue;
    // Without those that have feedthrough: noise would pass through them
    // undelayed, and back.
    absl::StatusOr<ElementResponse> element =
        ElementResponse::Create(model.element(i, j));
    if (element.ok()) elements[j] = *std::move(element);
  }
  return elements;
}

// A quiet stretch with `skip` samples before it, as far as there are any, whose
// outputs do not count.
Record CutStretch(const Record& record, const QuietStretch& stretch, int skip,
                  int samples) {
  const int begin = std::max(0, stretch.first - skip);
  const int count =
      std::min(stretch.last, stretch.first + samples - 1) - begin + 1;
  Record part;
  part.sample_time = record.sample_time;
  part.start_time = record.time(begin);
  part.outputs = record.outputs.middleCols(begin, count);
  part.inputs = record.inputs.middleCols(begin, count);
  part.outputs.leftCols(stretch.first - begin)
      .setConstant(std::numeric_limits<double>::quiet_NaN());
  return part;
}

QuietNoise Estimate(const OutputErrorProblem& problem, const OutputPoint& point,
                    bool free_elements) {
  std::vector<bool> free(problem.num_elements(), false);
  for (int j = 0; free_elements && j < problem.num_elements(); ++j) {
    free[j] = problem.elements()[j].has_value() && problem.IsExcited(j);
  }
  const NoiseEstimate best =
      EstimateNoise(problem, point, free, NoiseEstimate(), true);
  const RatioLikelihood likelihood(problem, point, free);
  const RatioLikelihood::Value at_best = likelihood.At(best.ratio);
  QuietNoise noise;
  noise.variance = at_best.squares / at_best.degrees;
  noise.increment_variance = best.ratio * noise.variance;
  noise.samples = problem.num_samples();
  noise.stretches = problem.num_segments();

  // ln r given ln ρ has variance 2/degrees, and moves with ln ρ.
  const double own = 2.0 / at_best.degrees;
  double slope = 0.0;
  if (best.ratio > 0.0) {
    slope =
        std::log(
            likelihood.At(best.ratio * std::exp(kDerivativeStep)).squares /
            likelihood.At(best.ratio * std::exp(-kDerivativeStep)).squares) /
        (2.0 * kDerivativeStep);
    const double drop = likelihood.At(0.0).deviance - at_best.deviance;
    noise.drift_p_value = 0.5 * ChiSquareTail(std::max(drop, 0.0), 1.0);
  }
  const double by_ratio = best.log_ratio_deviation;
  noise.variance_error =
      noise.variance * std::hypot(std::sqrt(own), slope * by_ratio);
  noise.increment_variance_error =
      noise.increment_variance *
      std::hypot(std::sqrt(own), (1.0 + slope) * by_ratio);

  // Where the profile has risen, by bisection in ln ρ.
  double low = std::log(std::max(best.ratio, 1e-10));
  double high = low + 1.0;
  const auto rise = [&](double log_ratio) {
    return likelihood.At(std::exp(log_ratio)).deviance - at_best.deviance;
  };
  while (rise(high) < kProfileRise && high < 14.0) high += 1.0;
  for (int step = 0; step < 20; ++step) {
    const double middle = 0.5 * (low + high);
    (rise(middle) < kProfileRise ? low : high) = middle;
  }
  const RatioLikelihood::Value at_end = likelihood.At(std::exp(high));
  noise.increment_variance_upper =
      std::exp(high) * at_end.squares / at_end.degrees;
  return noise;
}

absl::Status CheckRecords(
    const std::vector<Record>& records,
    const std::vector<std::vector<SetPointChange>>& changes,
    const ProcessModel& model) {
  if (records.size() != changes.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("quiet noise: there are ", records.size(),
                     " records, but changes of ", changes.size()));
  }
  for (std::size_t r = 0; r < records.size(); ++r) {
    const absl::Status valid = records[r].Validate();
    if (!valid.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("quiet noise: records[", r, "]: ", valid.message()));
    }
    if (records[r].num_outputs() != model.num_outputs() ||
        records[r].num_inputs() != model.num_inputs() ||
        records[r].sample_time != records[0].sample_time) {
      return absl::InvalidArgumentError(absl::StrCat(
          "quiet noise: records[", r,
          "] is not of the model's channels, or sampled otherwise than the "
          "first"));
    }
  }
  return absl::OkStatus();
}

absl::Status TooShort(const ProcessModel& model, int i, double settling,
                      const QuietNoiseOptions& options) {
  return absl::FailedPreconditionError(
      absl::StrCat("quiet noise: output '", model.outputs()[i].name,
                   "' has no quiet stretch: ", options.min_samples,
                   " samples in a row are needed that are good, ", settling,
                   " ", model.time_unit(),
                   " or more after a change of set point and before the next"));
}

}  // namespace

absl::Status QuietNoiseOptions::Validate() const {
  if (!(settling >= 0.0) || !std::isfinite(settling)) {
    return absl::InvalidArgumentError(
        absl::StrCat("quiet noise: settling is ", settling,
                     ", must be finite and not negative"));
  }
  if (min_samples < kLeastSamples || max_samples < min_samples) {
    return absl::InvalidArgumentError(absl::StrCat(
        "quiet noise: min_samples is ", min_samples, " and max_samples ",
        max_samples, "; the first must be at least ", kLeastSamples,
        ", the second not less"));
  }
  return absl::OkStatus();
}

NoiseEstimate QuietNoise::ToNoiseEstimate() const {
  NoiseEstimate estimate;
  estimate.variance = variance;
  estimate.ratio = variance > 0.0 ? increment_variance / variance : 0.0;
  return estimate;
}

std::string QuietNoise::Report() const {
  return absl::StrCat("white variance ", variance, " ± ", variance_error,
                      ", drift ", increment_variance, " per sample (below ",
                      increment_variance_upper, ", p = ", drift_p_value,
                      ") from ", samples, " samples in ", stretches,
                      " quiet stretches, ", outliers, " outliers left out");
}

absl::StatusOr<std::vector<QuietNoise>> EstimateQuietNoise(
    const std::vector<Record>& records,
    const std::vector<std::vector<SetPointChange>>& changes,
    const ProcessModel& model, const QuietNoiseOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckRecords(records, changes, model));
  const double settling =
      options.settling > 0.0 ? options.settling : SettlingTime(model);
  const std::vector<QuietStretch> stretches =
      FindQuietStretches(records, changes, settling, options.min_samples);
  const int share = std::max(
      options.min_samples,
      options.max_samples / std::max(1, static_cast<int>(stretches.size())));
  std::vector<QuietNoise> noise;
  for (int i = 0; i < model.num_outputs(); ++i) {
    OutputErrorProblem::Elements elements =
        ElementsOf(model, i, options.use_model);
    OutputPoint point;
    point.values.resize(elements.size());
    double longest = 0.0;
    for (std::size_t j = 0; j < elements.size(); ++j) {
      if (!elements[j]) continue;
      point.values[j] = elements[j]->initial_values();
      longest = std::max(longest, point.values[j].delay);
    }
    const double sample_time = records.empty() ? 1.0 : records[0].sample_time;
    point.SetCells(sample_time);
    const int skip = static_cast<int>(std::ceil(longest / sample_time)) + 1;
    std::vector<Record> parts;
    int outliers = 0;
    for (const QuietStretch& stretch : stretches) {
      parts.push_back(
          CutStretch(records[stretch.record], stretch, skip, share));
      for (const int k : FindOutliers(parts.back().outputs.row(i))) {
        parts.back().outputs(i, k) = std::numeric_limits<double>::quiet_NaN();
        ++outliers;
      }
    }
    const OutputErrorProblem problem(std::move(elements), parts, i, skip,
                                     kLeastSamples);
    if (problem.num_samples() < options.min_samples / 2) {
      return TooShort(model, i, settling, options);
    }
    noise.push_back(Estimate(problem, point, options.free_elements));
    noise.back().outliers = outliers;
  }
  return noise;
}

}  // namespace mle
