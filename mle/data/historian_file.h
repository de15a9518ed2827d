// One file of a historian, opened: its form recognised, its header matched, its
// rows ready to be read. Internal to mle/data.

#ifndef MLE_DATA_HISTORIAN_FILE_H_
#define MLE_DATA_HISTORIAN_FILE_H_

#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/csv_rows.h"
#include "mle/data/historian.h"
#include "mle/data/record_clock.h"
#include "mle/data/record_rows.h"
#include "mle/model/process_model.h"

namespace mle {

class HistorianFile {
 public:
  // Dates count from `origin`, or from the first in the file. `clock` is the
  // one of this file.
  static absl::StatusOr<std::unique_ptr<HistorianFile>> Open(
      const HistorianSource& source, const ProcessModel& channels,
      const HistorianOptions& options, const ClockOptions& clock,
      std::optional<double> origin);

  RecordRows& rows() { return *rows_; }
  const RecordClock& clock() const { return clock_; }
  RecordClock& clock() { return clock_; }
  // Name, separator, decimal mark and ignored columns.
  const FileReport& report() const { return report_; }

 private:
  HistorianFile(std::unique_ptr<std::istream> in, RecordClock clock)
      : in_(std::move(in)), clock_(std::move(clock)) {}

  absl::Status SkipToHeader(const HistorianOptions& options);
  absl::Status Recognise(const ProcessModel& channels,
                         const HistorianOptions& options);

  std::unique_ptr<std::istream> in_;
  RecordClock clock_;
  std::unique_ptr<CsvRows> csv_;
  std::optional<RecordRows> rows_;
  FileReport report_;
  int header_line_ = 1;
};

// What a file begins with.
struct HistorianProbe {
  HistorianSource source;
  ClockOptions clock;
  std::string time_form;
  bool newest_first = false;
  bool has_dates = false;
  bool has_set_points = false;
  double origin = 0.0;        // seconds since the epoch of its earliest date
  double first_time = 0.0;    // the earliest, in the model's unit; 0 of dates
  std::vector<double> steps;  // of the first rows, those above 0
};

// InvalidArgument for a file without rows, and as of Open().
absl::StatusOr<HistorianProbe> ProbeHistorian(const HistorianSource& source,
                                              const ProcessModel& channels,
                                              const HistorianOptions& options,
                                              const ClockOptions& clock);

}  // namespace mle

#endif  // MLE_DATA_HISTORIAN_FILE_H_
