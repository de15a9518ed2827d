#include "mle/nonlinear/model_adequacy.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

// The settling time is the longest of dead time + this many time scales.
constexpr double kSettlingTimeScales = 4.0;
// No lag is longer than this share of the shortest record.
constexpr double kMaxAdequacyLagShare = 0.25;

}  // namespace

AdequacyOptions AdequacyOptionsFor(const OutputErrorOptions& structure) {
  AdequacyOptions options;
  options.false_alarm_probability = structure.false_alarm_probability;
  options.estimate_drift = structure.estimate_drift;
  options.structure = structure;
  options.threads = structure.threads;
  return options;
}

absl::Status AdequacyOptions::Validate() const {
  if (!(false_alarm_probability > 0.0 && false_alarm_probability < 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("model adequacy: false_alarm_probability is ",
                     false_alarm_probability, ", must be between 0 and 1"));
  }
  if (threads < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "model adequacy: threads is ", threads, ", must be not negative"));
  }
  return structure.Validate();
}

std::vector<bool> WrongOutputs(const ModelAdequacy& adequacy,
                               double false_alarm_probability) {
  const Eigen::VectorXd& p_values = adequacy.output_p_values;
  std::vector<bool> wrong(p_values.size());
  if (adequacy.adequate) return wrong;
  for (Eigen::Index i = 0; i < p_values.size(); ++i) {
    wrong[i] = p_values(i) < false_alarm_probability /
                                 static_cast<double>(p_values.size()) ||
               p_values(i) == p_values.minCoeff();
  }
  return wrong;
}

absl::StatusOr<ModelAdequacy> TestAdequacy(
    const ProcessModel& model, const std::vector<Record>& records,
    const Eigen::Matrix<bool, Eigen::Dynamic, Eigen::Dynamic>& fitted,
    const AdequacyOptions& options, const std::vector<NoiseEstimate>& noise) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(model, records, options.structure));
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  if (fitted.size() > 0 && (fitted.rows() != p || fitted.cols() != m)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "model adequacy: the elements fitted are given as %d × %d, the model "
        "has %d × %d",
        fitted.rows(), fitted.cols(), p, m));
  }
  const std::vector<int> first_lags = LagRanges(
      LongestLag(setups, records, kSettlingTimeScales, kMaxAdequacyLagShare),
      1);
  std::vector<Contrast> evidence(p);
  ParallelFor(p, options.threads, [&](int i) {
    const OutputSetup& setup = setups[i];
    if (setup.problem->num_segments() == 0) return;
    if (!noise.empty()) {
      AdoptDisturbances(noise[i], *setup.problem);
    }
    std::vector<bool> free(m, false);
    for (int j = 0; j < m && fitted.size() > 0; ++j) {
      free[j] = fitted(i, j) && setup.informed[j];
    }
    evidence[i] = ContrastWithColumns(
        ShapeLikelihood(*setup.problem, setup.start, free, NoiseShape(),
                        /*restricted=*/true),
        setup.problem->LagSums(first_lags), options.estimate_drift,
        noise.empty() ? nullptr : &noise[i]);
  });
  ModelAdequacy adequacy;
  adequacy.output_p_values.setOnes(p);
  for (int i = 0; i < p; ++i) {
    adequacy.statistic += evidence[i].statistic;
    adequacy.degrees_of_freedom += evidence[i].degrees;
    if (evidence[i].degrees > 0) {
      adequacy.output_p_values(i) =
          ChiSquareTail(evidence[i].statistic, evidence[i].degrees);
    }
  }
  if (adequacy.degrees_of_freedom > 0) {
    adequacy.p_value =
        ChiSquareTail(adequacy.statistic, adequacy.degrees_of_freedom);
  }
  adequacy.adequate = adequacy.p_value >= options.false_alarm_probability;
  return adequacy;
}

}  // namespace mle
