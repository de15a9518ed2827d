// One output of a plan: the parameters of its elements, what records say of
// them, and how the output moves with each of them. Internal to mle/plan; the
// equations are in plan.h.

#ifndef MLE_PLAN_PLAN_ROW_H_
#define MLE_PLAN_PLAN_ROW_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/filter/disturbance_system.h"
#include "mle/model/element_response.h"
#include "mle/model/process_model.h"
#include "mle/plan/plan.h"

namespace mle {

class PlanRow {
 public:
  // InvalidArgument for elements with feedthrough.
  static absl::StatusOr<PlanRow> Create(const ProcessModel& plant, int output,
                                        double sample_time);

  int output() const { return output_; }
  // n: three for each element present.
  Eigen::Index num_parameters() const { return 3 * std::ssize(elements_); }
  // Of the gain among the parameters; −1 where the element is absent.
  Eigen::Index PlaceOfGain(int input) const;
  // n × N: ∂(output)/∂θ under these inputs (m × N), which are deviations.
  Eigen::MatrixXd Sensitivities(const Eigen::MatrixXd& inputs) const;
  // n × n, from the covariance (3m × 3m) of the gains, time constants and dead
  // times; what it does not determine has none.
  Eigen::MatrixXd InformationOf(const Eigen::MatrixXd& covariance) const;
  // Sets the elements of the row as changed by θ (n), dead times within
  // [0, ∞), gains and time constants by their logarithms.
  void Change(const Eigen::VectorXd& change, ProcessModel& plant) const;

 private:
  struct Element {
    int input = 0;
    ElementResponse response;
    Eigen::Vector3d units;  // |K|, T, s
  };

  int output_ = 0;
  double sample_time_ = 0.0;
  std::vector<Element> elements_;
};

// Of all outputs, in their order.
absl::StatusOr<std::vector<PlanRow>> RowsOf(const ProcessModel& plant,
                                            double sample_time);

// The rows of `series` (n × N) through the stationary filter of the noise, in
// units of its innovations' deviation.
void WhitenRows(const NoiseEstimate& noise, Eigen::MatrixXd& series);

// I₀ of each output (p); zero without windows.
absl::StatusOr<std::vector<Eigen::MatrixXd>> InformationOfWindows(
    const PlanProblem& problem, const std::vector<Record>& windows,
    const std::vector<PlanRow>& rows, int threads);

// The standard error of parameter `place` by this information, infinite where
// it does not determine it.
double ErrorBy(const Eigen::MatrixXd& information, Eigen::Index place);

// Standard errors of the questions with a plan whose record of `plant` is
// `plan` (deviations, from rest), beside what is known, I₀ of each output (p),
// which a question that asks for the plan alone leaves out.
absl::StatusOr<std::vector<double>> ErrorsAfter(
    const PlanProblem& problem, const ProcessModel& plant, const Record& plan,
    const std::vector<Eigen::MatrixXd>& known, int threads);

}  // namespace mle

#endif  // MLE_PLAN_PLAN_ROW_H_
