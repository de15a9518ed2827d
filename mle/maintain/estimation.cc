#include "mle/maintain/estimation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/correction/robust_correction.h"
#include "mle/correction/smoothed_correction.h"
#include "mle/data/lagged_series.h"
#include "mle/data/segments.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/fit_by_output_error.h"
#include "mle/maintain/prediction.h"
#include "mle/maintain/stage.h"
#include "mle/nonlinear/output_reconstruction.h"

namespace mle {
namespace {

// Outputs lost for up to this many samples in a row have what a model expects
// of them in their place (output_reconstruction.h) where a regression on lagged
// data needs them: it loses as many rows as it has lags for each that is lost.
constexpr int kLongestFill = 30;

// Missing outputs filled in. Each window has an operating point of its own
// where the noise has one.
absl::StatusOr<std::vector<Record>> ScaledWindows(
    const EstimateSetting& setting, std::vector<Record> windows) {
  MLE_RETURN_IF_ERROR(
      FillOutputs(setting.filler, setting.noise, kLongestFill, windows)
          .status());
  const bool offsets =
      !setting.options.converter &&
      std::any_of(setting.noise.begin(), setting.noise.end(),
                  [](const NoiseEstimate& noise) { return noise.offset; });
  std::vector<Record> scaled;
  for (const Record& window : windows) {
    Record& record = scaled.emplace_back(Scaled(window, setting.scales));
    if (!offsets) continue;
    const Eigen::VectorXd means = ChannelMeans({record});
    record.outputs.colwise() -= means.head(record.num_outputs());
    record.inputs.colwise() -= means.tail(record.num_inputs());
  }
  return scaled;
}

ChannelScales UnitScales(const ProcessModel& model) {
  return {Eigen::VectorXd::Ones(model.num_outputs()),
          Eigen::VectorXd::Ones(model.num_inputs())};
}

// R + ΔR at λ (one for each output) by the solver and the loss asked for.
absl::StatusOr<ArxModel> SolveArx(const EstimationOptions& options,
                                  const Correction& correction,
                                  const Eigen::VectorXd& lambdas, double& gap) {
  gap = correction.MaxRelativeGap();
  if (options.output_error.robust_loss != RobustLoss::kNone) {
    RobustCorrectionOptions robust_options;
    robust_options.loss = options.output_error.robust_loss;
    MLE_ASSIGN_OR_RETURN(RobustCorrection robust,
                         CorrectRobustly(correction, lambdas, robust_options));
    gap = std::max(gap, robust.MaxRelativeGap());
    return std::move(robust.model);
  }
  if (options.solve_by_ceres) {
    MLE_ASSIGN_OR_RETURN(SmoothedCorrection smoothed,
                         CorrectSmoothed(correction, lambdas, {}));
    gap = std::max(gap, smoothed.MaxRelativeGap());
    return std::move(smoothed.model);
  }
  return correction.Model(lambdas);
}

absl::Status SolveArx(const EstimationOptions& options, EstimateFit& fit) {
  MLE_ASSIGN_OR_RETURN(fit.arx_model,
                       SolveArx(options, *fit.arx,
                                fit.arx->selection().lambda_star, fit.arx_gap));
  return absl::OkStatus();
}

// ΔR for the whole model.
absl::Status AddArx(const std::vector<Record>& windows, SharedFits& shared,
                    Estimate& estimate) {
  EstimateSetting& setting = estimate.setting;
  EstimateFit& fit = estimate.fit;
  const EstimationOptions& options = setting.options;
  setting.arx_outputs.assign(setting.arx_outputs.size(), true);
  const double start = ThreadSeconds();
  MLE_ASSIGN_OR_RETURN(setting.conversion,
                       ConvertModel(setting, setting.initial, setting.scales,
                                    windows.front().sample_time));
  fit.seconds -= ThreadSeconds() - start;
  if (!fit.change_proposed) return absl::OkStatus();
  const auto correct = [&]() -> absl::StatusOr<Correction> {
    MLE_ASSIGN_OR_RETURN(const std::vector<Record> scaled,
                         ScaledWindows(setting, windows));
    return CorrectModel(setting.conversion->model, scaled, options.correction);
  };
  MLE_ASSIGN_OR_RETURN(const Correction* const made,
                       shared.arx.Get(correct, fit.seconds));
  auto arx = std::make_shared<Correction>(*made);
  if (!(made->selection_options() == options.correction.selection)) {
    MLE_RETURN_IF_ERROR(arx->Select(options.correction.selection));
  }
  fit.arx = std::move(arx);
  return SolveArx(options, fit);
}

}  // namespace

Eigen::VectorXd DefaultLambdaGrid() {
  std::vector<double> lambdas = {0.0};
  for (int i = -84; i <= 12; ++i) lambdas.push_back(std::pow(10.0, i / 12.0));
  lambdas.push_back(kNoCorrectionLambda);
  return Eigen::Map<const Eigen::VectorXd>(
      lambdas.data(), static_cast<Eigen::Index>(lambdas.size()));
}

bool ProposesByArx(const Estimate& estimate, int output) {
  return estimate.fit.arx != nullptr && estimate.setting.arx_outputs[output];
}

bool ProposesElement(const Estimate& estimate, int output, int input) {
  if (ProposesByArx(estimate, output)) return true;
  return estimate.setting.options.estimator != Estimator::kArx &&
         estimate.fit.output_error.aged(output, input);
}

bool ProposesChange(const Estimate& estimate, int output) {
  for (int j = 0; j < estimate.setting.initial.num_inputs(); ++j) {
    if (ProposesElement(estimate, output, j)) return true;
  }
  return false;
}

bool ProposesAny(const Estimate& estimate) {
  for (int i = 0; i < estimate.setting.initial.num_outputs(); ++i) {
    if (ProposesChange(estimate, i)) return true;
  }
  return false;
}

void KeepInitialElement(int output, int input, Estimate& estimate) {
  OutputErrorCorrection& output_error = estimate.fit.output_error;
  OutputErrorFit& fit = output_error.corrected;
  output_error.aged(output, input) = false;
  fit.model.element(output, input) =
      estimate.setting.initial.element(output, input);
  ElementEstimate& element =
      fit.elements[output * fit.model.num_inputs() + input];
  if (element.state == ElementState::kFitted) {
    element.state = ElementState::kHeld;
  }
  for (ParameterEstimate* parameter :
       {&element.gain, &element.time_scale, &element.delay}) {
    *parameter = {.initial = parameter->initial,
                  .value = parameter->initial,
                  .lower = parameter->initial,
                  .upper = parameter->initial};
  }
  Eigen::MatrixXd& covariance = fit.covariances[output];
  if (covariance.rows() >= 3 * (input + 1)) {
    covariance.middleRows(3 * input, 3).setZero();
    covariance.middleCols(3 * input, 3).setZero();
  }
}

namespace {

// Takes ΔR back.
void KeepOwnRow(int output, Estimate& estimate) {
  if (!ProposesByArx(estimate, output)) return;
  EstimateSetting& setting = estimate.setting;
  estimate.fit.arx_model.R.row(output) =
      setting.conversion->model.R.row(output);
  setting.arx_outputs[output] = false;
  const std::vector<bool>& left = setting.arx_outputs;
  if (std::find(left.begin(), left.end(), true) == left.end()) {
    estimate.fit.arx.reset();
  }
}

}  // namespace

void KeepInitialOutput(int output, Estimate& estimate) {
  KeepOwnRow(output, estimate);
  for (int j = 0; j < estimate.setting.initial.num_inputs(); ++j) {
    if (estimate.fit.output_error.aged(output, j)) {
      KeepInitialElement(output, j, estimate);
    }
  }
}

absl::Status MakePredictors(const std::vector<Record>& windows,
                            Estimate& estimate) {
  const std::vector<Record> segments = JoinAdjoining(windows).records;
  const EstimateSetting& setting = estimate.setting;
  EstimateFit& fit = estimate.fit;
  const double sample_time = windows.front().sample_time;
  const auto predict =
      [&](const ProcessModel& model) -> absl::StatusOr<Predictor> {
    MLE_ASSIGN_OR_RETURN(const InputResponse response,
                         ResponseOf(model, sample_time));
    return PredictAsIn(segments, response);
  };
  MLE_ASSIGN_OR_RETURN(fit.initial, predict(setting.initial));
  fit.corrected = fit.initial;
  if (fit.arx != nullptr) {
    MLE_ASSIGN_OR_RETURN(
        fit.corrected,
        PredictAsIn(segments,
                    ResponseOf(Unscaled(fit.arx_model, setting.scales))));
  } else if (setting.options.estimator != Estimator::kArx &&
             fit.output_error.aged.any()) {
    MLE_ASSIGN_OR_RETURN(fit.corrected,
                         predict(fit.output_error.corrected.model));
  }
  return absl::OkStatus();
}

absl::Status EstimationOptions::Validate() const {
  if (change_test == ChangeTest::kAdequacy && estimator != Estimator::kArx) {
    return absl::InvalidArgumentError(
        absl::StrCat("change_test is adequacy, but estimator is ",
                     std::string(NameOf(estimator)),
                     ": that test is one of arx, as it has no structure"));
  }
  MLE_RETURN_IF_ERROR(output_error.Validate());
  MLE_RETURN_IF_ERROR(calibration.Validate());
  MLE_RETURN_IF_ERROR(conversion.Validate());
  return correction.Validate();
}

absl::StatusOr<ConversionSummary> ConvertModel(const EstimateSetting& setting,
                                               const ProcessModel& model,
                                               const ChannelScales& scales,
                                               double sample_time) {
  if (setting.options.converter) return setting.options.converter(model);
  return ConvertUnderNoise(model, setting.noise, scales, sample_time,
                           setting.options.conversion);
}

absl::StatusOr<Estimate> EstimateModel(const ProcessModel& initial,
                                       const std::vector<Record>& windows,
                                       const EstimationOptions& options,
                                       const ProgressCallback& progress,
                                       SharedFits* shared) {
  const double start = ThreadSeconds();
  MLE_RETURN_IF_ERROR(options.Validate());
  if (options.estimator == Estimator::kArx) {
    MLE_RETURN_IF_ERROR(CheckNotIntegrating(
        initial,
        "the estimator arx is for elements that settle: take output_error"));
  }
  const std::vector<Record> segments = JoinAdjoining(windows).records;
  SharedFits own;
  SharedFits& fits = shared == nullptr ? own : *shared;
  Estimate estimate;
  EstimateFit& fit = estimate.fit;
  MLE_RETURN_IF_ERROR(
      FitByOutputError(initial, segments, options, progress, fits, fit));
  EstimateSetting& setting = estimate.setting;
  setting.initial = initial;
  setting.options = options;
  setting.noise = fit.output_error.full.noise;
  setting.filler = fit.output_error.full.model;
  setting.scales = options.converter
                       ? UnitScales(initial)
                       : ChooseScales(initial, setting.noise, segments);
  setting.arx_outputs.assign(static_cast<std::size_t>(initial.num_outputs()),
                             false);
  if (options.estimator == Estimator::kArx) {
    const Stage correcting(progress, "correcting the ARX model");
    MLE_RETURN_IF_ERROR(correcting.status());
    MLE_RETURN_IF_ERROR(AddArx(windows, fits, estimate));
  }
  MLE_RETURN_IF_ERROR(MakePredictors(windows, estimate));
  fit.seconds += ThreadSeconds() - start;
  return estimate;
}

}  // namespace mle
