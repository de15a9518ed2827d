// Where the samples of a column stand in a row of values: the p outputs, their
// p set points, the m inputs. Internal to mle/data.

#ifndef MLE_DATA_COLUMN_VALUE_H_
#define MLE_DATA_COLUMN_VALUE_H_

#include "mle/data/record_columns.h"
#include "mle/model/process_model.h"

namespace mle {

// −1 for what has no samples: times, qualities, other columns.
inline int ValueOf(const RecordColumn& column, const ProcessModel& channels) {
  const int p = channels.num_outputs();
  switch (column.kind) {
    case RecordColumn::Kind::kOutput:
      return column.channel;
    case RecordColumn::Kind::kSetPoint:
      return p + column.channel;
    case RecordColumn::Kind::kInput:
      return 2 * p + column.channel;
    default:
      return -1;
  }
}

}  // namespace mle

#endif  // MLE_DATA_COLUMN_VALUE_H_
