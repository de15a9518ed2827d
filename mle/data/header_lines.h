// Where the header of a file stands: titles above it, rows of units or
// descriptions below. Internal to mle/data.

#ifndef MLE_DATA_HEADER_LINES_H_
#define MLE_DATA_HEADER_LINES_H_

#include <string>
#include <string_view>
#include <vector>

#include "mle/data/record_clock.h"
#include "mle/data/record_columns.h"
#include "mle/data/row_source.h"

namespace mle {

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

#endif  // MLE_DATA_HEADER_LINES_H_
