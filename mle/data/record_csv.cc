#include "mle/data/record_csv.h"

#include <cmath>
#include <limits>

#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/record_columns.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

absl::Status CheckRecord(const Record& record, const ProcessModel& channels) {
  MLE_RETURN_IF_ERROR(record.Validate());
  if (record.num_outputs() == channels.num_outputs() &&
      record.num_inputs() == channels.num_inputs()) {
    return absl::OkStatus();
  }
  return InvalidArgument("the record has ", record.num_outputs(),
                         " outputs and ", record.num_inputs(),
                         " inputs, the process model ", channels.num_outputs(),
                         " and ", channels.num_inputs());
}

// Times as short as they can be written without being others.
class TimeColumn {
 public:
  explicit TimeColumn(const Record& record)
      : record_(record),
        may_round_(RoundCsvTime(record.start_time) == record.start_time &&
                   RoundCsvTime(record.sample_time) == record.sample_time) {}

  double At(int k) const {
    const double time = record_.time(k);
    const double rounded = RoundCsvTime(time);
    const double slack =
        2.0 * std::numeric_limits<double>::epsilon() * std::abs(time);
    return may_round_ && std::abs(rounded - time) <= slack ? rounded : time;
  }

 private:
  const Record& record_;
  bool may_round_ = false;
};

}  // namespace

absl::StatusOr<std::string> FormatRecordCsv(const Record& record,
                                            const ProcessModel& channels) {
  MLE_RETURN_IF_ERROR(CheckRecord(record, channels));
  MLE_ASSIGN_OR_RETURN(std::vector<RecordColumn> columns, ColumnsOf(channels));
  if (record.set_points.size() == 0) {
    std::erase_if(columns, [](const RecordColumn& column) {
      return column.kind == Kind::kSetPoint;
    });
  }
  std::string text;
  for (const RecordColumn& column : columns) {
    if (!text.empty()) text += ',';
    text += QuoteCsvField(column.name);
  }
  text += '\n';
  const TimeColumn times(record);
  for (int k = 0; k < record.samples(); ++k) {
    for (const RecordColumn& column : columns) {
      double value = 0.0;
      if (column.kind == Kind::kTime) value = times.At(k);
      if (column.kind == Kind::kOutput) {
        value = record.outputs(column.channel, k);
      }
      if (column.kind == Kind::kSetPoint) {
        value = record.set_points(column.channel, k);
      }
      if (column.kind == Kind::kInput) value = record.inputs(column.channel, k);
      if (column.kind != Kind::kTime) text += ',';
      if (std::isfinite(value)) AppendCsvNumber(value, text);
    }
    text += '\n';
  }
  return text;
}

absl::Status WriteRecordCsv(const std::string& path, const Record& record,
                            const ProcessModel& channels) {
  MLE_ASSIGN_OR_RETURN(const std::string text,
                       FormatRecordCsv(record, channels));
  return WriteFileAtomically(path, text);
}

}  // namespace mle
