// The change of each element in a few words: for the table on the terminal, the
// page and its map.

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

// Whether a table has room for a column of each input.
bool FitsInColumns(const ProcessModel& model);

// The same, a cell for each pair, with how much of the step response changes;
// where that has no room, a row for each element.
report::Table MismatchTable(const Result& result);

// The same for readers who want no statistics: what has changed of each pair,
// the ground the darker the larger the change of the step response. Where that
// has no room, a row for each element that has changed or was to change, the
// largest change first.
report::Table ChangeMap(const Result& result);

// Below such rows, what is known of the elements that have none; empty where
// there is no such element, and below a map.
std::string WhatOthersShow(const Result& result);

// Below the map, why its cells are not estimated; empty where they are.
std::string WhyNotEstimated(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_MISMATCH_MAP_H_
