// Records as CSV files (docs/formats.md).
//
//   time,overhead,overhead_setpoint,reflux
//   0,0.0131,0,0
//   0.2,,0,0
//
// A header; `time` in equal steps, in the model's unit; a column for each
// output, its set point where the record has them, and each input, by name. A
// bad sample (NaN) is an empty field.
//
//   MLE_RETURN_IF_ERROR(WriteRecordCsv("run.csv", record, model));
//
// Values are written with the fewest digits that read back as the same double.
// ImportHistorian() (historian.h) with the record's sample_time and max_gap = 0
// gives the same record again.

#ifndef MLE_DATA_RECORD_CSV_H_
#define MLE_DATA_RECORD_CSV_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// InvalidArgument for a record that is not valid or not of these channels, and
// for names of channels that would be columns of other meaning.
absl::StatusOr<std::string> FormatRecordCsv(const Record& record,
                                            const ProcessModel& channels);
// Writes the file whole or not at all.
absl::Status WriteRecordCsv(const std::string& path, const Record& record,
                            const ProcessModel& channels);

}  // namespace mle

#endif  // MLE_DATA_RECORD_CSV_H_
