// The journal, sorted: runs.csv, whose bytes depend on the campaign alone, and
// timings.csv.

#ifndef APPS_STUDY_MERGE_H_
#define APPS_STUDY_MERGE_H_

#include <string>

#include "absl/status/status.h"
#include "apps/study/journal.h"

namespace mle::study {

// All runs must be in the journal. Files are written line by line beside their
// place and renamed, whole or not at all.
absl::Status MergeRuns(const Journal& journal, std::int64_t runs,
                       const std::string& folder);

}  // namespace mle::study

#endif  // APPS_STUDY_MERGE_H_
