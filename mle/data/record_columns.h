// Which column of a record file holds what.

#ifndef MLE_DATA_RECORD_COLUMNS_H_
#define MLE_DATA_RECORD_COLUMNS_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/import_options.h"
#include "mle/data/quality_columns.h"
#include "mle/model/process_model.h"

namespace mle {

// The channel of an output's set point, <output>_setpoint, and whether a name
// is one of such.
std::string SetPointName(std::string_view output);
bool IsSetPointName(std::string_view name);

// Whether a tag of a plant has the ending of a set point: SP, SV, setpoint.
bool IsSetPointTag(std::string_view tag);

struct RecordColumn {
  enum class Kind {
    kTime,
    kTimePart,  // the rest of it: the time of the day, or milliseconds
    kOutput,
    kSetPoint,
    kInput,
    kQuality,
    kOther
  };
  Kind kind = Kind::kOther;
  int channel = 0;         // of outputs or inputs
  std::string name;        // in the file
  bool is_mapped = false;  // by a tag
  // A sample of the channel is scale × column + offset.
  double scale = 1.0;
  double offset = 0.0;
  // The column that a quality column describes; −1: all.
  int quality_of = -1;
  QualityKind quality = QualityKind::kCode;
};

// What is declared of an output or input: by its tag, else by the model.
Sampling SamplingOf(const OutputChannel& output,
                    const std::vector<TagMapping>& tags);
Sampling SamplingOf(const InputChannel& input,
                    const std::vector<TagMapping>& tags);

// The names of samples that a record of these channels can have: each output
// and its set point, each input.
std::vector<std::string> ChannelNames(const ProcessModel& channels);

// All columns that a record of these channels can have, in the order in which
// they are written: time, each output and its set point, each input.
// InvalidArgument where two would have one name.
absl::StatusOr<std::vector<RecordColumn>> ColumnsOf(
    const ProcessModel& channels);

// The columns of a header. Names that differ in case and blanks only are taken
// for each other where that is not ambiguous. InvalidArgument for repeated
// columns, set points of unknown outputs, a missing time, input, output or tag,
// and unknown columns: all that is wrong, with the names that may be meant.
absl::StatusOr<std::vector<RecordColumn>> MatchHeader(
    const std::vector<std::string_view>& header, const ProcessModel& channels,
    const ColumnOptions& options);

// Where the samples of a column stand in a row of values: the p outputs, their
// p set points, the m inputs. −1 for what has no samples: times, qualities,
// other columns.
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

#endif  // MLE_DATA_RECORD_COLUMNS_H_
