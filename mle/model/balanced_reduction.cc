#include "mle/model/balanced_reduction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "Eigen/SVD"
#include "absl/strings/str_cat.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/model/held_response.h"
#include "mle/model/integrator_split.h"
#include "mle/model/response_difference.h"
#include "mle/model/row_realization.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Settling times that step responses are compared over.
constexpr double kSettled = 2.0;
constexpr double kFewestSamples = 10.0;
constexpr double kMostSamples = 20000.0;
// The response of an integrator alone besides its ramp is rounding of the dead
// time, where below this share of the ramp's rise over a sample.
constexpr double kNothingLeft = 1e-8;
// A singular value below this share of σ_1, times the number of states, is
// rounding.
constexpr double kRounding = 1e-15;

// Elements of the model; none where a pair is zero. Row by row.
using Responses = std::vector<std::optional<HeldResponse>>;

struct Delays {
  std::vector<int> inputs;
  std::vector<int> outputs;
  double line = 0.0;  // samples of all rows' lines together
};

absl::StatusOr<Responses> ResponsesOf(const ProcessModel& model,
                                      double sample_time) {
  Responses responses;
  bool any = false;
  for (const auto& [i, j] : Pairs(model)) {
    responses.emplace_back();
    if (model.element(i, j).IsZero()) continue;
    any = true;
    absl::StatusOr<HeldResponse> response =
        HeldResponse::Create(model.element(i, j), sample_time);
    if (!response.ok()) {
      return absl::Status(response.status().code(),
                          absl::StrCat(PairName(model, i, j), ": ",
                                       response.status().message()));
    }
    responses.back() = *std::move(response);
  }
  if (any) return responses;
  return InvalidArgument("state-space model: every element of '", model.name(),
                         "' is zero");
}

// The dead times of the outputs first, or of the inputs: what the elements of
// one have in common, then of the other what is left.
Delays TakeOut(const Responses& responses, int p, int m, bool outputs_first) {
  constexpr int kNone = std::numeric_limits<int>::max();
  Delays delays = {std::vector<int>(m, 0), std::vector<int>(p, 0)};
  const auto left = [&](int i, int j) {
    const std::optional<HeldResponse>& response = responses[i * m + j];
    return response.has_value()
               ? response->whole_delay - delays.inputs[j] - delays.outputs[i]
               : kNone;
  };
  const auto take = [&](bool outputs) {
    for (int a = 0; a < (outputs ? p : m); ++a) {
      int common = kNone;
      for (int b = 0; b < (outputs ? m : p); ++b) {
        common = std::min(common, outputs ? left(a, b) : left(b, a));
      }
      if (common != kNone) {
        (outputs ? delays.outputs : delays.inputs)[a] = common;
      }
    }
  };
  take(outputs_first);
  take(!outputs_first);
  for (int i = 0; i < p; ++i) {
    int longest = 0;
    for (int j = 0; j < m; ++j) {
      if (left(i, j) != kNone) longest = std::max(longest, left(i, j));
    }
    delays.line += longest;
  }
  return delays;
}

Delays ChooseDelays(const Responses& responses, int p, int m) {
  Delays inputs = TakeOut(responses, p, m, false);
  Delays outputs = TakeOut(responses, p, m, true);
  return outputs.line < inputs.line ? outputs : inputs;
}

// The step responses and gains that the model is to have, and their sizes. Of
// pairs that integrate: without the ramp that the integrator of the row makes.
struct Wanted {
  ResponsesOfModel responses;
  MatrixXd sizes;   // p × m, of pairs that are not zero > 0
  MatrixXd slopes;  // p × m, of the ramps; 0 where a pair settles
};

// Takes the ramp off the responses `wanted` of pair (i, j), which integrates.
absl::Status TakeOffRamp(const TransferFunction& g, int i, int j, int whole,
                         const Delays& delays, Wanted& wanted) {
  StepResponse& response = wanted.responses.response;
  const int taken = delays.inputs[j] + delays.outputs[i];
  MLE_ASSIGN_OR_RETURN(const IntegratorSplit split,
                       SplitIntegrator(g, response.sample_time, whole - taken));
  const double step = split.slope * response.sample_time;
  auto h = response.element(i, j);
  for (Index k = taken + 1; k < h.size(); ++k) {
    h(k) -= step * static_cast<double>(k - taken);
  }
  if (!split.rest.has_value() &&
      h.cwiseAbs().maxCoeff() <= kNothingLeft * std::abs(step)) {
    h.setZero();
  }
  wanted.slopes(i, j) = split.slope;
  wanted.responses.gains(i, j) = split.rest_gain;
  return absl::OkStatus();
}

