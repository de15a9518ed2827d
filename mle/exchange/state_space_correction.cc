#include "mle/exchange/state_space_correction.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "mle/base/status.h"
#include "mle/exchange/element_table.h"
#include "mle/model/held_response.h"
#include "mle/model/row_realization.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// A part of ψ_ij − φ_ij: x ← A x + b v, y = c x, v the input `delay` samples
// ago in all.
struct Part {
  int output = 0;
  int input = 0;
  int delay = 0;
  RowElement element;
};

absl::Status AddPart(const ProcessModel& model, int i, int j,
                     const TransferFunction& g, double sign, double sample_time,
                     std::vector<Part>& parts) {
  if (g.IsZero()) return absl::OkStatus();
  const absl::StatusOr<HeldResponse> held =
      HeldResponse::Create(g, sample_time);
  if (!held.ok()) {
    return InvalidArgument(PairName(model, i, j), ": ",
                           held.status().message());
  }
  Part part{.output = i,
            .input = j,
            .delay = held->whole_delay,
            .element = RowElement::Of(*held)};
  part.element.c *= sign;
  parts.push_back(std::move(part));
  return absl::OkStatus();
}

// ψ − φ of one element where poles and dead time have stayed.
TransferFunction Difference(const TransferFunction& after,
                            const TransferFunction& before) {
  std::vector<double> longer = after.numerator();
  std::vector<double> shorter = before.numerator();
  const std::size_t degree = std::max(longer.size(), shorter.size());
  longer.insert(longer.begin(), degree - longer.size(), 0.0);
  shorter.insert(shorter.begin(), degree - shorter.size(), 0.0);
  for (std::size_t k = 0; k < degree; ++k) longer[k] -= shorter[k];
  return TransferFunction(std::move(longer), after.denominator(),
                          after.delay());
}

absl::StatusOr<std::vector<Part>> PartsOf(const ProcessModel& before,
                                          const ProcessModel& after,
                                          double sample_time) {
  std::vector<Part> parts;
  for (const auto& [i, j] : Pairs(after)) {
    const TransferFunction& old = before.element(i, j);
    const TransferFunction& g = after.element(i, j);
    if (IsSameElement(g, old)) continue;
    if (g.denominator() == old.denominator() && g.delay() == old.delay()) {
      MLE_RETURN_IF_ERROR(
          AddPart(after, i, j, Difference(g, old), 1.0, sample_time, parts));
      continue;
    }
    MLE_RETURN_IF_ERROR(AddPart(after, i, j, g, 1.0, sample_time, parts));
    MLE_RETURN_IF_ERROR(AddPart(after, i, j, old, -1.0, sample_time, parts));
  }
  return parts;
}

// The states of `given` first, then lines of inputs, lines of outputs, parts.
class Composition {
 public:
  Composition(const DiscreteStateSpace& given, std::vector<Part> parts)
      : given_(given), parts_(std::move(parts)) {
    ShortenDelays();
    Place();
  }

  Index order() const { return order_; }
  DiscreteStateSpace Compose() const;

 private:
  // No dead time taken out is longer than that of any part.
  void ShortenDelays();
  void Place();
  int LeftOf(const Part& part) const {
    return part.delay - input_delays_[part.input] - output_delays_[part.output];
  }
  // Lets input j of `late` samples ago, which is a state or the input itself,
  // act on the states from `row` on by `weights`.
  void Feed(int j, int late, Index row, const Eigen::VectorXd& weights,
            DiscreteStateSpace& system) const;

  const DiscreteStateSpace& given_;
  std::vector<Part> parts_;
  std::vector<int> input_delays_;
  std::vector<int> output_delays_;
  std::vector<int> input_lines_;   // states of the line of each input
  std::vector<int> output_lines_;  // likewise
  std::vector<Index> input_first_;
  std::vector<Index> output_first_;
  std::vector<Index> part_first_;
  Index order_ = 0;
};

