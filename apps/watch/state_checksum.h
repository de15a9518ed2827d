// The checksum of a watch in the state.

#ifndef APPS_WATCH_STATE_CHECKSUM_H_
#define APPS_WATCH_STATE_CHECKSUM_H_

#include <cstddef>
#include <functional>
#include <string>

#include "apps/watch/state.h"

namespace mle::watch {

// SHA-256 of model and options, reference, files, days, scores, alarms and
// corrections; not of deliveries and acknowledgements, which change alone, and
// of the words of the last run.
std::string ChecksumOf(const Watch& watch);

// With scores as another version of the state has them.
using BatchEncoder =
    std::function<std::string(std::size_t output, const StoredBatch& stored)>;
std::string ChecksumOf(const Watch& watch, const BatchEncoder& encode);

}  // namespace mle::watch

#endif  // APPS_WATCH_STATE_CHECKSUM_H_
