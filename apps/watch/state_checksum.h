// The checksum of a watch in the state.

#ifndef APPS_WATCH_STATE_CHECKSUM_H_
#define APPS_WATCH_STATE_CHECKSUM_H_

#include <string>

#include "apps/watch/state.h"

namespace mle::watch {

// SHA-256 of model and options, reference, files, days, scores, alarms and
// corrections; not of deliveries and acknowledgements, which change alone, and
// of the words of the last run.
std::string ChecksumOf(const Watch& watch);

}  // namespace mle::watch

#endif  // APPS_WATCH_STATE_CHECKSUM_H_
