// Explanations of an output compete for the part of its residual that set
// points drive.
//
//   E(θ) = |Qᵀ e(θ)|²              what instruments drive (instruments.h)
//   N    = median over s of |Q_sᵀ e|²    what chance makes of it
//   M    = mean over s of the largest (d_xᵀ Q_sᵀ e)², d_x the direction in
//          which explanation x of the table moves Qᵀe: what the table
//          explains of chance
//
// Forward: of all explanations that are not taken the one is tried that lowers
// E + (improbability) N most, all taken ones estimated again beside it; it is
// taken where
//
//   evidence = n ln(1 + (E before − E after) / (n M)),
//
// e of M and N that of `after`, is above the one asked for, and what is
// improbable of the size of a change (PriorCost()) more. n is the number of
// independent placebos, one in 3 τ of the record: where what the table explains
// of chance has an exponential distribution and M is the mean of n such, the
// probability of this much by chance is (1 + R/n)⁻ⁿ = exp(−evidence). Backward:
// what no longer pays beside the others leaves. Then
//
//   E / N of what is left: above about 2 an explanation is missing;
//   Cov θ̂ = A C Aᵀ, A = (JᵀJ)⁻¹Jᵀ, J = ∂Qᵀe/∂θ, C the covariance of Q_sᵀe.
//
// Explanations of an input are tried for all its outputs together
// (CompeteTogether). Hold-out validation: blocks of 3 τ in turn have no part in
// θ, and the changes of e over h = τ/5, τ and 3 τ, and e itself, are compared
// there with those of the model as it was.

#ifndef MLE_EXPLAIN_COMPETITION_H_
#define MLE_EXPLAIN_COMPETITION_H_

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/explain/curves.h"
#include "mle/explain/explanation.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"

namespace mle {

struct ExplainOptions {
  // −ln of the probability of taking an explanation by chance, > 0: e⁻⁸ is
  // 0.03 %. Where inputs stand for set points, twice as much.
  double evidence = 8.0;
  // Explanations of an output at most, ≥ 1.
  int most = 6;
  // p × m: the elements that another estimate has changed, or empty. Where
  // inputs stand for set points, and answer nothing, these are hypotheses by
  // themselves, not the best of a table, and need e⁻³ (5 %).
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> expected = {};
  // p: the times that samples of the outputs are known to be means over, in the
  // middle of which they stand; or empty.
  std::vector<double> averages = {};
  // p: the standard deviations of random errors of the stamps, or empty.
  std::vector<double> stamp_errors = {};
  // 0: one for each processor. The result does not depend on it.
  int threads = 1;

  absl::Status Validate() const;
};

struct TakenExplanation {
  Explanation explanation;
  double standard_error = 0.0;  // of θ
  double evidence = 0.0;        // when it was taken
  // Of a curve: those of other shapes that explain as much, within 3 M.
  std::vector<Explanation> alternatives = {};
};

// Errors of the model as it was and as it is explained where records were held
// out, by horizon; negative relative changes are gains.
struct HorizonErrors {
  double horizon = 0.0;  // in the model's time unit; 0: free simulation
  double initial = 0.0;  // root mean square
  double explained = 0.0;
  // The relative difference of the squares in its standard errors over blocks;
  // > 0: the explained model is nearer.
  double deviations = 0.0;
};

// Changes of other elements, and whatever explains as much as a curve or a
// change during the records, are rivals if nearer than this many M.
inline constexpr double kRivalMargin = 5.0;

// E/N: where more is left, something may explain it.
inline constexpr double kMuchLeft = 1.5;

// Outputs drive inputs where the p-value of that test (feedback.h) is below
// this level.
inline constexpr double kFeedback = 0.01;

// The explanations of one output, and the evidence for them.
struct OutputExplanation {
  // Why there is no judge: nothing moves, nothing is measured; or empty.
  std::string unjudged;
  bool by_set_points = false;
  // Where inputs stand for set points: of the test that none of them answers
  // the output (feedback.h); nothing where it cannot be tested.
  std::optional<double> feedback_p_value;
  int moves = 0;
  std::vector<TakenExplanation> taken;
  // They were estimated all at once, by errors several steps ahead
  // (several_steps.h), having more evidence than what won one by one.
  bool together = false;
  // The last explanation that was tried and not taken.
  std::optional<TakenExplanation> next;
  // An explanation in place of one that was taken that explains nearly as much,
  // all others estimated again beside it, improbabilities included: changes of
  // two elements within 5 M, others within a tenth of N, curves that explain
  // half an M more, their improbability aside. Of a change during the records,
  // and of a curve, any other within 5 M.
  struct Tie {
    Explanation taken;
    Explanation rival;
    double margin = 0.0;  // of what was taken, in M
  };
  std::vector<Tie> ties;
  double energy = 0.0;       // E of the model as it was
  double remaining = 0.0;    // E of what is explained
  double chance = 0.0;       // N
  double averaging = 0.0;    // E of what known averages do to the output
  double stamps = 0.0;       // E of random errors of stamps, on average
  double unit = 0.0;         // M
  double independent = 1.0;  // n
  double required = 0.0;     // the fall of E that is evidence enough, in M
  std::vector<HorizonErrors> held_out;
  // m: a change of the gain that would have been taken, as a share; infinite
  // where no instrument moves the input.
  std::vector<double> detectable;

