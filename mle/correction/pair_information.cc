#include "mle/correction/pair_information.h"

#include <algorithm>
#include <cmath>

#include "Eigen/LU"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A gain of zero has no relative error: then that of one unit.
double Relative(double error, double value) {
  return value == 0.0 ? error : error / std::abs(value);
}

// Standard error of the first parameter of element j if all parameters of the
// others were known.
double ErrorAlone(const MatrixXd& covariance, const std::vector<int>& kept,
                  int j) {
  std::vector<int> own;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    if (kept[k] / 3 == j) own.push_back(static_cast<int>(k));
  }
  // In units of the standard errors, so that the inverse is well scaled.
  const MatrixXd part = covariance(kept, kept);
  const VectorXd scale = part.diagonal().cwiseSqrt().cwiseMax(1e-300);
  const MatrixXd correlation = scale.cwiseInverse().asDiagonal() * part *
                               scale.cwiseInverse().asDiagonal();
  const MatrixXd information = correlation.fullPivLu().inverse();
  const MatrixXd alone = MatrixXd(information(own, own)).fullPivLu().inverse();
  return std::sqrt(std::max(alone(0, 0), 0.0)) * scale(own[0]);
}

PairErrors ErrorsOf(const ElementEstimate& element, const MatrixXd& covariance,
                    int j, const InformationOptions& options) {
  PairErrors errors;
  if (element.state == ElementState::kAbsent) return errors;
  errors.state = PairState::kNotInformed;
  if (element.state != ElementState::kFitted) return errors;
  errors.gain = Relative(element.gain.standard_error, element.gain.initial);
  errors.time_scale =
      Relative(element.time_scale.standard_error, element.time_scale.initial);
  errors.delay = element.delay.standard_error;
  if (errors.gain <= options.weak) errors.state = PairState::kWeak;
  if (errors.gain <= options.informed) errors.state = PairState::kInformed;

  std::vector<int> kept;
  for (int k = 0; k < covariance.rows(); ++k) {
    if (std::isfinite(covariance(k, k)) && covariance(k, k) > 0.0) {
      kept.push_back(k);
    }
  }
  const bool is_determined = std::count(kept.begin(), kept.end(), 3 * j) > 0;
  if (!is_determined) return errors;
  const double alone = ErrorAlone(covariance, kept, j);
  if (alone > 0.0 && std::isfinite(alone)) {
    errors.inflation = std::max(1.0, element.gain.standard_error / alone);
  }
  return errors;
}

// Deviations of the inputs from their means in each window, side by side, those
// of bad samples zero.
MatrixXd Deviations(const std::vector<Record>& windows, int num_inputs) {
  Eigen::Index samples = 0;
  for (const Record& window : windows) samples += window.samples();
  MatrixXd all = MatrixXd::Zero(num_inputs, samples);
  Eigen::Index begin = 0;
  for (const Record& window : windows) {
    for (int j = 0; j < num_inputs; ++j) {
      const auto row = window.inputs.row(j);
      const auto is_good = row.array().isFinite();
      const double count = static_cast<double>(is_good.count());
      if (count == 0.0) continue;
      const double mean = is_good.select(row.array(), 0.0).sum() / count;
      all.row(j).segment(begin, window.samples()) =
          is_good.select(row.array() - mean, 0.0);
    }
    begin += window.samples();
  }
  return all;
}

InputExcitation ExcitationOf(const std::vector<Record>& windows, int j) {
  InputExcitation excitation;
  for (const Record& window : windows) {
    double low = kInfinity;
    double high = -kInfinity;
    double last = std::numeric_limits<double>::quiet_NaN();
    for (const double value : window.inputs.row(j)) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
      excitation.moves += std::isfinite(last) && value != last ? 1 : 0;
      last = value;
    }
    if (low <= high) excitation.range = std::max(excitation.range, high - low);
  }
  return excitation;
}

void DescribeInputs(const std::vector<Record>& windows,
                    PairInformation& information) {
  const int m = information.num_inputs;
  const MatrixXd deviations = Deviations(windows, m);
  const double n =
      std::max<double>(1.0, static_cast<double>(deviations.cols()));
  const MatrixXd products = deviations * deviations.transpose() / n;
  information.input_correlation = MatrixXd::Identity(m, m);
  for (int j = 0; j < m; ++j) {
    information.inputs.push_back(ExcitationOf(windows, j));
    information.inputs.back().deviation = std::sqrt(products(j, j));
    for (int other = 0; other < m; ++other) {
      const double size = std::sqrt(products(j, j) * products(other, other));
      if (other == j) continue;
      information.input_correlation(j, other) =
          size > 0.0 ? products(j, other) / size : 0.0;
    }
  }
}

}  // namespace

absl::Status InformationOptions::Validate() const {
  if (!(informed > 0.0) || !(weak >= informed)) {
    return InvalidArgument(
        "information: informed is ", informed, " and weak ", weak,
        "; they must be positive, and the second not below the first");
  }
  return output_error.Validate();
}

absl::StatusOr<PairInformation> AssessInformation(
    const ProcessModel& model, const std::vector<Record>& windows,
    const std::vector<NoiseEstimate>& noise,
    const InformationOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(
      const OutputErrorFit limit,
      ComputeOutputErrorLimit(model, windows, noise, options.output_error));
  PairInformation information;
  information.num_inputs = model.num_inputs();
  for (const auto& [i, j] : Pairs(model)) {
    information.pairs.push_back(
        ErrorsOf(limit.element(i, j), limit.covariances[i], j, options));
  }
  DescribeInputs(windows, information);
  return information;
}

std::vector<int> PairInformation::inputs_to_test() const {
  std::vector<int> inputs_found;
  const int p =
      num_inputs == 0 ? 0 : static_cast<int>(pairs.size()) / num_inputs;
  for (int j = 0; j < num_inputs; ++j) {
    for (int i = 0; i < p; ++i) {
      const PairState state = pair(i, j).state;
      if (state != PairState::kNotInformed && state != PairState::kWeak) {
        continue;
      }
      inputs_found.push_back(j);
      break;
    }
  }
  return inputs_found;
}

}  // namespace mle
