// A step-response (FIR) model, as model predictive controllers keep them: for
// each pair the response of the output to a unit step of the input at t = 0,
//
//   c_k = h(kΔ),  k = 1 … N,
//
// at the interval Δ of the coefficients; NΔ is the time to steady state. After
// it the response stays at c_N, or, of an integrating pair, goes on with the
// slope of the last interval: a ramp.
//
// The forms of files are in docs/formats.md (step-response models):
//
//   MLE_ASSIGN_OR_RETURN(const StepResponseModel model,
//                        ReadStepResponseModel("column.csv"));
//   model.pairs[0].coefficients(59);   // c_60

#ifndef MLE_EXCHANGE_STEP_RESPONSE_MODEL_H_
#define MLE_EXCHANGE_STEP_RESPONSE_MODEL_H_

#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle {

inline constexpr int kFewestCoefficients = 10;
// Times in a file may be off by this share of Δ, as they are rounded.
inline constexpr double kTimeTolerance = 0.01;

struct PairResponse {
  int output = 0;
  int input = 0;
  Eigen::VectorXd coefficients;  // N: c_1 … c_N
  bool is_ramp = false;          // how the pair goes on after c_N
};

struct StepResponseModel {
  // Name, unit of time, inputs and outputs; all elements zero.
  ProcessModel channels;
  double interval = 0.0;  // Δ > 0, in the unit of time
  // In the order of the file. An input does not reach an output whose pair is
  // not there.
  std::vector<PairResponse> pairs;

  int length() const {  // N
    return pairs.empty() ? 0
                         : static_cast<int>(pairs.front().coefficients.size());
  }
  double time_to_steady_state() const { return interval * length(); }

  // Valid channels, Δ > 0, at least one pair, each once, and of each N ≥
  // kFewestCoefficients finite coefficients.
  absl::Status Validate() const;
  // That NΔ is the time that a file states: "is 30, but 12 coefficients …".
  absl::Status CheckSteadyState(double stated) const;
};

// `model` with c_k + ψ_k − φ_k in place of c_k: φ are the step responses of
// what describes it, ψ the same after a correction, at 0, Δ, … NΔ. Pairs whose
// φ and ψ are the same keep every bit; a pair that is not there and responds in
// ψ is appended.
StepResponseModel WithChange(const StepResponseModel& model,
                             const StepResponse& before,
                             const StepResponse& after);

// CSV or JSON, told apart by whether the text begins with a brace. Errors name
// `source`, the line or key, what was found and what would be right.
absl::StatusOr<StepResponseModel> ParseStepResponseModel(
    std::string_view text, std::string_view source);
absl::StatusOr<StepResponseModel> ReadStepResponseModel(
    const std::string& path);

// Both read back as the same numbers, bit by bit. The model is valid.
std::string FormatStepResponseCsv(const StepResponseModel& model);
std::string FormatStepResponseJson(const StepResponseModel& model);

}  // namespace mle

#endif  // MLE_EXCHANGE_STEP_RESPONSE_MODEL_H_
