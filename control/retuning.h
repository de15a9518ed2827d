// Tuning of a controller after its model was corrected, compared with the old
// tuning.
//
// From a first-order description (K, T, L) of each pair of output i and input
// j, the rules of Shridhar and Cooper for dynamic matrix control (Ind. Eng.
// Chem. Res. 36, 1997, 729–746 for one loop; 37, 1998, 4003–4016 for several):
//
//   control period   Δt_c = min_ij max(0.1 T_ij, 0.5 L_ij)
//   dead time        k_ij = L_ij/Δt_c + 1, and 1 more, because a move decided
//                    here acts one period later
//   prediction       H_p = ⌈max_ij (5 T_ij/Δt_c + k_ij)⌉, until all has settled
//   control          H_c = ⌈max_ij (T_ij/Δt_c + k_ij)⌉, until 63 % of it
//   move weights     Q_u,jj = H_c/c Σ_i Q_y,ii K_ij² (H_p − k_ij + 2
//                             − 1.5 T_ij/Δt_c − (H_c − 1)/2), terms ≥ 0
//
// where c is the condition number that the control problem is to have; the sum
// approximates the trace of the problem's Hessian for input j. A control
// horizon of one move needs no weight for that, but is never advised here.
// These are rules for pairs that settle. Of those that end in a ramp (levels,
// first_order.h) H_p is 10 (T_ij + L_ij)/Δt_c + k_ij, about what a loop on the
// level takes, and their term in the sum is the same mean of the Hessian's
// diagonal over the moves,
//
//   K_ij² Δt_c² (s(H_p) + 1/H_c Σ_{b<H_c} s(H_p + 1 − b − k_ij − T_ij/Δt_c)),
//   s(N) = N (N + 1)(2N + 1)/6,  k_ij = L_ij/Δt_c + 2,
//
// whose s(H_p) is the weight of the slope at the end (move_planner.h).
//
// The loop is then analysed (loop_analysis.h) with the model corrected as the
// plant: under the running controller, under the corrected model with the old
// tuning, and with the new one. Where the new tuning is not stable with a
// sensitivity peak up to 2, its move weights are doubled until it is.
//
//   MLE_ASSIGN_OR_RETURN(const RetuningAdvice advice,
//                        AdviseRetuning(old_model, old_options, corrected,
//                        {}));
//   for (const std::string& line : advice.reasons) std::cout << line << "\n";

#ifndef CONTROL_RETUNING_H_
#define CONTROL_RETUNING_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "control/first_order.h"
#include "control/loop_analysis.h"
#include "control/mpc_options.h"
#include "control/prediction_model.h"
#include "mle/model/step_response.h"

namespace mle::control {

struct RetuningOptions {
  // Keeps the control period of the old tuning, as a model exchange in a
  // running loop needs; the period of the rule is still named.
  bool keep_control_period = false;
  // c > 1. 500 is the value of the single-loop paper.
  double condition_number = 500.0;
  // The controller's load: H_c is at most this, ≥ 1.
  int longest_control_horizon = 30;
  // The largest sensitivity peak, > 1. (Skogestad and Postlethwaite, 2005, sec.
  // 2.4.3.)
  double largest_sensitivity_peak = 2.0;
  // Loops are analysed side by side; 0: one thread for each processor.
  int threads = 1;
  // How times are spelled in the reasons, such as "min".
  std::string time_unit = {};
  // How channels are; empty: "output 1" and "input 1".
  std::vector<std::string> output_names = {};
  std::vector<std::string> input_names = {};

  absl::Status Validate() const;
};

struct RetuningAdvice {
  // The old options with the new period, horizons and move weights. Blocks of
  // moves, if there were any, are gone; limits and observer are kept.
  MpcOptions tuning;
  std::vector<FirstOrder> elements;  // row by row (p·m)
  // The corrected model as the plant: under the old model and tuning, …
  LoopAnalysis running;
  // … under the corrected model with the old tuning, …
  LoopAnalysis exchanged;
  // … and with the new one.
  LoopAnalysis retuned;
  // Each decision with its reason, a line each.
  std::vector<std::string> reasons;
};

// `corrected` holds the step responses of the corrected model, until they have
// settled or are ramps; the control period is made a whole multiple of their
// sample time.
//
// InvalidArgument for options or models that are not valid or do not fit each
// other, FailedPrecondition for a response that has not settled, or if no move
// weight makes the loop stable.
absl::StatusOr<RetuningAdvice> AdviseRetuning(const PredictionModel& old_model,
                                              const MpcOptions& old_tuning,
                                              const StepResponse& corrected,
                                              const RetuningOptions& options);

// The rules alone: period (a multiple of `sample_time`, if that is > 0),
// horizons and move weights for the manipulated inputs among `roles`, the rest
// as in `old_tuning`; reasons are appended.
absl::StatusOr<MpcOptions> TuneByRules(const std::vector<FirstOrder>& elements,
                                       const std::vector<InputRole>& roles,
                                       double sample_time,
                                       const MpcOptions& old_tuning,
                                       const RetuningOptions& options,
                                       std::vector<std::string>& reasons);

}  // namespace mle::control

#endif  // CONTROL_RETUNING_H_
