// The shape of a plan, and what it is worth: the least size that brings what is
// wanted, and what that costs. Internal to mle/plan; the equations are in
// plan.h.
//
// The loop's answer to a unit step of each set point is known; those to a shape
// are sums of them, on a grid of times that is coarse beside the samples: what
// whitened sensitivities tell is counted once for each of the samples between.

#ifndef MLE_PLAN_PLAN_SHAPE_H_
#define MLE_PLAN_PLAN_SHAPE_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/plan/plan.h"
#include "mle/plan/plan_row.h"
#include "mle/plan/plan_variance.h"

namespace mle {

// Set points (p × S, in units of PlanGrid::scale) held for `holds` (S, in steps
// of the grid) one after the other, all of them `repeats` times, then back.
struct PlanShape {
  Eigen::MatrixXd levels;
  std::vector<int> holds;
  int repeats = 1;

  int duration() const;
  // The same without repeats, without levels of zero at either end, and with
  // equal ones as one.
  PlanShape Unrolled() const;
};

struct PlanGrid {
  int samples = 1;        // of a step
  double step = 0.0;      // in the model's time unit
  int settling = 1;       // of the model, in steps
  int lead = 0;           // used before the first move
  int tail = 0;           // and after the last
  int longest = 0;        // of a shape
  Eigen::VectorXd scale;  // p, a unit of each set point

  int length() const { return longest + tail; }
};

PlanGrid MakePlanGrid(const PlanProblem& problem, const PlanOptions& options);

// The set points (p × N) of a shape of this size, a column for each sample,
// with what follows it.
Eigen::MatrixXd SetPointsOf(const PlanShape& shape, double size,
                            const PlanGrid& grid);

// A question with what is known before the plan.
struct OpenQuestion {
  PlanQuestion question;
  Eigen::Index place = 0;       // of its row's parameters
  Eigen::MatrixXd information;  // I₀
};

struct ShapeValue {
  // To be minimised: ln of the cost, with a small price on moves and time;
  // beyond 1,000 where what is wanted is out of reach, then ln of what is
  // missing.
  double objective = 0.0;
  double size = 0.0;  // of the levels; the largest allowed if out of reach
  double cost = 0.0;
  bool reaches = false;
  int channel = -1;  // that limits the size: outputs, inputs, set points
  bool upper = true;
};

// E|m + σ z| − E|σ z|, z standard normal, σ = `deviation` ≥ 0.
double MoreAbsolute(double m, double deviation);

class ShapeEvaluator {
 public:
  // Simulates the steps. `plants` are those over which squared errors are
  // averaged, the first as it is expected to be; `questions` are of one row or
  // several.
  static absl::StatusOr<ShapeEvaluator> Create(
      const PlanProblem& problem, const PlanOptions& options,
      const PlanGrid& grid, const std::vector<ProcessModel>& plants,
      std::vector<OpenQuestion> questions);

  // With this plant, too, the limits are to be kept.
  absl::Status KeepLimitsOf(const PlanProblem& problem,
                            const ProcessModel& plant,
                            const PlanOptions& options);

  // A factor of the least sizes, for what the grid does not tell.
  void SetDemand(double demand) { demand_ = demand; }
  double demand() const { return demand_; }

  ShapeValue Evaluate(const PlanShape& shape) const;
  // What `outputs` (p × n steps) cost.
  double CostOf(const Eigen::Ref<const Eigen::MatrixXd>& outputs) const;
  const PlanGrid& grid() const { return grid_; }

 private:
  // A row of parameters in question: where its sensitivities are.
  struct Part {
    int output = 0;
    Eigen::Index first = 0;
    Eigen::Index count = 0;
    Eigen::RowVectorXd offset;  // whitened, from the lead on
  };
  struct Asked {
    OpenQuestion open;
    std::size_t part = 0;
    Eigen::MatrixXd root;  // I₀ and next to nothing = L Lᵀ
  };

  ShapeEvaluator() = default;
  void SetPricesAndRoom(const PlanProblem& problem, const PlanOptions& options);
  void AddOffsets(const PlanProblem& problem);
  // Answers to a unit step of each set point; empty of one that does not move.
  using Steps = std::vector<Eigen::MatrixXd>;
  // With the sensitivities of these rows.
  absl::StatusOr<Steps> StepsOf(const PlanProblem& problem,
                                const ProcessModel& plant,
                                const std::vector<PlanRow>& rows,
                                const PlanOptions& options) const;
  Eigen::MatrixXd Answer(const PlanShape& unrolled, const Steps& steps) const;
  // Of each part with each plant, one plant after the other.
  std::vector<Eigen::MatrixXd> Informations(
      const PlanShape& unrolled, const Eigen::MatrixXd& expected) const;
  struct Reach {
    std::vector<Variances> variances;  // of each question
    double least_size = 0.0;           // for all of them
  };
  Reach ReachOf(const std::vector<Eigen::MatrixXd>& informations) const;
  // The largest error over that wanted.
  double Shortfall(const Reach& reach, double size) const;
  // The most and the least of each output, input and set point (2p + m).
  struct Extremes {
    Eigen::VectorXd high;
    Eigen::VectorXd low;
  };
  Extremes ExtremesOf(const PlanShape& unrolled,
                      const Eigen::MatrixXd& expected) const;
  // The largest size with this sign, into `value` where it is larger.
  void Limit(const Extremes& extremes, double sign, ShapeValue& value) const;

  PlanGrid grid_;
  double demand_ = 1.0;
  int p_ = 0;
  int m_ = 0;
  std::vector<Part> parts_;
  std::vector<Asked> asked_;
  // Of each plant: p + m + Σ n rows, deviations of outputs and inputs and
  // whitened sensitivities.
  std::vector<Steps> steps_;
  std::vector<Steps> limiting_;  // p + m rows, of further plants
  Eigen::VectorXd squared_price_;
  Eigen::VectorXd absolute_price_;
  Eigen::VectorXd deviations_;  // p, σ
  // 2p + m: how far outputs, inputs and set points may go.
  Eigen::VectorXd room_up_;
  Eigen::VectorXd room_down_;
};

}  // namespace mle

#endif  // MLE_PLAN_PLAN_SHAPE_H_
