// The correction that is run when the evidence suffices, and kept as a
// proposal: nothing is ever written to a controller.

#ifndef APPS_WATCH_PROPOSAL_H_
#define APPS_WATCH_PROPOSAL_H_

#include <string>

#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/exchange/model_file.h"

namespace mle::watch {

// Whether there is an alarm, and no proposal for it, or one that could not tell
// and is two weeks old.
bool NeedsProposal(const Watch& watch);

// Corrects the model by the records since the change most likely began, of 60
// days at most (CorrectFromData()), writes what mle_correct writes into
// FOLDER/<name of the file for the controller>/<day>, whole or not at all, and
// adds what came of it to the watch. A correction that fails, or takes longer
// than an hour, is a proposal that says so.
void MakeProposal(const Controller& controller, const ModelFile& model,
                  const std::string& folder, Watch& watch);

// A name for files of the controller: letters, digits and hyphens stay, all
// else becomes _ and two hexadecimal digits.
std::string FileNameOf(const std::string& controller);

}  // namespace mle::watch

#endif  // APPS_WATCH_PROPOSAL_H_