absl::StatusOr<Wanted> WantedOf(const ProcessModel& model,
                                const Responses& responses,
                                const Delays& delays, double sample_time) {
  const double samples =
      std::ceil(kSettled * SettlingTime(model) / sample_time) + kFewestSamples;
  Wanted wanted;
  StepResponse& response = wanted.responses.response =
      model.ComputeStepResponse(
          sample_time, static_cast<int>(std::min(samples, kMostSamples)));
  wanted.responses.gains = StaticGains(model);
  wanted.slopes = MatrixXd::Zero(model.num_outputs(), model.num_inputs());
  wanted.sizes = wanted.slopes;
  for (const auto& [i, j] : Pairs(model)) {
    const TransferFunction& g = model.element(i, j);
    if (g.IsIntegrating()) {
      const int whole = responses[i * model.num_inputs() + j]->whole_delay;
      MLE_RETURN_IF_ERROR(TakeOffRamp(g, i, j, whole, delays, wanted));
    }
    double& size = wanted.sizes(i, j);
    size = std::abs(wanted.responses.gains(i, j));
    size = std::max(size, response.element(i, j).cwiseAbs().maxCoeff());
    if (!(size > 0.0)) size = 1.0;
  }
  return wanted;
}

// A row of the model cut after `order` states.
struct BalancedRow {
  RowRealization row;
  std::vector<int> inputs;  // of the columns of row.B
  MatrixXd left;            // n × n, U
  MatrixXd right;           // n × n, V
  VectorXd values;          // σ

  int rank() const;
  // Below it no order can be within `tolerance`: an error of a row is at least
  // the first σ neglected, and that of m elements at most √m times the largest.
  int LeastOrder(double tolerance) const;
  // Inputs are multiplied by `sizes` (1 × m) again.
  DiscreteStateSpace Cut(int order, double sample_time, const MatrixXd& sizes,
                         const Delays& delays, int output) const;
};

int BalancedRow::rank() const {
  const double least =
      kRounding * static_cast<double>(values.size()) * values(0);
  Index rank = 0;
  while (rank < values.size() && values(rank) > least) ++rank;
  return static_cast<int>(rank);
}

int BalancedRow::LeastOrder(double tolerance) const {
  const double least =
      tolerance * std::sqrt(static_cast<double>(inputs.size()));
  Index order = 1;
  while (order < values.size() && values(order) > least) ++order;
  return static_cast<int>(order);
}

DiscreteStateSpace BalancedRow::Cut(int order, double sample_time,
                                    const MatrixXd& sizes, const Delays& delays,
                                    int output) const {
  const VectorXd roots = values.head(order).cwiseSqrt().cwiseInverse();
  const MatrixXd to = roots.asDiagonal() * left.leftCols(order).transpose() *
                      row.observability_factor;
  const MatrixXd from =
      row.controllability_factor * right.leftCols(order) * roots.asDiagonal();
  DiscreteStateSpace system;
  system.sample_time = sample_time;
  system.A = to * row.A * from;
  system.B = MatrixXd::Zero(order, sizes.cols());
  for (std::size_t c = 0; c < inputs.size(); ++c) {
    system.B.col(inputs[c]) =
        sizes(0, inputs[c]) * (to * row.B.col(static_cast<Index>(c)));
  }
  system.C = row.C * from;
  system.D = MatrixXd::Zero(1, sizes.cols());
  system.input_delays = delays.inputs;
  system.output_delays = {delays.outputs[output]};
  return system;
}

// The element of a pair, with the dead time `left` that is not taken out; of an
// integrating element what it has besides its ramp, nothing for an integrator
// alone.
absl::StatusOr<std::optional<RowElement>> ElementOf(
    const ProcessModel& model, const HeldResponse& response, int left,
    double sample_time, int i, int j) {
  const TransferFunction& g = model.element(i, j);
  if (g.IsIntegrating()) {
    MLE_ASSIGN_OR_RETURN(IntegratorSplit split,
                         SplitIntegrator(g, sample_time, left));
    return std::move(split.rest);
  }
  RowElement element = RowElement::Of(response);
  element.delay = left;
  return element;
}

