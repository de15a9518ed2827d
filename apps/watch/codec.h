// How scores and references are kept in the state, and the checksum of all.
// Numbers are kept to the last bit, so that what is computed before and after
// does not differ.

#ifndef APPS_WATCH_CODEC_H_
#define APPS_WATCH_CODEC_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/watch/state.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

// Doubles, little-endian: n, 1 where there is `largest` and 0 where not, the
// score and the lower triangle of the information of `largest`, where there is
// one, and of the batch, ln E of the output and of its n/3 elements.
std::string EncodeBatch(const StoredBatch& stored);
// DataLoss for other bytes, for scores that are not finite and for evidence
// that is not a number.
absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes, int number,
                                        int length);

std::string EncodeReference(const WatchReference& reference);  // JSON
absl::StatusOr<WatchReference> DecodeReference(const std::string& json);

// SHA-256 of model and options, reference, files, days, scores, alarms and
// corrections; not of deliveries and acknowledgements, which change alone, and
// of the words of the last run.
std::string ChecksumOf(const Watch& watch);

}  // namespace mle::watch

#endif  // APPS_WATCH_CODEC_H_
