// The competition of one output (competition.h). Internal to mle/explain.

#ifndef MLE_EXPLAIN_OUTPUT_COMPETITION_H_
#define MLE_EXPLAIN_OUTPUT_COMPETITION_H_

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/explain/competition.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/explanation_fit.h"
#include "mle/explain/instruments.h"
#include "mle/explain/projected_residual.h"

namespace mle {

class OutputCompetition {
 public:
  static absl::StatusOr<std::unique_ptr<OutputCompetition>> Create(
      const ProcessModel& model, const std::vector<Record>& records, int output,
      std::shared_ptr<const FilledInputs> inputs,
      const ExplainOptions& options);
  OutputCompetition(const OutputCompetition&) = delete;
  OutputCompetition& operator=(const OutputCompetition&) = delete;

  const ExplainedOutput& output() const { return output_; }
  const Instruments& instruments() const { return instruments_; }

  // Forward and backward, beside what is given.
  void Compete(const std::vector<Explanation>& given = {});
  const std::vector<TakenExplanation>& taken() const { return taken_; }

  // E of these explanations, and M.
  double Energy(const std::vector<Explanation>& explanations) const;
  // E once they are estimated again.
  double EnergyWith(const std::vector<Explanation>& explanations) const {
    return Estimate(explanations).energy;
  }
  double unit() const { return unit_; }
  // M of a residual of another model.
  double UnitOf(const Eigen::VectorXd& residual) const {
    return ChanceOf(residual, directions_).unit;
  }
  // Covariance of (K, T, L) of an element, from that of θ.
  Eigen::Matrix3d Covariance(int input) const;
  std::vector<Explanation> Explanations() const;
  // All elements were fitted at once.
  bool together() const { return together_; }

  // These explanations with another shape of one of them, a curve, all
  // estimated again; an infinite energy where there is none.
  ExplanationFit WithShapeOf(const std::vector<Explanation>& explanations,
                             const Explanation& curve, int part) const;
  // They in place of what was taken.
  void TakeShape(const ExplanationFit& fit, const Explanation& curve,
                 const std::vector<Explanation>& alternatives);

  // Standard errors, what is left, hold-out validation, ties.
  OutputExplanation Report() const;

 private:
  using Fit = ExplanationFit;
  // Energies that chance gives the residual of a fit, by the placebos.
  struct Chance {
    double energy = 0.0;  // N
    double unit = 0.0;    // M
  };

  OutputCompetition(ExplainedOutput output, Instruments instruments,
                    const ExplainOptions& options)
      : output_(std::move(output)),
        instruments_(std::move(instruments)),
        options_(options),
        projected_(output_, [this](const Eigen::VectorXd& e) {
          return instruments_.Project(e);
        }) {}

  Eigen::MatrixXd Jacobian(const std::vector<Explanation>& explanations) const;
  Fit Estimate(std::vector<Explanation> explanations) const;
  // The best of each explanation beside `taken`, best first; the directions
  // tried go to `directions` (r × …).
  std::vector<Fit> Candidates(const std::vector<Explanation>& taken,
                              double chance, Eigen::MatrixXd& directions) const;
  // −ln of the probability that chance lowers E by `fall`.
  double EvidenceOf(double fall, double unit) const;
  Chance ChanceOf(const Fit& fit, const Eigen::MatrixXd& directions) const;
  Chance ChanceOf(const Eigen::VectorXd& residual,
                  const Eigen::MatrixXd& directions) const;
  // Inputs stand for set points, and answer nothing.
  bool OpenLoop() const;
  // The evidence that is asked for of an explanation.
  double EvidenceFor(const Explanation& explanation) const;
  // Of one hypothesis, which is not the best of a table.
  double EvidenceOfOne() const;
  // The fall of E that has the evidence asked for, in M.
  double Required() const;
  // The best explanation more, and M of what it leaves; nothing where there is
  // none to try. `directions_` are those tried.
  struct Next {
    Fit fit;
    double unit = 0.0;
  };
  std::optional<Next> BestNext(const std::vector<Explanation>& taken);
  // The last explanation, if it is a curve, in the shape that leaves the least;
  // M of it.
  Fit InBestShape(const Fit& fit, double unit) const;
  void Forward(const std::vector<Explanation>& given);
  void Backward(std::size_t given);
  // Another explanation in place of one that was taken, where it does better;
  // whether there was one.
  bool Exchange(std::size_t given);
  // All elements at once, where much is left (several_steps.h).
  void FitTogether();
  void FindTies();
  // Errors of what was taken, where blocks are held out.
  void HoldOut();
  void TakeForClock();
  // Cost of an improbability of one: N, for instruments that are not in parts.
  double CostOf(double chance) const { return chance / instruments_.parts(); }
  double Score(const std::vector<Explanation>& explanations, double energy,
               double chance) const;
  Eigen::MatrixXd CovarianceOfTheta() const;
  Eigen::VectorXd KeptByPlacebos(const std::vector<Explanation>& explanations,
                                 const Eigen::MatrixXd& A) const;

  ExplainedOutput output_;
  Instruments instruments_;
  ExplainOptions options_;
  ProjectedResidual projected_;  // Qᵀe
  std::optional<double> feedback_p_value_;
  std::vector<TakenExplanation> taken_;
  std::vector<TakenExplanation> next_;
  std::vector<OutputExplanation::Tie> ties_;
  Eigen::MatrixXd directions_;
  std::vector<HorizonErrors> held_out_;  // of what was taken
  // What was taken is that fit, with its Cov θ̂.
  bool together_ = false;
  Eigen::MatrixXd covariance_together_;
  double independent_ = 1.0;  // n, of the placebos
  double rounding_ = 0.0;     // an energy below is none
  double initial_energy_ = 0.0;
  double energy_ = 0.0;
  double chance_ = 0.0;
  double unit_ = 0.0;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_OUTPUT_COMPETITION_H_
