#include "mle/nonlinear/output_error_correction.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/nonlinear/change_confirmation.h"
#include "mle/nonlinear/change_prior.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/model_average.h"
#include "mle/nonlinear/output_error_selection.h"
#include "mle/nonlinear/output_error_setup.h"
#include "mle/nonlinear/output_fit.h"
#include "mle/nonlinear/output_fits.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Below this weight a part of the average is left out.
constexpr double kSmallOffsetWeight = 1e-3;
// The power that the test of no change has for a change that is said to be
// detectable, at half the probability of a false alarm (of two tests).
constexpr double kPower = 0.9;
// A sample of less weight counts as down-weighted by a robust loss.
constexpr double kDownWeighted = 0.5;

// Of the weights, without that of stamps.
VectorXd RobustPart(const OutputErrorProblem& problem) {
  if (problem.stamp_weights().size() == 0) return problem.weights();
  return problem.weights().cwiseQuotient(problem.stamp_weights());
}

// Writes the average of fits of output i into `fit`, and returns it.
OutputFit Report(const OutputSetup& setup,
                 const std::vector<WeightedFit>& parts, int i,
                 double confidence, OutputErrorFit& fit) {
  const int m = fit.model.num_inputs();
  const auto& elements = setup.problem->elements();
  OutputFit average = Average(parts, setup.problem->sample_time());
  for (int j = 0; j < m; ++j) {
    ElementEstimate& estimate = fit.elements[i * m + j];
    if (!elements[j].has_value()) continue;
    const ElementValues& initial = elements[j]->initial_values();
    const ElementValues& values = average.point.values[j];
    const auto parameter = [&](int k, double from, double value) {
      const Interval interval = MixtureInterval(parts, 3 * j + k, confidence);
      return ParameterEstimate{
          .initial = from,
          .value = value,
          .standard_error = std::sqrt(average.covariance(3 * j + k, 3 * j + k)),
          .lower = interval.low,
          .upper = interval.high};
    };
    estimate.gain = parameter(0, initial.gain, values.gain);
    if (elements[j]->has_time_scale()) {
      estimate.time_scale = parameter(1, initial.time_scale, values.time_scale);
    }
    estimate.delay = parameter(2, initial.delay, values.delay);
    if (average.free[j]) {
      estimate.state = ElementState::kFitted;
      fit.model.element(i, j) = elements[j]->ToTransferFunction(values);
    } else {
      estimate.state =
          setup.informed[j] ? ElementState::kHeld : ElementState::kNotInformed;
    }
  }
  fit.covariances[i] = average.covariance;
  fit.noise[i] = average.noise;
  ReportDisturbances(*setup.problem, average.point, fit.noise[i]);
  fit.noise[i].stamp_deviation = setup.problem->stamp_deviation();
  fit.certificates[i] = average.certificate;
  fit.deviances[i] = average.deviance;
  fit.down_weighted_samples[i] = static_cast<int>(
      (RobustPart(*setup.problem).array() < kDownWeighted).count());
  return average;
}

OutputErrorFit EmptyFit(const ProcessModel& model) {
  const int p = model.num_outputs();
  OutputErrorFit fit;
  fit.model = model;
  fit.elements.resize(p * model.num_inputs());
  fit.covariances.resize(p);
  fit.noise.resize(p);
  fit.certificates.resize(p);
  fit.deviances.resize(p);
  fit.down_weighted_samples.resize(p);
  return fit;
}

double WeightOfOffsets(const std::vector<OutputSetup>& setups,
                       const std::vector<OutputFit>& fits,
                       const OutputErrorOptions& options) {
  if (options.offsets == WindowOffsets::kAlways) return 1.0;
  if (options.offsets == WindowOffsets::kNever) return 0.0;
  std::vector<OffsetEvidence> evidence(setups.size());
  ParallelFor(static_cast<int>(setups.size()), options.threads, [&](int i) {
    if (setups[i].problem->is_integrating()) return;
    evidence[i] =
        FindOffsetEvidence(*setups[i].problem, fits[i].point, fits[i].free,
                           fits[i].noise, options.estimate_drift);
  });
  const double weight = OffsetWeight(evidence);
  if (weight < kSmallOffsetWeight) return 0.0;
  // Without evidence that is a number, offsets are the safe side.
  return weight <= 1.0 - kSmallOffsetWeight ? weight : 1.0;
}

int NumInformed(const std::vector<OutputSetup>& setups) {
  int count = 0;
  for (const OutputSetup& setup : setups) {
    count += static_cast<int>(
        std::count(setup.informed.begin(), setup.informed.end(), true));
  }
  return count;
}

