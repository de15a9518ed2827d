// Lives stored as files, so that an interrupted run can be resumed.
//
// DIR/runs/POLICY_rateR_seedS.json holds the whole life of one policy, with the
// settings it was made under: what it was worth in physical terms, no prices,
// so that other prices need no new simulation. A file is written whole or not
// at all, and used only where its settings are those asked for and its content
// has the SHA-256 that stands in it ("sha256": of the file with 64 zeros in the
// place of the sum).

#ifndef APPS_LIFECYCLE_STORE_H_
#define APPS_LIFECYCLE_STORE_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/lifecycle/life.h"

namespace mle::lifecycle {

// Names and values of all that a life depends on, but for these three:
using Settings = std::map<std::string, std::string>;

struct LifeKey {
  std::string policy;
  double ageing_rate = 1.0;
  std::uint64_t seed = 1;

  std::string FileName() const;
};

std::string FormatLife(const LifeKey& key, const Settings& settings,
                       const Life& life);

// The life in `json`; nothing if it was made under other settings, for another
// key or by a version without checksums. DataLoss, with `source`, for a file
// that is not as it was written.
absl::StatusOr<std::optional<Life>> ParseLife(const std::string& json,
                                              const std::string& source,
                                              const LifeKey& key,
                                              const Settings& settings);

// From and to FOLDER/runs. Nothing where there is no such file.
absl::StatusOr<std::optional<Life>> LoadLife(const std::string& folder,
                                             const LifeKey& key,
                                             const Settings& settings);
absl::Status StoreLife(const std::string& folder, const LifeKey& key,
                       const Settings& settings, const Life& life);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_STORE_H_
