// Which column of a record file holds what.

#ifndef MLE_DATA_RECORD_COLUMNS_H_
#define MLE_DATA_RECORD_COLUMNS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/model/process_model.h"

namespace mle {

struct RecordColumn {
  enum class Kind { kTime, kOutput, kSetPoint, kInput, kOther };
  Kind kind = Kind::kOther;
  int channel = 0;  // of outputs or inputs
  std::string name;
};

// All columns that a record of these channels can have, in the order in which
// they are written: time, each output and its set point, each input.
// InvalidArgument where two would have one name.
absl::StatusOr<std::vector<RecordColumn>> ColumnsOf(
    const ProcessModel& channels);

// The columns of a header, blanks around its names aside. InvalidArgument for a
// column that stands twice, the set point of an unknown output, or a missing
// time, input or output.
absl::StatusOr<std::vector<RecordColumn>> MatchHeader(
    const std::vector<std::string>& header, const ProcessModel& channels);

}  // namespace mle

#endif  // MLE_DATA_RECORD_COLUMNS_H_