int NumFreeParameters(const std::vector<OutputSetup>& setups,
                      const std::vector<OutputFit>& fits) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    count += setups[i].problem->FreeParameters(fits[i].free).size();
  }
  return static_cast<int>(count);
}

// Averages of fits over all that may be true of offsets and drift.
struct AveragedFits {
  // The weight of offsets and drift; integrating outputs have them in any case.
  double weight = 1.0;
  std::vector<OutputFit> without;  // p: neither; unused for a weight of 1
  std::vector<OutputFit> average;  // p
};

// Prior knowledge about the changes of free elements.
enum class ChangePrior {
  kNone,        // for what is compared with no change
  kFewOrSmall,  // change_prior.h
};

// Writes all fits into `fit`, averaged with those without offsets.
AveragedFits ReportAll(const std::vector<OutputSetup>& setups,
                       const std::vector<OutputFit>& fits,
                       const OutputErrorOptions& options, ChangePrior prior,
                       OutputErrorFit& fit) {
  AveragedFits averaged;
  averaged.weight = WeightOfOffsets(setups, fits, options);
  averaged.without.resize(setups.size());
  averaged.average.resize(setups.size());
  fit.offset_weight = averaged.weight;
  const int m = fit.model.num_inputs();
  const int num_parameters = NumFreeParameters(setups, fits);
  const double noncentrality =
      num_parameters == 0
          ? 0.0
          : ChiSquareNoncentrality(0.5 * options.false_alarm_probability,
                                   num_parameters, kPower);
  ParallelFor(static_cast<int>(setups.size()), options.threads, [&](int i) {
    const OutputSetup& setup = setups[i];
    const double weight =
        setup.problem->is_integrating() ? 1.0 : averaged.weight;
    Mixture mixture;  // of the possible ratios of drift
    if (weight > 0.0) {
      mixture.AddShifted(
          weight, fits[i],
          IntegrateRatio(*setup.problem, fits[i], options.estimate_drift),
          setup.bounds);
    }
    if (weight < 1.0) {
      averaged.without[i] = fits[i].noise.offset
                                ? FitWithoutOffsets(*setup.problem, fits[i],
                                                    setup.bounds, options)
                                : fits[i];
      mixture.Add(1.0 - weight, averaged.without[i]);
    }
    for (int j = 0; j < m; ++j) {
      if (!fits[i].free[j]) continue;
      fit.elements[i * m + j].detectable_gain =
          DetectableChange(mixture.parts(), 3 * j, noncentrality);
    }
    if (prior == ChangePrior::kFewOrSmall) {
      const OutputFit average =
          Average(mixture.parts(), setup.problem->sample_time());
      mixture = {};
      mixture.AddShifted(1.0, average, IntegrateChanges(average, setup.start),
                         setup.bounds);
    }
    averaged.average[i] =
        Report(setup, mixture.parts(), i, options.confidence, fit);
  });
  return averaged;
}

// The elements of one output against their initial values.
ElementSelection Select(const OutputSetup& setup, const OutputFit& fit,
                        double false_alarm) {
  std::vector<int> kept;
  std::vector<double> degrees;
  std::vector<double> changes;
  std::vector<Eigen::Index> missing;
  for (int j = 0; j < setup.problem->num_elements(); ++j) {
    if (!fit.free[j]) continue;
    if (!setup.problem->elements()[j]->has_time_scale()) {
      missing.push_back(static_cast<Eigen::Index>(kept.size()) + 1);
    }
    const ElementValues& a = fit.point.values[j];
    const ElementValues& b = setup.start.values[j];
    for (int k = 0; k < 3; ++k) kept.push_back(3 * j + k);
    changes.push_back(a.gain - b.gain);
    changes.push_back(a.time_scale - b.time_scale);
    changes.push_back(a.delay - b.delay);
    degrees.push_back(fit.degrees_of_freedom.segment(3 * j, 3).minCoeff());
  }
  MatrixXd covariance = fit.covariance(kept, kept);
  // A parameter that is not determined cannot be told to have changed; nor can
  // the lag that an integrator does not have, whose change is 0.
  const double large = 1e12;
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    const bool without =
        std::find(missing.begin(), missing.end(), k) != missing.end();
    if (without || !std::isfinite(covariance(k, k))) {
      covariance.row(k).setZero();
      covariance.col(k).setZero();
      covariance(k, k) = large * (1.0 + changes[k] * changes[k]);
    }
  }
  return SelectChanged(
      Eigen::Map<const VectorXd>(changes.data(), changes.size()), covariance,
      degrees, false_alarm);
}

