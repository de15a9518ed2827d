// Scores as versions 1 to 4 of the state kept them: n, score and lower triangle
// of the information in single precision, ln E of the output and of its
// elements (versions 1 to 3); or 1, n, whether there is a `largest`, and the
// same, that of `largest` first; or 0 in place of 1, where the factor L of the
// information (packed_score.h) and z are in 2 bytes for each number, each row
// with an exponent.

#ifndef APPS_WATCH_SCORES_OF_VERSION_4_H_
#define APPS_WATCH_SCORES_OF_VERSION_4_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/watch/state.h"

namespace mle::watch {

// The numbers of days stay unset: they are not in the bytes. DataLoss if the
// bytes have no such layout.
absl::StatusOr<StoredBatch> DecodeBatchOfVersion4(std::string_view bytes);

// What version 4 wrote, and took the checksum of, where it had read these.
std::string AsVersion4Wrote(std::string_view bytes);

}  // namespace mle::watch

#endif  // APPS_WATCH_SCORES_OF_VERSION_4_H_
