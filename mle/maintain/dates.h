// Dates that options name, as times of the records. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_DATES_H_
#define MLE_MAINTAIN_DATES_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "mle/data/historian.h"
#include "mle/model/process_model.h"

namespace mle {

// Adds the dates to `times`, in order. Errors name the option: for records
// without dates, and for text that is no date of a form that is certain.
absl::Status AddDates(std::string_view option,
                      const std::vector<std::string>& dates,
                      const HistorianReport& report, const ProcessModel& model,
                      std::vector<double>& times);

}  // namespace mle

#endif  // MLE_MAINTAIN_DATES_H_