void Composition::ShortenDelays() {
  input_delays_ = given_.input_delays;
  output_delays_ = given_.output_delays;
  for (const Part& part : parts_) {
    int& delay = output_delays_[part.output];
    delay = std::min(delay, part.delay);
  }
  for (const Part& part : parts_) {
    int& delay = input_delays_[part.input];
    delay = std::min(delay, part.delay - output_delays_[part.output]);
  }
}

void Composition::Place() {
  order_ = given_.order();
  for (int j = 0; j < given_.num_inputs(); ++j) {
    input_lines_.push_back(given_.input_delays[j] - input_delays_[j]);
  }
  for (const Part& part : parts_) {
    int& line = input_lines_[part.input];
    line = std::max(line, LeftOf(part));
  }
  for (const int line : input_lines_) {
    input_first_.push_back(order_);
    order_ += line;
  }
  for (int i = 0; i < given_.num_outputs(); ++i) {
    output_lines_.push_back(given_.output_delays[i] - output_delays_[i]);
    output_first_.push_back(order_);
    order_ += output_lines_.back();
  }
  for (const Part& part : parts_) {
    part_first_.push_back(order_);
    order_ += part.element.b.size();
  }
}

void Composition::Feed(int j, int late, Index row,
                       const Eigen::VectorXd& weights,
                       DiscreteStateSpace& system) const {
  auto column =
      late == 0 ? system.B.col(j) : system.A.col(input_first_[j] + late - 1);
  column.segment(row, weights.size()) = weights;
}

DiscreteStateSpace Composition::Compose() const {
  const Index n = given_.order();
  const int m = given_.num_inputs();
  const int p = given_.num_outputs();
  DiscreteStateSpace system;
  system.sample_time = given_.sample_time;
  system.input_delays = input_delays_;
  system.output_delays = output_delays_;
  system.A = MatrixXd::Zero(order_, order_);
  system.B = MatrixXd::Zero(order_, m);
  system.C = MatrixXd::Zero(p, order_);
  system.D = given_.D;
  system.A.topLeftCorner(n, n) = given_.A;
  for (int j = 0; j < m; ++j) {
    for (int k = 0; k < input_lines_[j]; ++k) {
      Feed(j, k, input_first_[j] + k, Eigen::VectorXd::Ones(1), system);
    }
    Feed(j, given_.input_delays[j] - input_delays_[j], 0, given_.B.col(j),
         system);
  }
  for (int i = 0; i < p; ++i) {
    const Index first = output_first_[i];
    const int line = output_lines_[i];
    if (line == 0) {
      system.C.row(i).head(n) = given_.C.row(i);
      continue;
    }
    system.A.row(first).head(n) = given_.C.row(i);
    for (int k = 1; k < line; ++k) system.A(first + k, first + k - 1) = 1.0;
    system.C(i, first + line - 1) = 1.0;
  }
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Part& part = parts_[k];
    const Index first = part_first_[k];
    const Index size = part.element.b.size();
    system.A.block(first, first, size, size) = part.element.A;
    Feed(part.input, LeftOf(part), first, part.element.b, system);
    system.C.row(part.output).segment(first, size) = part.element.c;
  }
  return system;
}

}  // namespace

absl::StatusOr<DiscreteStateSpace> WithChange(const DiscreteStateSpace& system,
                                              const ProcessModel& before,
                                              const ProcessModel& after) {
  MLE_ASSIGN_OR_RETURN(std::vector<Part> parts,
                       PartsOf(before, after, system.sample_time));
  if (parts.empty()) return system;
  const Composition composition(system, std::move(parts));
  if (composition.order() > system.order() + kMostAddedStates) {
    return InvalidArgument("state-space model: the correction takes ",
                           composition.order() - system.order(),
                           " states more than before, at "
                           "most ",
                           kMostAddedStates, " are supported");
  }
  return composition.Compose();
}

}  // namespace mle
