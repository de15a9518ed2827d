// Separator and decimal mark of a CSV file, recognised from its beginning.
// Internal to mle/data.

#ifndef MLE_DATA_CSV_FORMAT_H_
#define MLE_DATA_CSV_FORMAT_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record_columns.h"
#include "mle/data/row_source.h"

namespace mle {

// The one of comma, semicolon and tab that occurs in the header; if several
// occur, the one that yields most of `names` as fields. InvalidArgument for a
// tie. `text` is what a file begins with, its header first; that stands in
// `line`.
absl::StatusOr<char> RecogniseSeparator(std::string_view text,
                                        const std::string& source, int line,
                                        const std::vector<std::string>& names);

// A comma if fields of `columns` (of the header, which `rows` begin with) have
// one and none has a point, else a point. InvalidArgument, with line and
// column, if there are both, or only such as may also be thousands ("1,234").
absl::StatusOr<char> RecogniseDecimal(RowSource& rows,
                                      const std::vector<RecordColumn>& columns);

}  // namespace mle

#endif  // MLE_DATA_CSV_FORMAT_H_
