// The records a model is corrected from: imported, checked, and cut into
// windows around their set-point changes.
//
//   MLE_ASSIGN_OR_RETURN(const RecordData data,
//                        LoadRecords(paths, model, options));
//   CorrectStructure(model, data.Records(), …);

#ifndef APPS_CORRECT_RECORDS_H_
#define APPS_CORRECT_RECORDS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/channel_health.h"
#include "mle/data/historian.h"
#include "mle/data/record.h"
#include "mle/data/set_point_windows.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle::correct {

struct RecordOptions {
  HistorianOptions import;
  WindowOptions windows;
  // What is taken as bad: frozen stretches and single samples far from their
  // neighbours.
  MarkOptions mark;
};

// A file as it was read.
struct DataFile {
  std::string path;
  std::string sha256;  // of its bytes, hexadecimal
  std::int64_t bytes = 0;
};

struct RecordData {
  std::vector<DataFile> files;
  std::vector<Record> records;
  HistorianReport report;
  // Records as they are, no operating point taken off.
  std::vector<SetPointWindow> windows;
  HealthReport health;
  // p: outliers that the model found besides (MarkOutliersByModel()).
  std::vector<int> outliers_by_model;
  std::vector<std::string> notes;     // what was found
  std::vector<std::string> warnings;  // what weakens the result

  double sample_time() const { return report.sample_time; }
  std::vector<Record> Records() const;  // of the windows
};

double BeginOf(const SetPointWindow& window);
double EndOf(const SetPointWindow& window);

// Outputs that are not at rest before the change or at the end, in words.
std::vector<std::string> UnrestIn(const SetPointWindow& window,
                                  const ProcessModel& model);

// Errors name the file and, where there is one, the flag that would help.
// Windows are whole in their inputs: one with a gap there is cut to its longest
// part. No window at all is an error: nothing there can be learnt from.
absl::StatusOr<RecordData> LoadRecords(const std::vector<std::string>& paths,
                                       const ProcessModel& model,
                                       const RecordOptions& options);

// Neighbours do not find every outlier of a burst, the model does
// (output_reconstruction.h): marks as bad what it finds in the windows, and
// says how many there are.
absl::Status MarkOutliersByModel(const ProcessModel& model,
                                 const StructuredOptions& structured,
                                 RecordData& data);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RECORDS_H_
