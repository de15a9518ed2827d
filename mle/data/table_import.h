// Tables in memory, as of a data frame, made into records by the rules of
// historian.h: columns are matched by name and converted, rows are checked,
// resampled and their gaps bridged. The same samples in a file and in a table
// give the same records.
//
//   const Table table = {.name = "data frame",
//                        .times = seconds,          // N since the epoch
//                        .has_dates = true,
//                        .columns = {{"reflux", values.data()}, …}};
//   MLE_ASSIGN_OR_RETURN(const HistorianImport import,
//                        ImportTables({table}, model, HistorianOptions()));

#ifndef MLE_DATA_TABLE_IMPORT_H_
#define MLE_DATA_TABLE_IMPORT_H_

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/model/process_model.h"

namespace mle {

// N samples, NaN where one is bad, `stride` values apart. A null pointer stands
// for what holds no numbers: an error for a column that is needed.
struct TableColumn {
  std::string name;
  const double* values = nullptr;
  std::ptrdiff_t stride = 1;
  std::string holds = "no numbers";  // in place of them, for the message
};

// Refers to memory of the caller.
struct Table {
  std::string name;               // in messages and reports
  std::span<const double> times;  // N, increasing
  // Times are seconds since 1970-01-01T00:00:00Z; if not, in the model's unit.
  bool has_dates = false;
  std::string time_zone = {};  // for dates in messages, as of the IANA
  std::vector<TableColumn> columns;
};

// Tables in order of time; all with dates, or none. Of `options` those of text
// and of clocks are not used. InvalidArgument, naming table, row and column,
// for times that do not increase, a missing, unknown or repeated column, one
// without numbers, infinite values, and as of ImportHistorian().
absl::StatusOr<HistorianImport> ImportTables(const std::vector<Table>& tables,
                                             const ProcessModel& channels,
                                             const HistorianOptions& options);

}  // namespace mle

#endif  // MLE_DATA_TABLE_IMPORT_H_
