// Alarms acknowledged on the command line, or by those a server answers.

#ifndef APPS_WATCH_ACKNOWLEDGEMENT_H_
#define APPS_WATCH_ACKNOWLEDGEMENT_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/watch/request.h"
#include "apps/watch/state.h"

namespace mle::watch {

// Now, by `who`. InvalidArgument without a name, or where name or note are too
// long.
absl::StatusOr<Acknowledgement> MakeAcknowledgement(const std::string& who,
                                                    const std::string& note);

// What --acknowledge asks for; says on standard output what was done.
absl::Status AcknowledgeAlarm(const Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_ACKNOWLEDGEMENT_H_
