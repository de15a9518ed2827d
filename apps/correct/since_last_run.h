// The result compared with that of an earlier run, for the page.

#ifndef APPS_CORRECT_SINCE_LAST_RUN_H_
#define APPS_CORRECT_SINCE_LAST_RUN_H_

#include "apps/correct/result.h"
#include "apps/report/html.h"

namespace mle::correct {

// Adds the decision of the last run, and the parameters whose intervals then
// and now do not overlap. result.request.last must be there.
void AddSinceLastRun(const Result& result, report::HtmlPage& page);

}  // namespace mle::correct

#endif  // APPS_CORRECT_SINCE_LAST_RUN_H_
