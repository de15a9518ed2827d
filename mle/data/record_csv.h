// Records as CSV files (docs/formats.md).
//
//   time,overhead,overhead_setpoint,reflux
//   0,0.0131,0,0
//   0.2,,0,0
//
// A header; `time` in equal steps, as numbers in the model's unit or ISO 8601
// (iso_time.h; the record then starts at 0); a column for each input and output
// of a process model, by name, in any order; optionally <output>_setpoint.
// Other columns are passed over. A field that is empty, NaN or a declared bad
// value is a bad sample (NaN in the Record).
//
//   MLE_RETURN_IF_ERROR(WriteRecordCsv("run.csv", record, model));
//   MLE_ASSIGN_OR_RETURN(Record again, ReadRecordCsv("run.csv", model));
//
// Values are written with the fewest digits that read back as the same double.

#ifndef MLE_DATA_RECORD_CSV_H_
#define MLE_DATA_RECORD_CSV_H_

#include <istream>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct RecordCsvOptions {
  // What a historian writes for a bad sample, as text ("Bad Input") or as a
  // number ("-9999", which -9999.0 is too).
  std::vector<std::string> bad_values;
};

// The sample time is the mean step of the time column, rounded to 12 digits
// where that agrees with all times. Rows follow the channels of `channels`; set
// points are empty where no output has one, and NaN for outputs without one.
//
// InvalidArgument, naming file, line and column, for a malformed row, a
// missing, repeated or misspelt column, a field that is no number, a step of
// time that differs by over 1 % from the first (a gap: its samples have to
// stand there, as bad ones), or fewer than two rows. NotFound and the like for
// the file.
absl::StatusOr<Record> ReadRecordCsv(const std::string& path,
                                     const ProcessModel& channels,
                                     const RecordCsvOptions& options = {});
// The same from a stream; `source` opens every message.
absl::StatusOr<Record> ParseRecordCsv(std::istream& in, std::string_view source,
                                      const ProcessModel& channels,
                                      const RecordCsvOptions& options = {});

// InvalidArgument for a record that is not valid or not of these channels, and
// for names of channels that would be columns of other meaning.
absl::StatusOr<std::string> FormatRecordCsv(const Record& record,
                                            const ProcessModel& channels);
// Writes the file whole or not at all.
absl::Status WriteRecordCsv(const std::string& path, const Record& record,
                            const ProcessModel& channels);

}  // namespace mle

#endif  // MLE_DATA_RECORD_CSV_H_
