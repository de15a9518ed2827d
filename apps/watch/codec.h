// How scores and references are kept in the state.

#ifndef APPS_WATCH_CODEC_H_
#define APPS_WATCH_CODEC_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/watch/state.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

// 0, n, whether there is a `largest`, what it and all of the batch are packed
// into (packed_score.h), and in single precision, little-endian, ln E of the
// output and of its elements. Where packing would change them, 1 in place of 0,
// and score and lower triangle of the information in single precision. What
// RoundAsKept() has rounded is read back exactly.
std::string EncodeBatch(const StoredBatch& batch);
// All but the numbers. Those of version 3 and before too, which begin with n.
// DataLoss for bytes that are neither.
absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes);

// Rounded as they are kept, so that what is computed before and after does not
// differ.
void RoundAsKept(ScoredBatch& batch);
ChangeEvidence AsKept(ChangeEvidence evidence);

std::string EncodeReference(const WatchReference& reference);  // JSON
absl::StatusOr<WatchReference> DecodeReference(const std::string& json);

}  // namespace mle::watch

#endif  // APPS_WATCH_CODEC_H_
