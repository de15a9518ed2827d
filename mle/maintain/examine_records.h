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

#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/message.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// Blocking findings first, mistakes before others. Records are of the model's
// channels, as imported, nothing marked yet. Errors as of SimulateResponse().
absl::StatusOr<std::vector<Finding>> ExamineRecords(
    const ProcessModel& model, const ExamineOptions& options,
    std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_MAINTAIN_EXAMINE_RECORDS_H_
