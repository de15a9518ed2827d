// The trial of a correction in the watch (mle/trial/model_trial.h): it begins
// with a correction that says "corrected", looks at each day once, raises an
// alarm where its advice is to adopt, to drop or to roll back, and knows from
// the acknowledgement of the alarm, or from the list of controllers, that the
// correction is in use.

#ifndef APPS_WATCH_TRIAL_H_
#define APPS_WATCH_TRIAL_H_

#include <optional>
#include <string>
#include <vector>

#include "apps/report/html.h"
#include "apps/watch/health.h"
#include "apps/watch/source.h"
#include "apps/watch/state.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle::watch {

// Of the correction of `day`, which was made from these records: they say how
// the loop answers set points, and how large the noise is. A trial that is not
// possible says why.
void BeginTrial(const ProcessModel& in_use, const ProcessModel& proposed,
                double sample_time, const std::vector<Record>& records, int day,
                Watch& watch);

// What has been said since: an acknowledgement of the alarm to adopt means that
// the correction is in use, one of the alarm to roll back that it is no more.
void TakeAdoption(Watch& watch);

// Looks at the days of `data` that come after the last one, and raises alarms.
// A day whose samples change later is not looked at again.
void ContinueTrial(const DatedRecords& data, Watch& watch);

// The trials that go on where the list names another model: one whose proposed
// model that is, is adopted; one whose former model that is after adoption, is
// rolled back; of another model, replaced.
std::vector<Trial> CarryTrials(const ProcessModel& model, const Watch& before);

// Whether the correction came to nothing.
bool HasFailed(const Trial& trial);
// Whether the advice is to roll back, and that has not been done.
bool WaitsForRollBack(const Trial& trial);

// Of the last trial; nothing without one.
std::optional<TrialReport> MakeTrialReport(const Watch& watch,
                                           double seconds_per_unit);
// A sentence that begins with what to do, and what it rests on.
std::vector<std::string> TrialSentences(const TrialReport& report);
// "adopt", "wait", …, "ended"; "–" without a trial.
std::string ShortTrial(const std::optional<TrialReport>& report);
void AddTrial(const TrialReport& report, report::HtmlPage& page);

}  // namespace mle::watch

#endif  // APPS_WATCH_TRIAL_H_
