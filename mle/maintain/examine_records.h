// Faults of records that are found before anything is fitted: what the data are
// (compression.h, input_spikes.h, stuck_outputs.h, operation.h), and
// configuration errors (operator_mistakes.h).
//
//   MLE_ASSIGN_OR_RETURN(const std::vector<Finding> findings,
//                        ExamineRecords(model, ExamineOptions(), records));
//   if (const Finding* reason = FirstBlocking(findings)) …  // cannot tell
//
// docs/records.md has the thresholds and their reasons.

#ifndef MLE_MAINTAIN_EXAMINE_RECORDS_H_
#define MLE_MAINTAIN_EXAMINE_RECORDS_H_

#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/data/record_columns.h"
#include "mle/data/time_names.h"
#include "mle/maintain/message.h"
#include "mle/model/process_model.h"

namespace mle {

enum class Consequence {
  kNote,    // of none
  kRepair,  // the samples concerned are marked as bad, or replaced
  kDoubts,  // nothing can be said of some outputs
  kBlocks,  // nothing can be said of the plant from these records
};

// "note", "repair", "doubts", "blocks".
std::string_view NameOf(Consequence consequence);

struct Finding {
  Message message;  // place: the tag, or empty
  Consequence consequence = Consequence::kNote;
  // Times of the first and the last sample concerned.
  double from = 0.0;
  double to = 0.0;
  // The size of the finding: a share, a factor, a time, a width, a number of
  // samples.
  double value = 0.0;
  // kDoubts: of which nothing can be said.
  std::vector<int> outputs;
};

struct ExamineOptions {
  // Whether samples are marked and replaced; if not, what could be repaired
  // stays as it is.
  bool repair = true;
  // How messages write times; without a unit, in the model's.
  TimeNames times = {};
  // The columns of channels, for messages that say how a mapping is corrected.
  std::vector<TagMapping> tags = {};

  // At least 0; 0 takes one for each processor. Findings do not depend on it.
  int threads = 0;

  absl::Status Validate() const;
};

// Blocking findings first, mistakes before others. Records are of the model's
// channels, as imported, nothing marked yet. Errors as of SimulateResponse().
absl::StatusOr<std::vector<Finding>> ExamineRecords(
    const ProcessModel& model, const ExamineOptions& options,
    std::vector<Record>& records);

// Null if none blocks.
const Finding* FirstBlocking(const std::vector<Finding>& findings);

}  // namespace mle

#endif  // MLE_MAINTAIN_EXAMINE_RECORDS_H_
