// How scores and references are kept in the state.

#ifndef APPS_WATCH_CODEC_H_
#define APPS_WATCH_CODEC_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/watch/state.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

// In single precision, little-endian: n, score, the lower triangle of the
// information row by row, ln E of the output and of its elements.
std::string EncodeBatch(const StoredBatch& batch);
// All but the numbers. DataLoss for bytes that are not such.
absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes);

// Rounded as they are kept, so that what is computed before and after does not
// differ.
BatchOutput AsKept(BatchOutput scores);
ChangeEvidence AsKept(ChangeEvidence evidence);

std::string EncodeReference(const WatchReference& reference);  // JSON
absl::StatusOr<WatchReference> DecodeReference(const std::string& json);

}  // namespace mle::watch

#endif  // APPS_WATCH_CODEC_H_
