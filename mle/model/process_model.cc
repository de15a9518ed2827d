#include "mle/model/process_model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// No text file takes a NUL.
absl::Status CheckText(const std::string& text, const std::string& what) {
  if (text.find('\0') == std::string::npos) return absl::OkStatus();
  return InvalidArgument(what, " has a NUL character in it");
}

// Adds the names of `channels`, each once, to `seen`.
template <typename Channel>
absl::Status AddNames(const std::vector<Channel>& channels, const char* kind,
                      std::set<std::string>& seen) {
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const std::string& name = channels[i].name;
    if (name.empty()) {
      return InvalidArgument(kind, "s[", i,
                             "]: name is empty, each channel needs one");
    }
    MLE_RETURN_IF_ERROR(
        CheckText(name, absl::StrCat(kind, "s[", i, "]: name")));
    MLE_RETURN_IF_ERROR(
        CheckText(channels[i].unit, absl::StrCat(kind, "s[", i, "]: unit")));
    if (!seen.insert(name).second) {
      return InvalidArgument(
          kind, "s[", i, "]: name \"", name,
          "\" is used already; the names of inputs and outputs must differ");
    }
    if (const absl::Status status = channels[i].transform.Validate();
        !status.ok()) {
      return InvalidArgument(kind, " \"", name,
                             "\": transform: ", status.message());
    }
  }
  return absl::OkStatus();
}

template <typename Channel>
absl::Status CheckSameNames(const std::vector<Channel>& a,
                            const std::string& a_name,
                            const std::vector<Channel>& b,
                            const std::string& b_name, const char* kind) {
  if (a.size() != b.size()) {
    return InvalidArgument(a_name, " has ", a.size(), " ", kind, "s, ", b_name,
                           " ", b.size(), "; they must be the same");
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].name != b[i].name) {
      return InvalidArgument(kind, "s[", i, "] is \"", a[i].name, "\" in ",
                             a_name, " and \"", b[i].name, "\" in ", b_name,
                             "; the names must be the same, in the same order");
    }
  }
  return absl::OkStatus();
}

// dz/dx of each channel at its value; 1 where none is given. Values that are
// used leave `left`.
template <typename Channel>
absl::StatusOr<Eigen::VectorXd> SlopesAt(const std::vector<Channel>& channels,
                                         std::map<std::string, double>& left) {
  Eigen::VectorXd slopes =
      Eigen::VectorXd::Ones(static_cast<Eigen::Index>(channels.size()));
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto value = left.find(channels[i].name);
    if (value == left.end()) continue;
    const Transform& transform = channels[i].transform;
    const double slope = transform.Slope(value->second);
    if (!(slope > 0.0 && std::isfinite(slope))) {
      return InvalidArgument(channels[i].name, " = ", value->second,
                             ": its transform (", transform.Description(),
                             ") has no value there");
    }
    slopes[static_cast<Eigen::Index>(i)] = slope;
    left.erase(value);
  }
  return slopes;
}

}  // namespace

ProcessModel::ProcessModel(std::string name, std::string time_unit,
                           std::vector<InputChannel> inputs,
                           std::vector<OutputChannel> outputs)
    : name_(std::move(name)),
      time_unit_(std::move(time_unit)),
      inputs_(std::move(inputs)),
      outputs_(std::move(outputs)),
      elements_(inputs_.size() * outputs_.size()) {}

absl::Status ProcessModel::Validate() const {
  if (inputs_.empty()) {
    return absl::InvalidArgumentError("inputs is empty, must hold at least 1");
  }
  if (outputs_.empty()) {
    return absl::InvalidArgumentError("outputs is empty, must hold at least 1");
  }
  MLE_RETURN_IF_ERROR(CheckText(name_, "name"));
  MLE_RETURN_IF_ERROR(CheckText(time_unit_, "time_unit"));
  std::set<std::string> seen;
  MLE_RETURN_IF_ERROR(AddNames(inputs_, "input", seen));
  MLE_RETURN_IF_ERROR(AddNames(outputs_, "output", seen));
  for (int i = 0; i < num_outputs(); ++i) {
    for (int j = 0; j < num_inputs(); ++j) {
      const absl::Status status = element(i, j).Validate();
      if (!status.ok()) {
        return InvalidArgument("element of output \"", outputs_[i].name,
                               "\", input \"", inputs_[j].name,
                               "\": ", status.message());
      }
    }
  }
  return absl::OkStatus();
}

StepResponse ProcessModel::ComputeStepResponse(double sample_time,
                                               int samples) const {
  CHECK_GE(samples, 0);
  StepResponse response(sample_time, num_outputs(), num_inputs(), samples);
  for (int i = 0; i < num_outputs(); ++i) {
    for (int j = 0; j < num_inputs(); ++j) {
      response.element(i, j) = element(i, j).StepResponse(sample_time, samples);
    }
  }
  if (mle::IsIntegrating(*this)) {
    response.integration = IntegrationOrders(*this);
  }
  return response;
}

