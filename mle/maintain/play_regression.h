// How well the outputs of records are explained if each input acts on the plant
// through a play (backlash) of some width b ≥ 0, as a worn linkage or a
// sticking valve makes it:
//
//   v_k = min(max(v_{k−1}, u_k − b/2), u_k + b/2),   v_0 = u_0,
//
// the valve v follows the demand u that is recorded, b/2 behind it, and stands
// still where the demand turns back by less than b. Of each output
//
//   y = Σ_j Σ_c a_jc F_c G_j v_j + Σ_j s_j G_j (v_j − mean)² + w,
//
// with G_j the model's element of input j and F_c six linear filters: 1, the
// dead time left out in whole and in half, first-order lags of 1/8, 1/2 and 2
// slowest time constants. So all that is linear is free, gains, dead times and
// time constants that have aged included, and the curvature of a valve's
// characteristic too; only what depends on the direction of moves is taken for
// play. w is drift and what an autoregression of order 24 makes of coloured and
// periodic disturbances (whitened_fit.h). Drift upon white noise has a memory
// that no autoregression has: outputs and responses first pass through the
// filter of its innovations,
//
//   x'_k = x_k − l_k,   l_{k+1} = l_k + κ x'_k,
//
// with the κ of 0, 0.01, 0.03, 0.1 and 0.3 that is likeliest. Rows near samples
// that are bad, or whose innovation is beyond 5 robust deviations, are left
// out.

#ifndef MLE_MAINTAIN_PLAY_REGRESSION_H_
#define MLE_MAINTAIN_PLAY_REGRESSION_H_

#include <memory>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/whitened_fit.h"
#include "mle/model/process_model.h"

namespace mle {

// v of u; all samples finite, width ≥ 0 in the input's unit.
Eigen::RowVectorXd PassThroughPlay(const Eigen::RowVectorXd& input,
                                   double width);

// What another width of an input's play would gain.
struct PlayScore {
  double width = 0.0;
  double nats = 0.0;    // of log-likelihood, under the present filters
  double factor = 1.0;  // of the difference that fits best; 1: what b says
};

class PlayRegression {
 public:
  // `parts` without gaps, must outlive this; `bad` of each part p × N, other
  // than zero where an output is not to be used. Errors as of
  // SimulateResponse(). Outputs and inputs are worked at by `threads` (0: one
  // for each processor).
  static absl::StatusOr<PlayRegression> Create(
      const ProcessModel& model, const std::vector<Record>& parts,
      const std::vector<Eigen::MatrixXd>& bad, int threads = 1);

  // Whether any output has samples enough.
  bool empty() const;
  // Change of each input over the records (m).
  const Eigen::VectorXd& ranges() const { return ranges_; }
  const Eigen::VectorXd& widths() const { return widths_; }

  // Fits everything with inputs passed through plays of these widths (m).
  absl::Status SetWidths(const Eigen::VectorXd& widths);

  // The best of the widths 1 % … 50 % of the input's range in place of the
  // present one, the others as they are. By one product of residuals and
  // responses for each, without another fit; computed anew only of outputs that
  // have been fitted since.
  absl::StatusOr<PlayScore> Score(int input);
  // Of all inputs (m).
  absl::StatusOr<std::vector<PlayScore>> Scores();

  // −½ Σ_i N_i ln S_i, with S_i the squares left of output i under the present
  // filters after a fit with these widths: to be compared with others under the
  // same filters.
  absl::StatusOr<double> LogLikelihood(const Eigen::VectorXd& widths) const;

  // By how many nats an input's play explains the outputs better than none,
  // the others as they are, under the present filters.
  absl::StatusOr<double> OwnNats(int input);

  // By how many nats the present widths explain the outputs better than those
  // of `other`, a copy with other widths, each with its own filters; rows that
  // either leaves out do not count.
  double GainOver(const PlayRegression& other) const;

 private:
  // What the model makes of an input passed through its play, and of the
  // square of it: for each part N × p.
  struct Responses {
    std::vector<Eigen::MatrixXd> linear;
    std::vector<Eigen::MatrixXd> square;
  };
  // What other widths of an input's play, those that Score() tries, make of the
  // outputs of its elements beside the present one: of each width what
  // Simulate() gives.
  using Differences = std::vector<std::vector<Eigen::MatrixXd>>;
  // m, shared by copies.
  using AllResponses = std::vector<std::shared_ptr<const Responses>>;
  struct OutputState {
    std::vector<int> inputs;  // of its elements
    double drift = 0.0;       // κ
    Eigen::VectorXd start;    // of all a: where the next fit begins
    Eigen::VectorXd filter;
    Eigen::VectorXd used;      // 1, or 0 where a row is left out
    Eigen::MatrixXd basis;     // orthonormal, of the whitened columns
    Eigen::VectorXd residual;  // what these leave of the whitened output
    // m: static gains over those of the model, 0 without an element.
    Eigen::VectorXd gains;
    double degrees = 0.0;  // N_i: rows used less parameters
    double variance = 1.0;
    int fits = 0;  // so far
  };
  // What was computed of an input and an output, and after which of its fits:
  // of the widths that are tried in place of the present one what they explain
  // of the residual, over its variance, and their squares; OwnNats().
  struct Merits {
    int fit = 0;
    Eigen::VectorXd products;
    Eigen::VectorXd sizes;
    int own_fit = 0;
    double own = 0.0;
  };

  PlayRegression() = default;
  // What the model makes of an input's moves in these outputs: for each part a
  // column of each.
  absl::StatusOr<std::vector<Eigen::MatrixXd>> Simulate(
      int input, const std::vector<int>& outputs,
      const std::vector<Eigen::RowVectorXd>& moves) const;
  absl::StatusOr<std::shared_ptr<const Responses>> RespondTo(
      int input, double width) const;
  absl::StatusOr<std::shared_ptr<const Differences>> Differ(
      int input, const std::vector<int>& outputs) const;
  WhitenedData DataOf(int output, const AllResponses& responses) const;
  Eigen::VectorXd UsedRows(int output, int order,
                           const Eigen::VectorXd& innovations) const;
  void Fit(int output, OutputState& state) const;
  bool IsUsed(int output, int input) const;
  // Whether an input acts on the output whose play has another width.
  bool IsMoved(int output, const Eigen::VectorXd& widths) const;
  absl::Status UpdateMerits(int input);
  // S_i of a fit to the rows used, and the same at the present widths.
  double Squares(int output, const AllResponses& responses,
                 const Eigen::VectorXd& used) const;
  double SquaresLeft(int output, const Eigen::VectorXd& used) const;

  const std::vector<Record>* parts_ = nullptr;
  const std::vector<Eigen::MatrixXd>* bad_ = nullptr;
  int threads_ = 1;
  ProcessModel model_;
  Eigen::VectorXd ranges_;
  Eigen::VectorXd widths_;
  AllResponses responses_;
  // m, shared by copies; nullptr: not asked for since the width has changed. 13
  // numbers for each sample and element.
  std::vector<std::shared_ptr<const Differences>> differences_;
  std::vector<OutputState> outputs_;         // p
  std::vector<std::vector<Merits>> merits_;  // m, p
};

}  // namespace mle

#endif  // MLE_MAINTAIN_PLAY_REGRESSION_H_
