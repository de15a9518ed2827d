// Separator and decimal mark of a CSV file, recognised from its beginning.
// Internal to mle/data.

#ifndef MLE_DATA_CSV_FORMAT_H_
#define MLE_DATA_CSV_FORMAT_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record_clock.h"
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

// Where the header of a file stands: titles above it, rows of units or
// descriptions below. Internal to mle/data.

// Lines of `head`, what a file begins with, before the one that has most of
// `names`, where that has two or more; otherwise before the first line of most
// columns.
int TitleLines(std::string_view head, const std::vector<std::string>& names);

// False for text in which no line has one of `names` and none has rows of as
// many fields, with a digit, below it: prose, a script, a list.
bool LooksLikeTable(std::string_view head,
                    const std::vector<std::string>& names);

// Rows that have neither a time nor a number, three at most; `rows` stands
// below the header, whose `columns` are known.
int UnitRows(RowSource& rows, const std::vector<RecordColumn>& columns,
             const RecordClock& clock);

}  // namespace mle

#endif  // MLE_DATA_CSV_FORMAT_H_
