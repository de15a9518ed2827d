// Dates of set-point changes as times of the records. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_CHANGE_DATES_H_
#define MLE_MAINTAIN_CHANGE_DATES_H_

#include "absl/status/status.h"
#include "mle/data/historian.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle {

// Adds options.change_dates to options.windows.change_times, in order. Errors
// name change_times: for records without dates, and for text that is no date of
// a form that is certain.
absl::Status AddChangeDates(const HistorianReport& report,
                            const ProcessModel& model, RecordOptions& options);

}  // namespace mle

#endif  // MLE_MAINTAIN_CHANGE_DATES_H_