absl::StatusOr<BalancedRow> Balance(const ProcessModel& model,
                                    const Responses& responses,
                                    const Delays& delays, const Wanted& wanted,
                                    int output,
                                    const ReductionOptions& options) {
  BalancedRow balanced;
  std::vector<RowElement> elements;
  double line = 0.0;
  double states = 0.0;
  for (int j = 0; j < model.num_inputs(); ++j) {
    const auto& response = responses[output * model.num_inputs() + j];
    if (!response.has_value()) continue;
    const int left =
        response->whole_delay - delays.inputs[j] - delays.outputs[output];
    MLE_ASSIGN_OR_RETURN(
        std::optional<RowElement> element,
        ElementOf(model, *response, left, wanted.responses.response.sample_time,
                  output, j));
    if (!element.has_value()) continue;
    element->b /= wanted.sizes(0, j);
    line = std::max(line, static_cast<double>(left));
    states += static_cast<double>(element->A.rows());
    elements.push_back(*std::move(element));
    balanced.inputs.push_back(j);
  }
  if (elements.empty()) return balanced;
  if (line + states > options.max_states) {
    return InvalidArgument(
        "state-space model: the dead times of ", model.outputs()[output].name,
        " differ by up to ", line, " samples, which with the orders of its ",
        "elements takes ", line + states, " states, more than ",
        options.max_states, "; a longer sample time takes fewer");
  }
  balanced.row = RowRealization::Of(elements);
  const Eigen::BDCSVD<MatrixXd> svd(
      balanced.row.observability_factor * balanced.row.controllability_factor,
      Eigen::ComputeThinU | Eigen::ComputeThinV);
  balanced.left = svd.matrixU();
  balanced.right = svd.matrixV();
  balanced.values = svd.singularValues();
  return balanced;
}

// The row's responses alone.
Wanted RowOf(const Wanted& wanted, int output) {
  const StepResponse& all = wanted.responses.response;
  Wanted row;
  StepResponse& response = row.responses.response;
  response = StepResponse(all.sample_time, 1, all.num_inputs, all.samples());
  for (int j = 0; j < all.num_inputs; ++j) {
    response.element(0, j) = all.element(output, j);
  }
  row.responses.gains = wanted.responses.gains.row(output);
  row.sizes = wanted.sizes.row(output);
  row.slopes = wanted.slopes.row(output);
  return row;
}

struct CutRow {
  DiscreteStateSpace system;
  double bound = std::numeric_limits<double>::infinity();
  double difference = 0.0;

  bool Within(double tolerance) const {
    return bound <= tolerance && difference <= tolerance;
  }
};

CutRow CutAfter(const BalancedRow& balanced, int order, const Wanted& wanted,
                const Delays& delays, int output, double tolerance) {
  const StepResponse& response = wanted.responses.response;
  CutRow cut;
  cut.system =
      balanced.Cut(order, response.sample_time, wanted.sizes, delays, output);
  const ResponsesOfModel found = {
      cut.system.ComputeStepResponse(response.samples()),
      cut.system.StaticGains()};
  cut.difference = RelativeDifferences(found, wanted.responses)(0);
  // The bound takes longer, and is of no use where this is too large already.
  if (cut.difference <= tolerance) {
    cut.bound = LargestGainsOfDifference(found, wanted.responses)(0);
  }
  return cut;
}

// The row of the smallest order whose bound is within the tolerance; of a row
// without elements, one without states. Orders grow in steps that double until
// one is, then the steps are halved: the bound falls with the order but for
// little.
absl::StatusOr<CutRow> CutWithin(const ProcessModel& model,
                                 const BalancedRow& balanced,
                                 const Wanted& wanted, const Delays& delays,
                                 int output, const ReductionOptions& options) {
  CutRow best;
  if (balanced.inputs.empty()) {
    best.system.B.resize(0, model.num_inputs());
    best.system.C.resize(1, 0);
    best.system.D = MatrixXd::Zero(1, model.num_inputs());
    best.system.sample_time = wanted.responses.response.sample_time;
    best.system.input_delays = delays.inputs;
    best.system.output_delays = {delays.outputs[output]};
    best.bound = 0.0;
    return best;
  }
  const int rank = balanced.rank();
  int below = balanced.LeastOrder(options.tolerance) - 1;  // too small
  int order = std::min(below + 1, rank);
  for (int step = 1;; step *= 2) {
    best = CutAfter(balanced, order, wanted, delays, output, options.tolerance);
    if (best.Within(options.tolerance)) break;
    if (order == rank) {
      return absl::FailedPreconditionError(absl::StrCat(
          "state-space model: rounding leaves none of ",
          model.outputs()[output].name, " within ", options.tolerance,
          " of its step responses",
          std::isfinite(best.difference)
              ? absl::StrCat("; the best has order ", rank,
                             " and step responses within ", best.difference)
              : ""));
    }
    below = order;
    order = std::min(order + step, rank);
  }
  while (order - below > 1) {
    const int middle = (order + below) / 2;
    CutRow cut =
        CutAfter(balanced, middle, wanted, delays, output, options.tolerance);
    if (cut.Within(options.tolerance)) {
      best = std::move(cut);
      order = middle;
    } else {
      below = middle;
    }
  }
  return best;
}

