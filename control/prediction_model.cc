#include "control/prediction_model.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle::control {
namespace {

using Eigen::VectorXd;

constexpr double kSettlingRemainder = 1e-11;  // of the gain
constexpr double kArxRemainder = 1e-8;        // of the largest value
constexpr double kMaxValues = 1e8;
// Beyond any plant; ARX responses that grow without bound stop at 1e100.
constexpr double kUnbounded = 1e60;

// The time in which what remains of a step response, or of its way to a ramp,
// falls to about `remainder` of the gain. r equal real modes of time constant T
// leave e^{−x} Σ_{k<r} x^k/k! after xT, and modes further apart leave less.
double SettlingTime(const TransferFunction& element, double remainder) {
  const double T = element.SlowestTimeConstant();
  if (T == 0.0) return element.delay();
  const int order = static_cast<int>(element.denominator().size()) - 1 -
                    element.IntegrationOrder();
  double x = 0.0;
  for (double left = 1.0; left > remainder;) {
    x += 1.0;
    left = 0.0;
    for (int k = order - 1; k >= 0; --k) left = left * x / (k + 1) + 1.0;
    left *= std::exp(-x);
  }
  return element.delay() + x * T;
}

// Control periods after which the whole model has settled.
double SettlingPeriods(const ProcessModel& model, double control_period) {
  double longest = 0.0;
  for (const auto& [i, j] : Pairs(model)) {
    const TransferFunction& element = model.element(i, j);
    if (element.IsZero()) continue;
    longest = std::max(longest, SettlingTime(element, kSettlingRemainder));
  }
  return std::ceil(longest / control_period) + 1.0;
}

absl::Status CheckControlPeriod(double control_period) {
  if (control_period > 0.0 && std::isfinite(control_period)) {
    return absl::OkStatus();
  }
  return InvalidArgument("control_period = ", control_period,
                         ", but it must be finite and > 0");
}

// How often `sample_time` goes into `control_period`.
absl::StatusOr<int> SamplesPerPeriod(double control_period,
                                     double sample_time) {
  MLE_RETURN_IF_ERROR(CheckControlPeriod(control_period));
  const double ratio = control_period / sample_time;
  const double whole = std::round(ratio);
  if (!(whole >= 1.0) || !(whole <= 1e9) ||
      std::abs(ratio - whole) > 1e-9 * whole) {
    return InvalidArgument(
        "control_period = ", control_period,
        " is not a whole multiple of the model's sample time ", sample_time);
  }
  return static_cast<int>(whole);
}

// The growth in a sample of a response that ends in a ramp; 0 for others.
double SlopeOf(const StepResponse& response, int output, int input) {
  if (!response.IsIntegrating(output, input)) return 0.0;
  const auto values = response.element(output, input);
  return values[values.size() - 1] - values[values.size() - 2];
}

// How far a response leaves its end, the last value or the ramp through it, in
// its last tenth, over its largest magnitude.
double Unsettled(const StepResponse& response, int output, int input) {
  const VectorXd values = response.element(output, input);
  const double largest = values.cwiseAbs().maxCoeff();
  if (largest == 0.0) return 0.0;
  const Eigen::Index tail =
      std::min(std::max<Eigen::Index>(5, values.size() / 10), values.size());
  const double slope = SlopeOf(response, output, input);
  double most = 0.0;
  for (Eigen::Index back = 0; back < tail; ++back) {
    const double ramp = slope * static_cast<double>(back);
    most = std::max(most, std::abs(values[values.size() - 1 - back] + ramp -
                                   values[values.size() - 1]));
  }
  return most / largest;
}

double WorstUnsettled(const StepResponse& response) {
  double worst = 0.0;
  for (int i = 0; i < response.num_outputs; ++i) {
    for (int j = 0; j < response.num_inputs; ++j) {
      worst = std::max(worst, Unsettled(response, i, j));
    }
  }
  return worst;
}

absl::Status CheckSettled(const StepResponse& response, double tolerance) {
  for (int i = 0; i < response.num_outputs; ++i) {
    for (int j = 0; j < response.num_inputs; ++j) {
      const auto element = response.element(i, j);
      if (!element.allFinite() || element.cwiseAbs().maxCoeff() > kUnbounded) {
        return absl::FailedPreconditionError(absl::StrCat(
            "the step response of output ", i + 1, " to input ", j + 1,
            " is not finite or grows without bound: the model is unstable"));
      }
      const double left = Unsettled(response, i, j);
      if (left <= tolerance) continue;
      const bool ramp = response.IsIntegrating(i, j);
      return absl::FailedPreconditionError(absl::StrCat(
          "the step response of output ", i + 1, " to input ", j + 1,
          ramp ? " is no ramp yet" : " has not settled",
          ": in the last tenth of its ",
          (response.samples() - 1) * response.sample_time,
          " time units it still ", ramp ? "leaves its last slope" : "moves",
          " by ", 100.0 * left, " % of its largest value, but at most ",
          100.0 * tolerance, " % are allowed; it is too short",
          ramp ? "" : ", integrating or unstable"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<InputRole>> RolesFor(
    const std::vector<InputRole>& roles, int num_inputs) {
  if (roles.empty()) {
    return std::vector<InputRole>(num_inputs, InputRole::kManipulated);
  }
  if (static_cast<int>(roles.size()) != num_inputs) {
    return InvalidArgument(roles.size(), " roles are given for ", num_inputs,
                           " inputs; give one each, or none");
  }
  return roles;
}

// S_0; …; S_n from every `stride`-th sample; n at least 1, the last sample
// held, or its ramp followed, where it falls between two instants.
PredictionModel Stack(const StepResponse& response,
                      const std::vector<InputRole>& roles,
                      double control_period, int stride) {
  const int p = response.num_outputs;
  const int last = response.samples() - 1;
  const int n = std::max(1, (last + stride - 1) / stride);
  PredictionModel model;
  model.control_period = control_period;
  model.num_outputs = p;
  model.roles = roles;
  model.responses.resize(p * (n + 1), response.num_inputs);
  for (int j = 0; j < response.num_inputs; ++j) {
    for (int i = 0; i < p; ++i) {
      const double slope = SlopeOf(response, i, j);
      for (int k = 0; k <= n; ++k) {
        model.responses(k * p + i, j) =
            response.element(i, j)[std::min(k * stride, last)] +
            slope * std::max(k * stride - last, 0);
      }
      if (!response.IsIntegrating(i, j)) continue;
      if (model.slopes.size() == 0) {
        model.slopes = Eigen::MatrixXd::Zero(p, response.num_inputs);
      }
      model.slopes(i, j) = slope * stride;
    }
  }
  return model;
}

}  // namespace

absl::Status PredictionModel::Validate() const {
  MLE_RETURN_IF_ERROR(CheckControlPeriod(control_period));
  if (num_outputs < 1 || roles.empty()) {
    return InvalidArgument(
        "a prediction model needs an output and an input, but has ",
        num_outputs, " and ", roles.size());
  }
  if (responses.cols() != num_inputs() || responses.rows() < 2 * num_outputs ||
      responses.rows() % num_outputs != 0) {
    return InvalidArgument("the responses are ", responses.rows(), " × ",
                           responses.cols(), ", but they must be ", num_outputs,
                           "(n + 1) × ", num_inputs(), " with n ≥ 1");
  }
  if (!responses.allFinite()) {
    return absl::InvalidArgumentError(
        "the step responses have values that are not finite");
  }
  if (slopes.size() > 0 &&
      (slopes.rows() != num_outputs || slopes.cols() != num_inputs() ||
       !slopes.allFinite())) {
    return InvalidArgument("the slopes are ", slopes.rows(), " × ",
                           slopes.cols(), ", but they must be finite and ",
                           num_outputs, " × ", num_inputs(), ", or empty");
  }
  if (!responses.topRows(num_outputs).isZero(0.0)) {
    return absl::InvalidArgumentError(
        "the step responses must start at zero: a sample is taken just before "
        "the input changes");
  }
  return absl::OkStatus();
}

int PredictionModel::periods() const {
  return static_cast<int>(responses.rows()) / num_outputs - 1;
}

Eigen::MatrixXd PredictionModel::SlopesOf(
    const std::vector<int>& inputs) const {
  if (slopes.size() == 0) {
    return Eigen::MatrixXd::Zero(num_outputs,
                                 static_cast<Eigen::Index>(inputs.size()));
  }
  return slopes(Eigen::all, inputs);
}

void PredictionModel::ReachTo(int instants) {
  const int p = num_outputs;
  const int n = periods();
  if (n >= instants) return;
  responses.conservativeResize(Eigen::Index{p} * (instants + 1),
                               Eigen::NoChange);
  for (int k = n + 1; k <= instants; ++k) {
    responses.middleRows(p * k, p) = responses.middleRows(p * (k - 1), p);
    if (slopes.size() > 0) responses.middleRows(p * k, p) += slopes;
  }
}

std::vector<int> PredictionModel::InputsOf(InputRole role) const {
  std::vector<int> inputs;
  for (int j = 0; j < num_inputs(); ++j) {
    if (roles[j] == role) inputs.push_back(j);
  }
  return inputs;
}

absl::StatusOr<PredictionModel> PredictFromProcess(const ProcessModel& model,
                                                   double control_period) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(CheckControlPeriod(control_period));
  const double periods = SettlingPeriods(model, control_period);
  if (!((periods + 1.0) * model.num_outputs() * model.num_inputs() <=
        kMaxValues)) {
    return InvalidArgument(
        "the model '", model.name(), "' settles in ", periods,
        " control periods of ", control_period, ": too many for its ",
        model.num_outputs(), " × ", model.num_inputs(),
        " step responses to be kept; use a longer control_period");
  }
  PredictionModel prediction = Stack(
      model.ComputeStepResponse(control_period, static_cast<int>(periods) + 1),
      InputRoles(model), control_period, 1);
  if (mle::IsIntegrating(model)) {
    prediction.slopes = (IntegrationOrders(model).array() > 0)
                            .select(control_period * StaticGains(model), 0.0);
  }
  return prediction;
}

absl::StatusOr<PredictionModel> PredictFromStepResponse(
    const StepResponse& response, const std::vector<InputRole>& roles,
    double control_period, double settling_tolerance) {
  const Eigen::Index pairs =
      Eigen::Index{response.num_outputs} * response.num_inputs;
  if (response.num_outputs < 1 || response.num_inputs < 1 ||
      response.samples() < 2 || response.values.cols() != pairs ||
      (response.integration.size() > 0 &&
       response.integration.size() != pairs)) {
    return InvalidArgument(
        "a step response of ", response.num_outputs, " outputs, ",
        response.num_inputs, " inputs and ", response.samples(),
        " samples cannot be used: at least 1, 1 and 2 are needed");
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<InputRole> all_roles,
                       RolesFor(roles, response.num_inputs));
  MLE_ASSIGN_OR_RETURN(const int stride,
                       SamplesPerPeriod(control_period, response.sample_time));
  PredictionModel model = Stack(response, all_roles, control_period, stride);
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(CheckSettled(response, settling_tolerance));
  return model;
}

absl::StatusOr<PredictionModel> PredictFromArx(
    const ArxModel& model, const std::vector<InputRole>& roles,
    double control_period, double max_duration) {
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(
      SamplesPerPeriod(control_period, model.sample_time).status());
  const double memory = model.order * model.sample_time;
  const double longest = max_duration > 0.0 ? max_duration : 200.0 * memory;
  const double values = kMaxValues / (model.num_outputs * model.num_inputs);
  const int most =
      static_cast<int>(std::clamp(longest / model.sample_time, 1.0, values));
  // Twice as long until it has settled; its last tenth spans the model's
  // memory.
  int length = static_cast<int>(std::min<double>(most, 20.0 * model.order));
  StepResponse response = model.ComputeStepResponse(length + 1);
  while (length < most && WorstUnsettled(response) > kArxRemainder) {
    length = static_cast<int>(std::min<double>(most, 2.0 * length));
    response = model.ComputeStepResponse(length + 1);
  }
  return PredictFromStepResponse(response, roles, control_period);
}

}  // namespace mle::control
