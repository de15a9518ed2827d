// The front door of the library: from a model and records to a decision.
//
//   #include "mle/mle.h"
//
//   const absl::StatusOr<mle::CorrectionResult> result =
//       mle::CorrectFromRecords("column.json", {"march.csv"}, {}, {});
//   if (!result.ok()) …                        // what is wrong, and where
//   if (result->accepted()) WriteProcessModel(result->fopdt_model, "new.json");
//
// examples/ has whole programs. Everything else of the library stands behind
// headers of its own (docs/architecture.md).

#ifndef MLE_MLE_H_
#define MLE_MLE_H_

#include "mle/data/historian.h"       // IWYU pragma: export
#include "mle/data/record.h"          // IWYU pragma: export
#include "mle/maintain/correct.h"     // IWYU pragma: export
#include "mle/model/process_model.h"  // IWYU pragma: export

#endif  // MLE_MLE_H_
