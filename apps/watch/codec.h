// How scores, days and references are kept in the state.

#ifndef APPS_WATCH_CODEC_H_
#define APPS_WATCH_CODEC_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/watch/state.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

// n, flags, `largest` where there is one and all of the batch, packed
// (packed_score.h), and ln E of the output and of its elements in hundredths,
// rounded down. Where packing would change score or information, both (its
// lower triangle) in single precision. What RoundAsKept() has rounded is read
// back exactly.
std::string EncodeBatch(const StoredBatch& batch);
// Takes what EncodeBatch() has written off the front of `bytes`: all but the
// numbers. DataLoss where it is not there.
absl::StatusOr<StoredBatch> TakeBatch(std::string_view& bytes);
// Whether its scores are finite and its evidence is a number.
bool IsSound(const StoredBatch& batch);

// The batches of all outputs that begin with a number, in turn: the length of
// each, 0 where an output has none, and the batch. Empty where no output has
// one.
std::string EncodeScores(const Watch& watch, int number);
// Puts them into the watch. DataLoss for other bytes.
absl::Status DecodeScores(std::string_view bytes, int number, Watch& watch);

// Days are kept together with those of their block, floor(day/64).
int BlockOf(int day);
// The days of a block: of each its place in the block, its state, its checksum
// and the reason. No bytes if the watch has no day of the block.
std::string EncodeDays(const Watch& watch, int block);
// Puts them into the watch. DataLoss for other bytes.
absl::Status DecodeDays(std::string_view bytes, int block, Watch& watch);

// Rounded as they are kept, so that what is computed before and after does not
// differ: evidence is never more than it was, and covariances of the reference
// are off by 5e-7 of r at most.
void RoundAsKept(ScoredBatch& batch);
ChangeEvidence AsKept(ChangeEvidence evidence);
void RoundAsKept(WatchReference& reference);

std::string EncodeReference(const WatchReference& reference);  // JSON
absl::StatusOr<WatchReference> DecodeReference(const std::string& json);

}  // namespace mle::watch

#endif  // APPS_WATCH_CODEC_H_
