// What to do, from the costs of the policies: at the top of the page and at the
// end on the terminal.
//
// Two policies are told apart where the 95 % interval of the difference of
// their costs over the same lives does not hold zero.

#ifndef APPS_LIFECYCLE_HEADLINE_H_
#define APPS_LIFECYCLE_HEADLINE_H_

#include <string>
#include <vector>

#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/html.h"

namespace mle::lifecycle {

enum class Answer {
  kUpdate,      // the cheapest policy updates, and costs less than never
  kKeep,        // never is the cheapest
  kCannotTell,  // one life, or never cannot be told apart from the cheapest
  kNoNever,     // updates were compared without never
  kNoUpdates,   // never and perfect alone
  kDiverged,    // the loop diverged in a life of every policy but perfect
};

Answer AnswerAt(const RateSummary& rate);

// Of the rates the one nearest to 1, the ageing as its file has it; not empty.
const RateSummary& NominalRate(const std::vector<RateSummary>& summaries);

// Badge, headline and sentences for the nominal rate, with the answers at the
// other rates.
report::Verdict VerdictOf(const Campaign& campaign,
                          const std::vector<RateSummary>& summaries,
                          const Valuation& valuation);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_HEADLINE_H_
