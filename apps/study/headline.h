// What a campaign says about its corrections, in a line and in counts.
//
// A case is a scenario with a method that corrects. Its correction ends closer
// to the plant where the median over the seeds of the squared distance E of the
// step responses is below that of the initial model, and farther where it is
// above.

#ifndef APPS_STUDY_HEADLINE_H_
#define APPS_STUDY_HEADLINE_H_

#include <cstdint>
#include <vector>

#include "apps/report/html.h"
#include "apps/study/campaign.h"
#include "apps/study/summary.h"

namespace mle::study {

enum class Outcome { kCloser, kUnchanged, kFarther };

// Of a case, i.e. a cell with values of E.
Outcome OutcomeOf(const Cell& cell);
// Whether the cell is a case, and not a model left as it is or a cell in which
// every run failed.
bool IsCase(const experiment::Campaign& campaign, const Cell& cell);

// What the cases of one method come to.
struct MethodTally {
  int method = 0;  // of the campaign's
  int closer = 0;
  int unchanged = 0;
  int farther = 0;
  int closest = 0;  // scenarios in which no other method has a smaller median
  // E after over E before, medians: of the middle case and of the worst; NaN
  // without cases with E before above 0.
  double middle_ratio = 0.0;
  double worst_ratio = 0.0;
  std::int64_t runs = 0;  // that did not fail
  double harmed = 0.0;    // of them, with E above that of the initial model

  int cases() const { return closer + unchanged + farther; }
};

// In the order of the campaign's methods, those that correct.
std::vector<MethodTally> TallyMethods(const experiment::Campaign& campaign,
                                      const StudySummary& summary);

report::Verdict VerdictOf(const experiment::Campaign& campaign,
                          const StudySummary& summary);

}  // namespace mle::study

#endif  // APPS_STUDY_HEADLINE_H_
