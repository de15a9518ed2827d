// The front door of the library: from a model and records to a decision.
//
//   #include "mle/mle.h"
//
//   const absl::StatusOr<mle::CorrectionResult> result =
//       mle::CorrectFromRecords("column.json", {"march.csv"}, {}, {});
//   if (!result.ok()) …                        // what is wrong, and where
//   if (result->accepted()) WriteProcessModel(result->fopdt_model, "new.json");
//
// examples/ has whole programs. Databases, the forms of models, the watch, the
// trial and the plan have headers of their own: docs/architecture.md lists
// them.

#ifndef MLE_MLE_H_
#define MLE_MLE_H_

#include "mle/data/historian.h"       // IWYU pragma: export
#include "mle/data/record.h"          // IWYU pragma: export
#include "mle/maintain/correct.h"     // IWYU pragma: export
#include "mle/model/process_model.h"  // IWYU pragma: export

#endif  // MLE_MLE_H_