// The likelihood ratio of the full fits against the initial model, integrated
// over what may be true of offsets and drift: −2 ln Σ w exp(−S/2), with the
// weights of the averages, so that test and intervals agree.
double ChangeStatistic(const std::vector<OutputSetup>& setups,
                       const std::vector<OutputFit>& fits,
                       const AveragedFits& averaged,
                       const OutputErrorOptions& options) {
  const auto sum = [&](const std::vector<OutputFit>& of, bool drift) {
    std::vector<double> statistics(setups.size());
    ParallelFor(static_cast<int>(setups.size()), options.threads, [&](int i) {
      const bool always = setups[i].problem->is_integrating();
      const OutputFit& fit = always ? fits[i] : of[i];
      statistics[i] = ContrastWithFit(*setups[i].problem, setups[i].start,
                                      fit.point, fit.free, fit.noise,
                                      always ? options.estimate_drift : drift)
                          .statistic /
                      fit.inflation.statistic;
    });
    return std::accumulate(statistics.begin(), statistics.end(), 0.0);
  };
  const double weight = averaged.weight;
  if (!(weight < 1.0)) return sum(fits, options.estimate_drift);
  if (!(weight > 0.0)) return sum(averaged.without, false);
  const double with = sum(fits, options.estimate_drift);
  const double without = sum(averaged.without, false);
  const double least = std::min(with, without);
  return least -
         2.0 * std::log(weight * std::exp(-0.5 * (with - least)) +
                        (1.0 - weight) * std::exp(-0.5 * (without - least)));
}

// The elements of output i that have changed by what all records say and, with
// these p of Wald's test, this part of them.
std::vector<bool> BeyondDoubt(const std::vector<bool>& named,
                              const Eigen::RowVectorXd& p_values, int i,
                              const OutputErrorOptions& options) {
  std::vector<bool> certain(named.size(), false);
  if (options.start == nullptr) return certain;
  for (std::size_t j = 0; j < named.size(); ++j) {
    const auto input = static_cast<Eigen::Index>(j);
    certain[j] = named[j] && options.start->aged(i, input) &&
                 std::max(options.start->element_p_values(i, input),
                          p_values(input)) < kBeyondDoubt;
  }
  return certain;
}

// The elements of output i that have changed, by Wald's test and then by
// likelihood, into its rows of `correction`. `fit` takes the values of those
// that have where a better fit was found than from its own.
void JudgeElements(const OutputSetup& setup, OutputFit& fit,
                   const AveragedFits& averaged, int i, double false_alarm,
                   const OutputErrorOptions& options,
                   OutputErrorCorrection& correction) {
  const ElementSelection selection =
      Select(setup, averaged.average[i], false_alarm);
  std::vector<bool> named(fit.free.size(), false);
  int g = 0;
  for (std::size_t j = 0; j < named.size(); ++j) {
    if (!fit.free[j]) continue;
    correction.element_p_values(i, j) = selection.p_values[g];
    named[j] = correction.change_proposed && selection.changed[g];
    ++g;
  }
  if (!correction.change_proposed) return;
  if (fit.certificate.num_parameters == 0) return;
  std::vector<AssumedFit> assumed;
  const double weight = setup.problem->is_integrating() ? 1.0 : averaged.weight;
  if (weight > 0.0) assumed.push_back({.weight = weight, .fit = &fit});
  if (weight < 1.0) {
    assumed.push_back({.weight = 1.0 - weight, .fit = &averaged.without[i]});
  }
  const ConfirmedChanges confirmed = ConfirmChanges(
      setup, assumed, named,
      BeyondDoubt(named, correction.element_p_values.row(i), i, options),
      false_alarm, options);
  for (std::size_t j = 0; j < named.size(); ++j) {
    double& p_value = correction.element_p_values(i, j);
    if (named[j]) {
      p_value = std::max(p_value, confirmed.p_values[j]);
    } else if (confirmed.changed[j]) {
      p_value = confirmed.p_values[j];
    }
    correction.aged(i, j) = confirmed.changed[j];
    if (confirmed.changed[j] && confirmed.restarted) {
      fit.point.values[j] = confirmed.point.values[j];
    }
  }
}

