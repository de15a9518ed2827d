#include "sim/plant.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/base/status.h"
#include "sim/fastest_time_constant.h"

namespace mle::sim {
namespace {

constexpr double kDelaySnap = 1e-9;  // of Δt
constexpr double kMaxDelaySamples = 1e7;
constexpr double kMinStep = 1e-15;  // of Δt

HeldInputMap MapOver(double interval, double largest_step,
                     const StateSpace& system) {
  // An interval that is a whole number of largest steps but for rounding is
  // not cut once more.
  const double steps = std::ceil(interval / largest_step * (1.0 - 1e-12));
  return HeldInputMap::ByRungeKutta4(
      system.A, system.B, interval,
      std::max<std::int64_t>(1, static_cast<std::int64_t>(steps)));
}

void Apply(const HeldInputMap& map, double input, Eigen::VectorXd& state,
           Eigen::VectorXd& next_state) {
  next_state = state + map.E.lazyProduct(state) + map.gamma * input;
  state.swap(next_state);
}

}  // namespace

absl::Status PlantOptions::Validate() const {
  if (!(sample_time > 0.0) || !std::isfinite(sample_time)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "sample_time = ", sample_time, ", but it must be finite and > 0"));
  }
  if (!(relative_step > 0.0) || relative_step > 1.0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "relative_step = ", relative_step, ", but it must be in (0, 1]"));
  }
  return absl::OkStatus();
}

absl::StatusOr<Plant> Plant::Create(const ProcessModel& model,
                                    const PlantOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(model.Validate());
  Plant plant;
  int longest_delay = 0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (model.element(i, j).IsZero()) continue;
      absl::StatusOr<Element> element =
          MakeElement(model.element(i, j), options);
      if (!element.ok()) {
        return absl::Status(element.status().code(),
                            absl::StrCat("element (", model.outputs()[i].name,
                                         ", ", model.inputs()[j].name,
                                         "): ", element.status().message()));
      }
      element->output = i;
      element->input = j;
      longest_delay = std::max(longest_delay, element->whole_delay);
      plant.elements_.push_back(*std::move(element));
    }
  }
  plant.history_ = Eigen::MatrixXd::Zero(model.num_inputs(), longest_delay + 2);
  plant.outputs_ = Eigen::VectorXd::Zero(model.num_outputs());
  return plant;
}

absl::StatusOr<Plant::Element> Plant::MakeElement(
    const TransferFunction& transfer, const PlantOptions& options) {
  const double delay = transfer.delay() / options.sample_time;
  if (delay > kMaxDelaySamples) {
    return absl::InvalidArgumentError(
        absl::StrCat("the delay of ", transfer.delay(), " is ", delay,
                     " samples, but at most ", kMaxDelaySamples,
                     " are supported; use a longer sample time"));
  }
  Element element;
  const double whole = std::floor(delay + kDelaySnap);
  const double fraction = std::max(0.0, delay - whole);  // f
  element.whole_delay = static_cast<int>(whole);
  element.has_split = fraction >= kDelaySnap;

  const StateSpace system = transfer.Realize();
  element.C = system.C;
  element.D = system.D;
  element.state = Eigen::VectorXd::Zero(system.A.rows());
  element.next_state = element.state;
  if (element.state.size() == 0) return element;

  const double time_constant = FastestTimeConstant(transfer.denominator());
  const double largest_step = options.relative_step * time_constant;
  if (!(largest_step >= kMinStep * options.sample_time)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "its fastest time constant of ", time_constant,
        " by relative_step = ", options.relative_step, " is below ", kMinStep,
        " of the sample time ", options.sample_time, "; leave that mode out"));
  }
  const double split = element.has_split ? fraction * options.sample_time : 0.0;
  if (element.has_split) {
    element.first_part = MapOver(split, largest_step, system);
  }
  element.rest = MapOver(options.sample_time - split, largest_step, system);
  return element;
}

void Plant::Advance(const Eigen::Ref<const Eigen::VectorXd>& input) {
  CHECK_EQ(input.size(), history_.rows());
  newest_ = newest_ + 1 == history_.cols() ? 0 : newest_ + 1;
  history_.col(newest_) = input;
  outputs_.setZero();
  for (Element& element : elements_) {
    const double present = PastInput(element.input, element.whole_delay);
    double output = element.D * present;
    if (element.state.size() > 0) {
      if (element.has_split) {
        Apply(element.first_part,
              PastInput(element.input, element.whole_delay + 1), element.state,
              element.next_state);
      }
      Apply(element.rest, present, element.state, element.next_state);
      output += element.C.dot(element.state);
    }
    outputs_[element.output] += output;
  }
}

double Plant::PastInput(int input, int age) const {
  const int column = newest_ - age;
  return history_(
      input, column < 0 ? column + static_cast<int>(history_.cols()) : column);
}

}  // namespace mle::sim
