// Points in time as historians write them (ISO 8601).

#ifndef MLE_DATA_ISO_TIME_H_
#define MLE_DATA_ISO_TIME_H_

#include <optional>
#include <string_view>

namespace mle {

// YYYY-MM-DDThh:mm[:ss[.fraction]][Z|±hh:mm], also with a blank for T, as
// seconds since 1970-01-01T00:00:00Z; without a zone it is taken as UTC.
// Nothing for any other text, and for dates and times that do not exist. (Days
// from civil dates: H. Hinnant, chrono-Compatible Low-Level Date Algorithms,
// 2013.)
std::optional<double> ParseIsoTime(std::string_view text);

// Seconds in a unit of time as process models name it: s, min, h, d and their
// English names. Nothing for any other text.
std::optional<double> SecondsPerUnit(std::string_view time_unit);

}  // namespace mle

#endif  // MLE_DATA_ISO_TIME_H_