// Test and selection from the full fits.
void JudgeOutputs(const std::vector<OutputSetup>& setups,
                  std::vector<OutputFit>& fits, const AveragedFits& averaged,
                  const OutputErrorOptions& options,
                  OutputErrorCorrection& correction) {
  const int p = static_cast<int>(setups.size());
  const bool given = options.change_given || options.start != nullptr;
  correction.degrees_of_freedom = NumFreeParameters(setups, fits);
  if (options.start == nullptr) {
    correction.statistic = ChangeStatistic(setups, fits, averaged, options);
  }
  if (correction.degrees_of_freedom == 0) return;
  if (options.start == nullptr) {
    correction.p_value =
        ChiSquareTail(correction.statistic, correction.degrees_of_freedom);
  }
  correction.change_proposed =
      given || correction.p_value < options.false_alarm_probability;

  const double false_alarm =
      options.false_alarm_probability / NumInformed(setups);
  ParallelFor(p, options.threads, [&](int i) {
    JudgeElements(setups[i], fits[i], averaged, i, false_alarm, options,
                  correction);
  });
  int smallest_i = 0;
  int smallest_j = 0;
  correction.element_p_values.minCoeff(&smallest_i, &smallest_j);
  // Something has changed: then at least the likeliest element.
  if (correction.change_proposed && !correction.aged.any()) {
    correction.aged(smallest_i, smallest_j) = true;
  }
}

}  // namespace

absl::StatusOr<OutputErrorFit> FitAllElements(
    const ProcessModel& initial, const std::vector<Record>& records,
    const OutputErrorOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(initial, records, options));
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputFit> fits,
                       FitOutputs(setups, options));
  OutputErrorFit fit = EmptyFit(initial);
  for (int i = 0; i < initial.num_outputs(); ++i) {
    Report(setups[i], {{.weight = 1.0, .fit = &fits[i]}}, i, options.confidence,
           fit);
  }
  return fit;
}

absl::StatusOr<OutputErrorCorrection> CorrectByOutputError(
    const ProcessModel& initial, const std::vector<Record>& records,
    const OutputErrorOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(initial, records, options));
  const int p = initial.num_outputs();
  const int m = initial.num_inputs();
  if (!options.outputs.empty() && std::ssize(options.outputs) != p) {
    return absl::InvalidArgumentError(
        absl::StrCat("output-error correction: outputs has ",
                     options.outputs.size(), " entries, the model has ", p));
  }
  OutputErrorCorrection correction;
  correction.full = EmptyFit(initial);
  correction.corrected = EmptyFit(initial);
  correction.element_p_values = MatrixXd::Ones(p, m);
  correction.aged.setConstant(p, m, false);

  MLE_ASSIGN_OR_RETURN(std::vector<OutputFit> fits,
                       FitOutputs(setups, options));
  const AveragedFits full =
      ReportAll(setups, fits, options, ChangePrior::kNone, correction.full);
  JudgeOutputs(setups, fits, full, options, correction);
  MLE_RETURN_IF_ERROR(FitEach(p, options, [&](int i) {
    std::vector<bool> free(m);
    for (int j = 0; j < m; ++j) free[j] = correction.aged(i, j);
    if (free == fits[i].free) return;
    fits[i] = FitAged(setups[i], fits[i], free, options);
  }));
  ReportAll(setups, fits, options, ChangePrior::kFewOrSmall,
            correction.corrected);
  return correction;
}

absl::StatusOr<OutputErrorFit> ComputeOutputErrorLimit(
    const ProcessModel& truth, const std::vector<Record>& records,
    const std::vector<NoiseEstimate>& noise,
    const OutputErrorOptions& options) {
  MLE_ASSIGN_OR_RETURN(const std::vector<OutputSetup> setups,
                       SetUpOutputs(truth, records, options));
  const int p = truth.num_outputs();
  if (static_cast<int>(noise.size()) != p) {
    return absl::InvalidArgumentError(
        absl::StrCat("output-error limit: noise is given for ", noise.size(),
                     " outputs, the model has ", p));
  }
  OutputErrorFit limit = EmptyFit(truth);
  for (int i = 0; i < p; ++i) {
    OutputFit fit;
    fit.point = setups[i].start;
    fit.free = setups[i].informed;
    fit.noise = noise[i];
    const OutputCovariance covariance =
        ComputeCovariance(*setups[i].problem, fit.point, fit.free, fit.noise);
    fit.covariance = covariance.covariance;
    fit.degrees_of_freedom = VectorXd::Constant(
        fit.covariance.rows(), std::numeric_limits<double>::infinity());
    fit.certificate.message = "limit at the given values";
    fit.certificate.condition = covariance.condition;
    fit.certificate.rank = covariance.rank;
    limit.offset_weight = fit.noise.offset ? 1.0 : 0.0;
    Report(setups[i], {{.weight = 1.0, .fit = &fit}}, i, options.confidence,
           limit);
  }
  return limit;
}

}  // namespace mle
