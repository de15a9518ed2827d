// Models as tables (CSV): lines of the head, each a key and its values, then a
// table with a header. Internal to mle/exchange.
//
//   name,Heated tank
//   time unit,min
//   input,steam,t/h
//   input,inflow,m3/h,disturbance
//   output,temperature,degC
//   time,temperature/steam,temperature/inflow
//   1,0.64,-0.05
//
// The header of the table is the first row that begins with "time", or has the
// fields "output", "input" and "gain". Fields are separated by the comma,
// semicolon or tab that occurs first in the file; where it is not the comma,
// numbers may have a decimal comma. Blanks around fields, empty fields at the
// end of a row and rows of empty fields do not count; keys and the names of
// columns may have any case, and underlines for blanks.

#ifndef MLE_EXCHANGE_MODEL_TABLE_H_
#define MLE_EXCHANGE_MODEL_TABLE_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"

namespace mle {

struct TableLine {
  int line = 0;                     // of the file, from 1
  std::vector<std::string> fields;  // without blanks around them
};

struct ModelTable {
  std::string source;  // the file's name
  char separator = ',';
  std::string name;  // of the process; that of the file where no line has it
  std::string time_unit;
  std::vector<InputChannel> inputs;    // in the order of their lines; none
  std::vector<OutputChannel> outputs;  // where the table is to name them
  std::vector<TableLine> others;       // other lines of the head: key, values
  TableLine header;
  std::vector<TableLine> rows;  // each with a field for each of the header

  // InvalidArgument: "FILE: line 3: what", "FILE: line 3, column 2: what".
  absl::Status Fault(int line, std::string_view what) const;
  absl::Status Fault(const TableLine& row, int column,
                     std::string_view what) const;

  // A finite number.
  absl::StatusOr<double> Number(const TableLine& row, int column) const;

  // A model of zero elements; the channels of the head, or, where it has none,
  // those of `pairs` (output, input) in the order in which they appear.
  struct PairOfNames {
    std::string output;
    std::string input;
  };
  absl::StatusOr<ProcessModel> Channels(
      const std::vector<PairOfNames>& pairs) const;
};

absl::StatusOr<ModelTable> ReadModelTable(std::string_view text,
                                          std::string_view source);

// The lines of the head for name, unit of time, inputs and outputs.
std::string FormatTableHead(const ProcessModel& channels);

// With the fewest digits that read back as the same double.
std::string TableNumber(double number);

}  // namespace mle

#endif  // MLE_EXCHANGE_MODEL_TABLE_H_
