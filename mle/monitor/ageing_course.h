// The course of an output's ageing over months: by how much a parameter has
// changed, and whether and how fast it goes on.
//
// One parameter a changes by β in all, between the times t_s and t_e, in
// proportion to time:
//
//   δ(t) = β c(t),   c(t) = (t − t_s)/(t_e − t_s), within 0 and 1,
//
// at once (t_s = t_e), over a time of 30 batches (days) or more that has
// passed, or still (t_e is now). With scores S_k and informations V_k of the
// batches (change_evidence.h), whose means are V_k (θ + δ(t_k) e_a), and θ ~
// N(0, σ²I), what the model was off from the start, eliminated,
//
//   b = Σ c_k V_k e_a,   A = Σ V_k + I/σ²,
//   q = Σ c_k S_k,a − bᵀ A⁻¹ Σ S_k,   h = Σ c_k² V_k,aa − bᵀ A⁻¹ b,
//
// β given the times is N(q v/(1 + h v), v/(1 + h v)), where beforehand it is
// N(0, v), and the evidence for these times exp(½ q² v/(1 + h v))/√(1 + h v).
// Beforehand: no change at all as likely as any, the three kinds of course
// equally likely, all parameters, and times: of what changes at once between
// any two batches, of the others on a grid of 24 steps over the whole watch; v
// = τ² or τ²/36 as in change_evidence.h.
//
// The rate is the change over the last 30 batches, a month,
//
//   ρ = δ(T) − δ(T − 30),   0 of a change at once,
//
// its interval from 2.5 to 97.5 % of its distribution over all courses of the
// most probable parameter and none. So a step has no trend, and where it cannot
// be told whether a change goes on the interval is wide and holds 0. A trend is
// told where the interval does not hold 0 and the parameter is at least 90 %
// probable among all; and that there is none where what has changed is known
// and its interval holds only what is small (1 % of a gain a month, 3 % of a
// time constant or of s), or where no parameter could change by more if it did.
//
// Scores scatter by more than noise where the plant does not change exactly so:
// where what the best course leaves of Σ S_kᵀ V_k⁺ S_k exceeds its degrees of
// freedom by a factor φ > 1, all scores and informations are divided by φ
// (McCullagh and Nelder, Generalized Linear Models, 1989, section 4.5). Where φ
// exceeds 2 and the best course explains less than half of what exceeds noise,
// nothing is told.

#ifndef MLE_MONITOR_AGEING_COURSE_H_
#define MLE_MONITOR_AGEING_COURSE_H_

#include <vector>

#include "mle/monitor/change_evidence.h"

namespace mle {

// A value with its interval of 95 %.
struct CourseEstimate {
  double mean = 0.0;
  double low = 0.0;
  double high = 0.0;
};

struct CoursePoint {
  double number = 0.0;  // of a batch
  CourseEstimate change;
};

struct AgeingCourse {
  enum class State {
    kTooShort,       // fewer than 5 batches, or of less than 30 days
    kTrend,          // estimated: see `rate`
    kSteady,         // estimated: nothing changes by more than what is small
    kWhichElement,   // unavailable: of which element and parameter
    kWhetherAtAll,   // unavailable: intervals are too wide
    kNoSingleChange  // unavailable: no course explains the scores
  };
  State state = State::kTooShort;
  // The most probable parameter.
  int element = 0;           // of those present in the row
  int parameter = 0;         // 0: gain, 1: time constant, 2: dead time
  double changed = 0.0;      // probability that anything has changed
  double probability = 0.0;  // of this parameter, if anything has
  // Relative, or in units of s for a dead time.
  CourseEstimate change;  // δ(T)
  CourseEstimate rate;    // ρ
  // If a gain of the output changed all the same, by no more than this in 30
  // batches: the most of the ends of the intervals of changes that go on.
  double largest_gain_rate = 0.0;
  // δ over the watch, at most 40 where the parameter is known, else none.
  std::vector<CoursePoint> points = {};

  static constexpr double kKnown = 0.9;
  // Something has changed, and it is this parameter.
  bool is_known() const { return changed >= kKnown && probability >= kKnown; }
};

// Estimates the course from batches whose numbers increase; `now`: number of
// the last batch that was looked at.
AgeingCourse EstimateCourse(const std::vector<ScoredBatch>& batches, int now,
                            const WatchOptions& options);

}  // namespace mle

#endif  // MLE_MONITOR_AGEING_COURSE_H_
