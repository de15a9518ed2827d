// Long tables, with a row for each sample: which column holds what. Internal to
// mle/data; wide_rows.h reads them.

#ifndef MLE_DATA_LONG_TABLE_H_
#define MLE_DATA_LONG_TABLE_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record_columns.h"

namespace mle {

// Which column of a long table holds what; −1: none.
struct LongColumns {
  int time = 0;
  int time_part = -1;  // the rest of a time in two columns
  int tag = 0;
  int value = 0;
  int quality = -1;
  // Other columns of quality, all of which must be good.
  std::vector<int> other_qualities = {};
};

// Names of such columns, for the header to be found by.
std::vector<std::string> LongColumnNames(const ColumnOptions& options);

// Those of a header that names time, tag and value, as declared, by the names
// of `channels` that stand in one of the first `rows`, or by usual names;
// nothing for any other, and for a header that names a channel.
// InvalidArgument where tags stand in a column, but values or times are not
// certain, and for a declared column that is not there.
absl::StatusOr<std::optional<LongColumns>> FindLongColumns(
    const std::vector<std::string>& header,
    const std::vector<std::vector<std::string>>& rows,
    const std::vector<std::string>& channels, const ColumnOptions& options);

}  // namespace mle

#endif  // MLE_DATA_LONG_TABLE_H_
