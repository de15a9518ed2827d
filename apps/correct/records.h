// The records a model is corrected from: read, checked, and cut into windows
// around their set-point changes.
//
//   MLE_ASSIGN_OR_RETURN(const RecordData data,
//                        LoadRecords(paths, model, options));
//   CorrectStructure(model, data.Windows(), …);

#ifndef APPS_CORRECT_RECORDS_H_
#define APPS_CORRECT_RECORDS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/report/table.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle::correct {

// Times in the model's time unit.
struct RecordOptions {
  // Kept before the first and after the last set-point change of a window, ≥ 0.
  // 0: the model's settling time.
  double window_before = 0.0;
  double window_after = 0.0;
  // Samples in a row of an input that may be lost; their value before is held.
  int longest_bridge = 10;
  // What a historian writes for a bad sample, beside nothing and NaN.
  std::vector<std::string> bad_values;
};

// A file as it was read.
struct Source {
  std::string path;
  std::string sha256;  // of its bytes, hexadecimal
  std::int64_t bytes = 0;
  Record record;
};

// A part of a source in which set points change.
struct Window {
  Record record;
  int source = 0;
  // Their samples count from the start of the window.
  std::vector<SetPointChange> changes;

  double begin() const { return record.time(0); }
  double end() const { return record.time(record.samples() - 1); }
};

struct RecordData {
  std::vector<Source> sources;
  std::vector<Window> windows;
  std::vector<std::string> notes;     // what was found
  std::vector<std::string> warnings;  // what weakens the result

  double sample_time() const { return sources.front().record.sample_time; }
  std::vector<Record> Records() const;  // of the windows
};

// max over the elements of L + 5 T of its slowest mode: after it a step
// response is within 1 % of its end.
double SettlingTime(const ProcessModel& model);

// The files hold the model's channels, with the same sample time. Errors name
// the file and, where there is one, the flag that would help. A record without
// set-point changes is an error: nothing there can be learnt from.
absl::StatusOr<RecordData> LoadRecords(const std::vector<std::string>& paths,
                                       const ProcessModel& model,
                                       const RecordOptions& options);

// A row for each source, for each channel over all sources, for each window.
report::Table SourceTable(const RecordData& data, const ProcessModel& model);
report::Table ChannelTable(const RecordData& data, const ProcessModel& model);
report::Table WindowTable(const RecordData& data, const ProcessModel& model);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RECORDS_H_
