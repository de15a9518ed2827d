// One run of one controller's watch: what is new is scored, the evidence
// carried on, alarms raised.

#ifndef APPS_WATCH_UPDATE_H_
#define APPS_WATCH_UPDATE_H_

#include <string>

#include "absl/status/status.h"
#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/exchange/model_file.h"
#include "mle/model/process_model.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

// ε of an output's and of an element's alarm: the probability of a false one.
double ShareOfOutput(const ProcessModel& model, const WatchOptions& options);
double ShareOfElement(const ProcessModel& model, const WatchOptions& options);

// SHA-256 of the model and of the options that scores depend on.
std::string BasisOf(const Controller& controller, const ProcessModel& model);

// Brings `watch` up to date with the controller's records; it is not changed by
// records that were seen. A model or options other than before begin a new
// watch after the last day that was looked at. What was found is in watch.news.
// Errors name what cannot be read.
absl::Status UpdateWatch(const Controller& controller,
                         const ProcessModel& model, Watch& watch);

// "The gain of overhead ← reflux has changed by −12 ± 2 %, since about …"
std::string Describe(const ProcessModel& model, int output,
                     const LikelyChange& likely, const std::string& since,
                     double delay_unit);

// The correction that is run when the evidence suffices, and kept as a
// proposal: nothing is ever written to a controller.

// Whether there is an alarm that the model has aged, and no proposal for it, or
// one that could not tell and is two weeks old, or whose trial came to nothing
// two weeks ago; never while a trial says to roll back.
bool NeedsProposal(const Watch& watch);

// Corrects the model by the records since the change most likely began, of 60
// days at most (CorrectFromData()), writes what mle_correct writes into
// FOLDER/<name of the file for the controller>/<day>, whole or not at all, and
// adds what came of it to the watch; a corrected model goes on trial (trial.h).
// A correction that fails, or takes longer
// than an hour, is a proposal that says so.
void MakeProposal(const Controller& controller, const ModelFile& model,
                  const std::string& folder, Watch& watch);

// A name for files of the controller: letters, digits and hyphens stay, all
// else becomes _ and two hexadecimal digits.
std::string FileNameOf(const std::string& controller);

}  // namespace mle::watch

#endif  // APPS_WATCH_UPDATE_H_