  bool judged() const { return unjudged.empty(); }
  // Inputs stand for set points and answer the output, or do not.
  bool answered() const {
    return feedback_p_value.has_value() && *feedback_p_value < kFeedback;
  }
  bool open_loop() const {
    return feedback_p_value.has_value() && *feedback_p_value >= kFeedback;
  }
  // The evidence of a fall of E, by `unit` or another M.
  double EvidenceOf(double fall) const { return EvidenceOf(fall, unit); }
  double EvidenceOf(double fall, double by_unit) const;
  // Whether another explanation does as well as one that was taken.
  bool HasTie(const Explanation& explanation) const;
  // E/N, with what known averages and errors of stamps do in N; an explanation
  // may be missing above kMuchLeft.
  double left() const {
    return chance > 0.0 ? remaining / (chance + averaging + stamps) : 0.0;
  }
  double before() const { return chance > 0.0 ? energy / chance : 0.0; }
};

class OutputCompetition;

// The competition of all outputs, which can be asked about other models of the
// same row.
class Competition {
 public:
  // InvalidArgument for options; outputs without a judge say why.
  static absl::StatusOr<Competition> Run(const ProcessModel& model,
                                         std::vector<Record> records,
                                         const ExplainOptions& options);
  Competition(Competition&&) noexcept;
  Competition& operator=(Competition&&) noexcept;
  ~Competition();

  const std::vector<OutputExplanation>& outputs() const { return results_; }
  // K, T and L of an element with what is explained of them, at the end of the
  // records.
  ElementValues Explained(int output, int input) const;
  // The element with these values, in the shape that is explained. Fails where
  // it has none.
  absl::StatusOr<TransferFunction> ElementOf(int output, int input,
                                             const ElementValues& values) const;
  // By which a clock makes its dead time longer, in the model's time unit.
  double ClockOf(int output, int input) const;
  // Covariance (3 × 3) of K, T and L, clocks included.
  Eigen::Matrix3d Covariance(int output, int input) const;
  // The curves that won, one of each channel: of an input the mean of its
  // outputs', by their precision, with the evidence of all of them; none of an
  // input if another output's E grows by more than 3 M with it.
  std::vector<FoundCurve> Curves() const;
  // E of another model's row, and of its difference from the model as it was:
  // what the other would show of itself. The energy of the output, and 0, where
  // it cannot be simulated.
  struct Energies {
    double remaining = 0.0;
    double difference = 0.0;
    double unit = 0.0;  // M of what the other leaves
  };
  Energies EnergiesOf(int output, const ProcessModel& model) const;
  // E with these explanations, estimated again.
  double EnergyWith(int output,
                    const std::vector<Explanation>& explanations) const;

 private:
  Competition() = default;
  bool IsContradicted(const FoundCurve& curve) const;
  double evidence_ = 0.0;  // asked for
  // Of all competitions, wherever this one is moved to.
  std::unique_ptr<const std::vector<Record>> records_;
  std::vector<std::unique_ptr<OutputCompetition>> competitions_;
  std::vector<OutputExplanation> results_;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_COMPETITION_H_
