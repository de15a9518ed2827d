// The records a model is corrected from: imported, checked, and cut into
// windows around their set-point changes.
//
//   MLE_ASSIGN_OR_RETURN(const RecordData data,
//                        LoadRecords(paths, model, HistorianOptions(), {}));
//   CorrectFromData(model, data, …);

#ifndef MLE_MAINTAIN_RECORDS_H_
#define MLE_MAINTAIN_RECORDS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/channel_health.h"
#include "mle/data/historian.h"
#include "mle/data/import_options.h"
#include "mle/data/record.h"
#include "mle/data/set_point_windows.h"
#include "mle/data/time_names.h"
#include "mle/maintain/message.h"
#include "mle/model/process_model.h"

namespace mle {

// Of the examination for faults, before anything else (examine_records.h).
struct ExamineOptions {
  // Whether samples are marked and replaced; if not, what could be repaired
  // stays as it is.
  bool repair = true;
  // How messages write times; without a unit, in the model's.
  TimeNames times = {};
  // The columns of channels, for messages that say how a mapping is corrected.
  std::vector<TagMapping> tags = {};

  // At least 0; 0 takes one for each processor. Findings do not depend on it.
  int threads = 0;

  absl::Status Validate() const;
};

struct RecordOptions {
  // Tags that say when a loop or the controller was in use (modes.h); of files
  // and databases.
  std::vector<ModeTag> modes = {};
  // The examination that comes before anything else.
  ExamineOptions examination;
  WindowOptions windows;
  // Times of set-point changes as dates (2024-02-29 12:34, 29-Feb-24 12:34, …),
  // in addition to windows.change_times; of records that have dates. Without a
  // zone they are in that of the records.
  std::vector<std::string> change_dates = {};
  // A window that contains one of these times is not used: in the model's time
  // unit, or dates as above.
  std::vector<double> leave_out = {};
  std::vector<std::string> leave_out_dates = {};
  // Samples of windows that are used, ≥ 0: of longer records those windows that
  // are expected to inform most (informative_windows.h); 0: all.
  int most_samples = 20'000;
  // Samples of files and databases that are held in memory, ≥ 0: of longer
  // records those segments that are expected to inform most (record_scan.h);
  // 0: all.
  int most_samples_in_memory = 0;
  // Samples to be taken as bad: frozen segments and single samples far from
  // their neighbours.
  MarkOptions mark;

  absl::Status Validate() const;
};

struct RecordData {
  std::vector<Record> records;
  // The report on the files; for records in memory only the sample time and the
  // counts.
  HistorianReport report;
  // Records as they are, no operating point taken off.
  std::vector<SetPointWindow> windows;
  // Parts of records that are windows beyond RecordOptions::most_samples.
  struct UnusedPart {
    int source = 0;  // the record
    int first_sample = 0;
    int samples = 0;
  };
  std::vector<UnusedPart> unused;
  // Between the windows; if not, what happened there is left out.
  bool operated_as_usual = true;
  // The model's settling time, in samples.
  int lead = 0;
  // p: what is declared of the outputs; empty: nothing.
  std::vector<Sampling> sampling;
  HealthReport health;
  // Findings of the examination; those that block are obstacles, the others are
  // among the warnings (doubts and repairs) and notes.
  std::vector<Finding> findings;
  std::vector<Message> obstacles;  // what forbids a correction
  // p: outliers that the model found besides (outlier_search.h); empty: none
  // sought.
  std::vector<int> outliers_by_model;
  std::vector<Message> notes;     // what was found
  std::vector<Message> warnings;  // what weakens the result

  double sample_time() const { return report.sample_time; }
  // How times are written.
  TimeNames Times(const ProcessModel& model) const {
    return report.Times(model.time_unit());
  }
  // The windows as records. Each has a lead (Record::lead()) of the inputs
  // before it, from the last bad one on, `lead` samples at most; none where it
  // adjoins the window before.
  std::vector<Record> Records() const;
  // The records outside of the windows, the last of them, up to four times as
  // many samples as the windows have.
  std::vector<Record> AtRest() const;
};

double BeginOf(const SetPointWindow& window);
double EndOf(const SetPointWindow& window);

// Outputs that are not stationary before the change or at the end, in words.
std::vector<std::string> NonStationaryIn(const SetPointWindow& window,
                                         const ProcessModel& model);

// Records in memory: of the model's channels, not empty, all with one sample
// time. Windows are whole in their inputs: one with a gap there is cut to its
// longest part. No window at all is an error: nothing there can be learnt from;
// with obstacles the records are then windows as a whole.
absl::StatusOr<RecordData> PrepareRecords(std::vector<Record> records,
                                          const ProcessModel& model,
                                          const RecordOptions& options);

// The same of imported records, whose report gives times and channels.
absl::StatusOr<RecordData> PrepareRecords(HistorianImport imported,
                                          const ProcessModel& model,
                                          const RecordOptions& options);

// The same of records wherever they come from, with their modes.
absl::StatusOr<RecordData> ImportAndPrepare(const ImportOf& import,
                                            const ProcessModel& model,
                                            const HistorianOptions& importing,
                                            const RecordOptions& options);

// The same of sources of records, as RecordSources() (mle/database) makes them
// of files and databases. Errors name the source. `progress` is told what is
// read, and how much of it where that is known.
absl::StatusOr<RecordData> LoadSources(
    const std::vector<HistorianSource>& sources, const ProcessModel& model,
    const HistorianOptions& import, const RecordOptions& options,
    const ProgressCallback& progress = {});

// The same of a historian's files. Errors name the file.
absl::StatusOr<RecordData> LoadRecords(const std::vector<std::string>& paths,
                                       const ProcessModel& model,
                                       const HistorianOptions& import,
                                       const RecordOptions& options,
                                       const ProgressCallback& progress = {});

// Records that are windows already, as simulations make them: nothing is
// checked, marked or cut.
RecordData UseAsWindows(std::vector<Record> windows);

}  // namespace mle

#endif  // MLE_MAINTAIN_RECORDS_H_