// The state that the integrating pairs of a row share.
void AddIntegrator(const MatrixXd& slopes, double sample_time,
                   DiscreteStateSpace& row) {
  const Index n = row.A.rows();
  row.A.conservativeResizeLike(MatrixXd::Zero(n + 1, n + 1));
  row.A(n, n) = 1.0;
  row.B.conservativeResize(n + 1, slopes.cols());
  row.B.row(n) = sample_time * slopes;
  row.C.conservativeResize(1, n + 1);
  row.C(n) = 1.0;
}

struct ReducedRow {
  CutRow cut;
  VectorXd hankel_values;
  double hankel_bound = 0.0;
};

absl::StatusOr<ReducedRow> ReduceRow(const ProcessModel& model,
                                     const Responses& responses,
                                     const Delays& delays, const Wanted& row,
                                     int output,
                                     const ReductionOptions& options) {
  MLE_ASSIGN_OR_RETURN(const BalancedRow balanced,
                       Balance(model, responses, delays, row, output, options));
  ReducedRow reduced;
  MLE_ASSIGN_OR_RETURN(
      reduced.cut, CutWithin(model, balanced, row, delays, output, options));
  DiscreteStateSpace& system = reduced.cut.system;
  reduced.hankel_values = balanced.values;
  const Index neglected = balanced.values.size() - system.order();
  reduced.hankel_bound = 2.0 * balanced.values.tail(neglected).sum();
  if (!row.slopes.isZero(0.0)) {
    AddIntegrator(row.slopes, system.sample_time, system);
  }
  if (system.order() > 0) MLE_RETURN_IF_ERROR(system.Validate());
  return reduced;
}

// Rows one below the other; the first may be empty.
void Append(const DiscreteStateSpace& row, DiscreteStateSpace& all) {
  const Index n = all.A.rows();
  const Index r = row.A.rows();
  const Index p = all.C.rows();
  all.A.conservativeResizeLike(MatrixXd::Zero(n + r, n + r));
  all.A.bottomRightCorner(r, r) = row.A;
  all.B.conservativeResizeLike(MatrixXd::Zero(n + r, row.B.cols()));
  all.B.bottomRows(r) = row.B;
  all.C.conservativeResizeLike(MatrixXd::Zero(p + 1, n + r));
  all.C.bottomRightCorner(1, r) = row.C;
  all.D.conservativeResizeLike(MatrixXd::Zero(p + 1, row.B.cols()));
  all.D.bottomRows(1) = row.D;
  all.output_delays.push_back(row.output_delays.front());
}

}  // namespace

absl::Status ReductionOptions::Validate() const {
  if (!(tolerance > 0.0) || !std::isfinite(tolerance)) {
    return InvalidArgument("state-space model: tolerance is ", tolerance,
                           ", must be finite and positive");
  }
  if (max_states < 1) {
    return InvalidArgument("state-space model: max_states is ", max_states,
                           ", must be at least 1");
  }
  return absl::OkStatus();
}

absl::StatusOr<ReducedModel> ReduceModel(const ProcessModel& model,
                                         double sample_time,
                                         const ReductionOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_ASSIGN_OR_RETURN(const Responses responses,
                       ResponsesOf(model, sample_time));
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  const Delays delays = ChooseDelays(responses, p, m);
  MLE_ASSIGN_OR_RETURN(const Wanted wanted,
                       WantedOf(model, responses, delays, sample_time));
  ReducedModel reduced;
  reduced.error_bounds = VectorXd::Zero(p);
  reduced.largest_differences = VectorXd::Zero(p);
  reduced.hankel_bounds = VectorXd::Zero(p);
  reduced.system.sample_time = sample_time;
  reduced.system.input_delays = delays.inputs;
  reduced.system.B.resize(0, m);
  std::vector<absl::StatusOr<ReducedRow>> rows(p);
  ParallelFor(p, options.threads, [&](int i) {
    rows[i] = ReduceRow(model, responses, delays, RowOf(wanted, i), i, options);
  });
  for (int i = 0; i < p; ++i) {
    MLE_ASSIGN_OR_RETURN(const ReducedRow row, std::move(rows[i]));
    reduced.hankel_bounds(i) = row.hankel_bound;
    reduced.error_bounds(i) = row.cut.bound;
    reduced.largest_differences(i) = row.cut.difference;
    reduced.orders.push_back(row.cut.system.order());
    reduced.hankel_values.push_back(row.hankel_values);
    Append(row.cut.system, reduced.system);
    if (reduced.system.order() > options.max_states) {
      return absl::FailedPreconditionError(absl::StrCat(
          "state-space model: ", reduced.system.order(),
          " states or more are needed, but at most ", options.max_states,
          " are supported; a longer sample time takes fewer"));
    }
  }
  return reduced;
}

}  // namespace mle