absl::Status CheckSameChannels(const ProcessModel& a, std::string_view a_name,
                               const ProcessModel& b, std::string_view b_name) {
  const std::string name_a(a_name);
  const std::string name_b(b_name);
  MLE_RETURN_IF_ERROR(
      CheckSameNames(a.inputs(), name_a, b.inputs(), name_b, "input"));
  MLE_RETURN_IF_ERROR(
      CheckSameNames(a.outputs(), name_a, b.outputs(), name_b, "output"));
  if (a.time_unit() != b.time_unit()) {
    return InvalidArgument("time_unit is \"", a.time_unit(), "\" in ", name_a,
                           " and \"", b.time_unit(), "\" in ", name_b,
                           "; it must be the same");
  }
  return absl::OkStatus();
}

Eigen::MatrixXd StaticGains(const ProcessModel& model) {
  Eigen::MatrixXd gains(model.num_outputs(), model.num_inputs());
  for (const auto& [i, j] : Pairs(model)) {
    gains(i, j) = model.element(i, j).StaticGain();
  }
  return gains;
}

Eigen::MatrixXi IntegrationOrders(const ProcessModel& model) {
  Eigen::MatrixXi orders(model.num_outputs(), model.num_inputs());
  for (const auto& [i, j] : Pairs(model)) {
    orders(i, j) = model.element(i, j).IntegrationOrder();
  }
  return orders;
}

bool IsIntegrating(const ProcessModel& model) {
  return (IntegrationOrders(model).array() > 0).any();
}

bool IsIntegrating(const ProcessModel& model, int output) {
  return (IntegrationOrders(model).row(output).array() > 0).any();
}

bool HasTransforms(const ProcessModel& model) {
  const auto has = [](const auto& channels) {
    return std::any_of(
        channels.begin(), channels.end(),
        [](const auto& channel) { return !channel.transform.IsNone(); });
  };
  return has(model.inputs()) || has(model.outputs());
}

ProcessModel WithoutTransforms(ProcessModel model) {
  for (int j = 0; j < model.num_inputs(); ++j) model.set_input_transform(j, {});
  for (int i = 0; i < model.num_outputs(); ++i) {
    model.set_output_transform(i, {});
  }
  return model;
}

absl::StatusOr<ProcessModel> LinearAt(
    const ProcessModel& model, const std::map<std::string, double>& values) {
  std::map<std::string, double> left = values;
  MLE_ASSIGN_OR_RETURN(const Eigen::VectorXd input_slopes,
                       SlopesAt(model.inputs(), left));
  MLE_ASSIGN_OR_RETURN(const Eigen::VectorXd output_slopes,
                       SlopesAt(model.outputs(), left));
  if (!left.empty()) {
    return InvalidArgument("the model has no channel '", left.begin()->first,
                           "'");
  }
  ProcessModel linear = WithoutTransforms(model);
  for (const auto& [i, j] : Pairs(model)) {
    const TransferFunction& g = model.element(i, j);
    if (g.IsZero()) continue;
    std::vector<double> numerator = g.numerator();
    for (double& b : numerator) b *= input_slopes[j] / output_slopes[i];
    linear.element(i, j) =
        TransferFunction(std::move(numerator), g.denominator(), g.delay());
  }
  MLE_RETURN_IF_ERROR(linear.Validate());
  return linear;
}

int NumElements(const ProcessModel& model) {
  int count = 0;
  for (const auto& [i, j] : Pairs(model)) {
    count += model.element(i, j).IsZero() ? 0 : 1;
  }
  return count;
}

std::vector<bool> IntegratingOutputs(const ProcessModel& model) {
  std::vector<bool> outputs(model.num_outputs());
  for (int i = 0; i < model.num_outputs(); ++i) {
    outputs[i] = IsIntegrating(model, i);
  }
  return outputs;
}

absl::Status CheckNotIntegrating(const ProcessModel& model,
                                 std::string_view what) {
  const Eigen::MatrixXi orders = IntegrationOrders(model);
  for (const auto& [i, j] : Pairs(model)) {
    if (orders(i, j) == 0) continue;
    return InvalidArgument(
        PairName(model, i, j),
        " integrates (a pole at s = 0: a level, a pressure, an inventory); ",
        std::string(what));
  }
  return absl::OkStatus();
}

double SettlingTime(const ProcessModel& model) {
  double longest = 0.0;
  for (const auto& [i, j] : Pairs(model)) {
    const TransferFunction& element = model.element(i, j);
    if (element.IsZero()) continue;
    const double T = element.SlowestTimeConstant();
    longest =
        std::max(longest, element.IsIntegrating()
                              ? kLevelSettlingTimes * (element.delay() + T)
                              : element.delay() + 5.0 * T);
  }
  return longest;
}

std::vector<InputRole> InputRoles(const ProcessModel& model) {
  std::vector<InputRole> roles;
  for (const InputChannel& input : model.inputs()) roles.push_back(input.role);
  return roles;
}

std::vector<PairPlace> Pairs(const ProcessModel& model) {
  std::vector<PairPlace> pairs;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) pairs.push_back({i, j});
  }
  return pairs;
}

std::string PairName(const ProcessModel& model, int output, int input) {
  return absl::StrCat(model.outputs()[output].name, " ← ",
                      model.inputs()[input].name);
}

}  // namespace mle
