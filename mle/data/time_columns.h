// Which column of a file holds the time, and times that stand in two columns: a
// date and a time of the day, or a time and its milliseconds. Internal to
// mle/data.

#ifndef MLE_DATA_TIME_COLUMNS_H_
#define MLE_DATA_TIME_COLUMNS_H_

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mle/data/record_clock.h"

namespace mle {

// Names that columns of times have, folded (nearest_names.h).
const std::vector<std::string>& UsualTimeColumns();

// "2024-01-01" and "08:15" are "2024-01-01 08:15", "2024-01-01 00:00:00" and
// "08:15" too; "08:15:01" and "500" are "08:15:01.500".
std::string JoinTimeFields(std::string_view first, std::string_view second);

// "date+time" as two names, both among `header` if any division gives that.
// Nothing for a name without a plus, and for one that `header` has.
std::optional<std::pair<std::string, std::string>> SplitTimeName(
    const std::string& name, const std::vector<std::string>& header);

// The name of the time as in ColumnOptions, by what the first `rows` below a
// header hold: one column of dates and one of times of the day; a time and its
// milliseconds; or, where no column has a usual name, the only one of dates
// with times. Nothing where the usual rules do.
std::optional<std::string> RecogniseTimeColumn(
    const std::vector<std::string>& header,
    const std::vector<std::vector<std::string>>& rows,
    const RecordClock& clock);

// A field as samples have it: a number, a word for a bad one, a time.
bool IsSampleField(std::string_view field, const RecordClock& clock);

}  // namespace mle

#endif  // MLE_DATA_TIME_COLUMNS_H_
