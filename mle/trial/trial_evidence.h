// Evidence that may be looked at after every response, for ever, from
// differences X_1, X_2, …: given what came before, their mean is at most 0 if
// the hypothesis holds, and they are symmetric about it with a variance of at
// most 1 and a fourth moment of at most κ = 4 (normal ones have 3). Then
//
//   E_n = Σ_s w_s mean over g of Π_{s<i≤n} F(g μ_i, X_i),
//   F(c, X) = max(0, 1 + c X)⁴ / (1 + 6 c² + κ c⁴),
//
// μ_i being what X_i is expected to be where the proposed model is right, known
// before the outputs are; g = ⅛, ¼, ½, c at most 1.5; and s = 0, 1, … the
// responses after which the evidence is counted, w_0 = 0.8, w_s = 0.2/(s (s +
// 1)), so that a single disturbed response does not end it. With m = E X ≤ 0
//
//   E max(0, 1 + c X)⁴ ≤ E (1 + c (X − m))⁴ ≤ 1 + 6 c² + κ c⁴,
//
// so that E is a non-negative supermartingale that begins at 1: it ever reaches
// 1/α with a probability of at most α (Ville). X is clipped at ±
// kMostDifference, where a single response makes E 60 at most. (Testing by
// betting: Waudby-Smith and Ramdas, J. R. Stat. Soc. B 86, 2024; Shafer, J. R.
// Stat. Soc. A 184, 2021.)

#ifndef MLE_TRIAL_TRIAL_EVIDENCE_H_
#define MLE_TRIAL_TRIAL_EVIDENCE_H_

#include <array>

namespace mle {

inline constexpr double kMostDifference = 4.0;

class TrialEvidence {
 public:
  // Takes the next difference into account; `expected` ≥ 0.
  void Add(double difference, double expected);
  // ln E.
  double log() const;

 private:
  static constexpr std::array<double, 3> kBets = {0.125, 0.25, 0.5};
  std::array<double, 3> begun_ = {};  // Σ_s w_s Π of each g
  int seen_ = 0;                      // n
};

}  // namespace mle

#endif  // MLE_TRIAL_TRIAL_EVIDENCE_H_
