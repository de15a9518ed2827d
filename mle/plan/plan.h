// The least costly change of set points after which stated gains of a model are
// known as well as is wanted.
//
// A plan moves the set points from where they stand, by r(t), and back, in a
// few steps; the loop answers with the expected deviations y(t) of the outputs
// and u(t) of the inputs. Of output i, whose noise is whitened by its
// stationary filter (mle/filter/disturbance_system.h), the plan adds to what
// is known of the parameters θ of its row (relative changes of gain and time
// constant, dead time in units of s = max(L, T/5, 3 Δt))
//
//   I = I₀ + Σ_k J_k J_kᵀ,   J_k = ∂(Σ_j g_ij u_j)_k/∂θ, whitened,
//
// without what an unknown offset explains; I₀ is the information of the
// records. A standard error is the root of a diagonal entry of I⁻¹: all other
// parameters of the row are free, as they are in the estimate
// (mle/nonlinear/output_error_correction.h). Its cost are the deviations,
//
//   c = Σ_i ∫ p_i y_i² dt + Σ_i ∫ q_i (E|y_i + σ_i z| − E|σ_i z|) dt,
//
// z being standard normal and σ_i the deviation in usual operation; without
// prices p_i = 1/σ_i². Without limits of inputs in the controller the loop is
// linear: J grows with the size of r, so that each shape of r has a least size
// that reaches what is wanted, in closed form but for a root, and a cost. The
// cheapest shape within the limits is searched for: steps, pulses, doublets and
// staircases of single set points and of such combinations as move one input
// alone, several in turn, refined by changes of sizes and times one by one.
//
// The limits must hold for every plant of `draws` that are drawn from what the
// records leave open, with the prior of ageing, and on top of them `deviations`
// times the deviations of usual operation. Plants that the loop would not hold
// at all are left out: it runs. Errors are root mean squares over the expected
// plant and four of those drawn, since inputs that must not move together in
// the one may do so in another. At last the loop itself is simulated, and the
// errors are those of the estimate's own information bound
// (ComputeOutputErrorLimit()) of the records and the plan.
//
// Source: Bombois, Scorletti, Gevers, Van den Hof and Hildebrand, Least costly
// identification experiment for control, Automatica 42 (2006) 1651–1662.
//
//   PlanProblem problem = {.plant = model, .sample_time = 1.0, …};
//   problem.questions = {{.output = 0, .input = 1, .error = 0.1}};
//   MLE_ASSIGN_OR_RETURN(const Plan plan, FindPlan(problem, options));
//   if (plan.state == Plan::State::kFound) show(plan.steps);

#ifndef MLE_PLAN_PLAN_H_
#define MLE_PLAN_PLAN_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// A gain, and how well it is to be known.
struct PlanQuestion {
  int output = 0;
  int input = 0;  // not a disturbance
  // Standard error in (0, 1], as a share of the gain.
  double error = 0.1;
  // By the plan's record alone: the others are in doubt.
  bool alone = false;
};

// The loop: the record of `plant` (deviations, without noise, sampled alike)
// while the set points (p × N) deviate from where they stand, at rest at first.
// Called from several threads. FailedPrecondition: the loop does not hold it.
using PlannedLoop = std::function<absl::StatusOr<Record>(
    const ProcessModel& plant, const Eigen::MatrixXd& set_points)>;

// Whether a record that begins at rest is at rest again at its end: less than a
// fiftieth of each output's largest deviation is left, where the set points
// are back. For loops, of which others do not hold their plant.
bool ComesToRest(const Record& record);

struct PlanProblem {
  ProcessModel plant;  // as it is expected to be; no element integrates
  double sample_time = 0.0;
  std::vector<PlanQuestion> questions;
  // p: of each output, a sample (mle/filter, or the estimate's).
  std::vector<NoiseEstimate> noise;
  std::vector<Record> windows;  // records that the estimate will use, or none
  PlannedLoop loop;
  // p, m: where set points and inputs stand, and standard deviations of outputs
  // and inputs in usual operation, ≥ 0.
  Eigen::VectorXd set_points;
  Eigen::VectorXd inputs;
  Eigen::VectorXd output_deviations;
  Eigen::VectorXd input_deviations;
};

struct PlanOptions {
  // Limits in the units of the channels: p or m values, infinite where there is
  // none, or no values at all.
  Eigen::VectorXd min_output;
  Eigen::VectorXd max_output;
  Eigen::VectorXd min_input;
  Eigen::VectorXd max_input;
  // p: set points that may move; empty: all.
  std::vector<bool> movable;
  // From the first move to the last, > 0 in the model's time unit.
  double longest = 0.0;
  // Quiet time between moves, ≥ 0: a value of the set points is held so long at
  // least. 0: a twentieth of the model's settling time.
  double shortest_hold = 0.0;
  // Moves are at whole multiples of this, ≥ 0, as of a control period; 0: the
  // sample time.
  double grid = 0.0;
  // Values held, one after the other, from 1 to 12.
  int most_steps = 6;
  // p, ≥ 0: p_i, of a squared unit for a unit of time, and q_i, of a unit.
  // Both empty: 1/σ_i² and none.
  Eigen::VectorXd squared_price;
  Eigen::VectorXd absolute_price;
  // Standard deviation > 0 of what ageing does to a parameter (in the same
  // units as errors), for the plants that are drawn.
  double ageing = 0.25;
  int draws = 300;          // ≥ 10
  double deviations = 5.0;  // kept from limits, ≥ 0
  std::uint64_t seed = 1;
  int threads = 0;  // 0: one for each processor

  absl::Status Validate(const ProcessModel& plant) const;
};

// From `time` on, counted from the first move, the set points (p) are these.
struct PlanStep {
  double time = 0.0;
  Eigen::VectorXd set_points;
};

struct PlanAnswer {
  PlanQuestion question;
  double before = 0.0;  // standard error; infinite where nothing is known
  double after = 0.0;   // with the plan
};

struct Plan {
  enum class State {
    kNothingNeeded,  // all is known as well as is wanted
    kFound,
    kOutOfReach,  // the plan that brings most, and what hinders
  };
  State state = State::kNothingNeeded;
  std::vector<PlanStep> steps;  // the last is back where the set points stood
  double duration = 0.0;        // until that
  double cost = 0.0;
  std::vector<PlanAnswer> answers;  // of each question
  std::string hindrance;            // "the upper limit of reflux"
  // As expected: absolute values with the set points, from time 0, the first
  // move, until all has settled.
  Record expected;
  // Around it, p × N and m × N: the extremes of all plants drawn, widened by
  // `deviations` of usual operation.
  Eigen::MatrixXd low_outputs;
  Eigen::MatrixXd high_outputs;
  Eigen::MatrixXd low_inputs;
  Eigen::MatrixXd high_inputs;
  int left_out = 0;  // plants of those drawn: the loop would not hold them
};

// InvalidArgument for options and problems that are wrong, and for limits that
// usual operation does not meet: the message names field, value and what would
// be right. Errors of the loop with the expected plant are errors.
absl::StatusOr<Plan> FindPlan(const PlanProblem& problem,
                              const PlanOptions& options);

// Plants (`draws` of them) from what `windows` leave open, with the prior of
// ageing; elements keep their shapes.
absl::StatusOr<std::vector<ProcessModel>> DrawPlants(
    const PlanProblem& problem, const PlanOptions& options);

}  // namespace mle

#endif  // MLE_PLAN_PLAN_H_
