// Evidence that may be looked at after every batch, for ever: e-processes of
// one output's elements from the scores of its batches (model_watch.h).
//
// Let batches have scores S_b and informations V_b, and let the parameters be θ
// (what the model already was off at the begin, unknown) until batch s − 1, and
// θ + δ from s on. θ is eliminated: with sums over all batches up to now, S, V,
// and over those from s on, S′, V′,
//
//   S_s = S′ − V′ (V + I/σ²)⁻¹ S,   V_s = V′ − V′ (V + I/σ²)⁻¹ V′,
//
// and the likelihood ratio of δ against no change is exp(δᵀS_s − δᵀV_sδ/2). For
// one parameter, with density π of δ beforehand (half N(0, τ²), half N(0,
// τ²/36)), against any change |δ| ≤ b that is none, and over all begins s with
// weights w_s that add up to one,
//
//   E_a = Σ_s w_s ∫ π(δ) R(δ) dδ / max_{|δ|≤b} R(δ),
//   R(δ) = exp(δ S_s,a − δ² V_s,aa/2),
//
//   of the output     mean of E_a over its parameters
//   of an element     mean of E_a over its three; S and V are those of a after
//                     the change of the parameters of all other elements is
//                     eliminated, and w_s is multiplied by the likelihood ratio
//                     of the others' change at s over that at their best begin:
//                     what the others did at any one time is not the element's
//
// While nothing changes E is a non-negative supermartingale that begins at 1,
// so that it ever reaches 1/ε with a probability of at most ε (Ville), however
// often it is looked at: mixtures of likelihood ratios (Robbins, Annals of
// Mathematical Statistics 41, 1970; Ramdas, Grünwald, Vovk and Shafer,
// Statistical Science 38, 2023). Alarms are raised at
//
//   2p/α   for an output,   2 · elements/α   for an element,
//
// so that a model raises a false one with probability α at most. The weights
//
//   w_d = (1/7) Σ_{l=0..6} [2^l divides d] / ⌈N/2^l⌉,   d = 0 … N − 1,
//
// do not fall with the age d: late changes are found as fast as early ones, and
// slow ones, which a coarse d suffices for, cost less.

#ifndef MLE_MONITOR_CHANGE_EVIDENCE_H_
#define MLE_MONITOR_CHANGE_EVIDENCE_H_

#include <optional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"

namespace mle {

// Options of the watch of a model: the probability of a false alarm, the
// model's life, and which changes count.
struct WatchOptions {
  // α in (0, 1): the probability of ever raising an alarm on a model that does
  // not change, over all its outputs and elements and its whole life.
  double level = 0.05;
  // Batches over which a change may begin, ≥ 64: the life that `level` is of,
  // 10 years of days. Later ones add evidence of changes that began before.
  int life = 3650;
  // Relative changes of a gain, a time constant or a dead time up to this are
  // no change, in [0, 0.5).
  double least_change = 0.005;
  // Standard deviation beforehand of the relative errors that the model's
  // parameters have when the watch begins, in (0, 10]: these are not changes.
  double model_error = 0.05;
  // Standard deviation beforehand of the relative change of what has changed,
  // in (0, 10].
  double change_deviation = 0.3;
  // Innovations count up to this, in robust standard deviations, ≥ 2: single
  // outliers say nothing of a model.
  double clip = 4.0;
  // A batch is disturbed where the mean square of its innovations, less what a
  // change of the model could explain, exceeds this, > 1, of that of the
  // reference.
  double disturbed = 2.5;

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

struct ScorePart {
  Eigen::VectorXd score;        // n, a multiple of three
  Eigen::MatrixXd information;  // n × n
};

// The scores kept of an output's batch, or of several that were merged.
struct ScoredBatch {
  int number = 0;               // of the batch since the watch began, from 0 on
  int length = 1;               // batches that are in it
  Eigen::VectorXd score;        // n, a multiple of three
  Eigen::MatrixXd information;  // n × n
  // The part of both that comes from one change of set points.
  std::optional<ScorePart> largest = {};
};

// w_d; 0 from `life` on.
double WeightOfBegin(int batch, int life);

// After a batch.
struct ChangeEvidence {
  int number = 0;                    // of the last batch in it
  double log_output = 0.0;           // ln E
  std::vector<double> log_elements;  // n/3
};

// After the last of the batches, whose numbers increase; without batches ln E
// is 0. `least` (n): b.
ChangeEvidence EvidenceOf(const std::vector<ScoredBatch>& batches,
                          const Eigen::VectorXd& least,
                          const WatchOptions& options);

// The least of EvidenceOf() of all batches and of all but one, for each of the
// three batches whose scores are largest, by SᵀV⁺S: what a single one alone
// says, as one with a disturbance at the wrong time does, is no evidence. Of a
// batch with a `largest` change that change is left out, and its size counts.
// Never more than EvidenceOf(), so that the level holds.
ChangeEvidence ConfirmedEvidenceOf(const std::vector<ScoredBatch>& batches,
                                   const Eigen::VectorXd& least,
                                   const WatchOptions& options);

// ln E of one of the elements alone, as these two have it.
double ElementEvidenceOf(const std::vector<ScoredBatch>& batches, int element,
                         const Eigen::VectorXd& least,
                         const WatchOptions& options);
double ConfirmedElementEvidenceOf(const std::vector<ScoredBatch>& batches,
                                  int element, const Eigen::VectorXd& least,
                                  const WatchOptions& options);

// Merges batches that are old at batch `now`: 64 and more before into blocks of
// 8 batches, 512 and more before into blocks of 64. A change can then begin
// with a block only, which loses evidence and never adds any. Blocks have no
// `largest`.
std::vector<ScoredBatch> MergeOld(const std::vector<ScoredBatch>& batches,
                                  int now);

// The information of the batches on the three parameters of an element, for a
// change that begins with the first batch of number `begin` or more: V_s, all
// other elements' changes eliminated. Zero without such a batch.
Eigen::Matrix3d OwnInformation(const std::vector<ScoredBatch>& batches,
                               int begin, int element,
                               const WatchOptions& options);

// The change that explains the evidence best, all elements equally likely
// beforehand and a single parameter changed abruptly.
struct LikelyChange {
  int element = 0;           // of those present
  int parameter = 0;         // 0: gain, 1: time constant, 2: dead time
  double probability = 0.0;  // of the element among them
  double change = 0.0;       // δ, with standard error
  double error = 0.0;
  int begin = 0;  // number of the batch that it most likely began with
};

// Nothing is likely without batches: probability 0.
LikelyChange ExplainEvidence(const std::vector<ScoredBatch>& batches,
                             const Eigen::VectorXd& least,
                             const WatchOptions& options);

// 1/(1 + ε E): the probability that nothing has changed, if beforehand the odds
// of a change were ε : 1. Where an alarm is raised at E = 1/ε it is one half.
double HealthOf(double log_evidence, double share_of_level);

}  // namespace mle

#endif  // MLE_MONITOR_CHANGE_EVIDENCE_H_
