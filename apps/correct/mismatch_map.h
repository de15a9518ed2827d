// What has become of each element, in a few words: for the table on the
// terminal, the page and its map.

#ifndef APPS_CORRECT_MISMATCH_MAP_H_
#define APPS_CORRECT_MISMATCH_MAP_H_

#include <string>
#include <vector>

#include "apps/correct/result.h"
#include "apps/report/table.h"

namespace mle::correct {

// Lines such as "gain × 0.644", "dead time +2.92 min", "p < 10⁻⁹".
std::vector<std::string> DescribeMismatch(const Result& result, int output,
                                          int input);

// The same, a cell for each pair, with how much of the step response changes.
report::Table MismatchTable(const Result& result);

// The same for readers who want no statistics: what has changed of each pair,
// the ground the darker the larger the change of the step response.
report::Table ChangeMap(const Result& result);

// Below the map, why its cells are not estimated; empty where they are.
std::string WhyNotEstimated(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_MISMATCH_MAP_H_
