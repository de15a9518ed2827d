// Separator and decimal mark of a CSV file, recognised from its beginning.
// Internal to mle/data.

#ifndef MLE_DATA_CSV_FORMAT_H_
#define MLE_DATA_CSV_FORMAT_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record_columns.h"

namespace mle {

// The beginning of a file, its header first.
struct CsvHead {
  std::string text;
  bool is_whole = false;  // the file ends here
  std::string source;     // its name
  int line = 1;           // of the header
  bool is_table = false;  // as of CsvRows
};

// The one of comma, semicolon and tab that occurs in the header; if several
// occur, the one that yields most of `names` as fields. InvalidArgument for a
// tie.
absl::StatusOr<char> RecogniseSeparator(const CsvHead& head,
                                        const std::vector<std::string>& names);

// A comma if fields of `columns` (of the header) have one and none has a point,
// else a point. InvalidArgument, with line and column, if there are both, or
// only such as may also be thousands ("1,234").
absl::StatusOr<char> RecogniseDecimal(const CsvHead& head, char separator,
                                      const std::vector<RecordColumn>& columns);

}  // namespace mle

#endif  // MLE_DATA_CSV_FORMAT_H_
