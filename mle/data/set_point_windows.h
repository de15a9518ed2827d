// Windows around the changes of set points: the data of a correction.
//
// Each change gets a window of `before` and `after` around it. Changes that
// follow before the plant has settled share one window; windows do not overlap;
// where a record ends or another window begins, they are clipped. Parts that
// should be at rest (before the change, and once the plant has settled) are
// tested for drift and disturbances.
//
//   MLE_ASSIGN_OR_RETURN(const WindowSet set,
//                        FindWindows(import.records, model, WindowOptions()));
//   CorrectByOutputError(model, set.Records(), …);

#ifndef MLE_DATA_SET_POINT_WINDOWS_H_
#define MLE_DATA_SET_POINT_WINDOWS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/data/time_names.h"
#include "mle/model/process_model.h"

namespace mle {

// A part of an output in which operation should be steady, less the model's
// response to the inputs, with which control compensates disturbances of the
// output.
struct SteadyOperation {
  enum class Verdict {
    kUnknown,    // too short to say
    kSteady,     // noise about a constant
    kDrifting,   // a trend
    kDisturbed,  // a step
  };
  Verdict verdict = Verdict::kUnknown;
  double noise = 0.0;       // standard deviation of its white part
  double size = 0.0;        // of the trend over the part, or of the step
  double deviations = 0.0;  // `size` over its standard error in white noise
  double time = 0.0;        // of the step
};

// Times in the model's unit.
// A segment in which an operator moves inputs, as a tag of modes says.
struct ByHand {
  static constexpr int kAll = -1;
  static constexpr int kNone = -2;
  double from = 0.0;  // the first and the last time of it
  double to = 0.0;
  int input = kAll;   // whose moves are changes
  int output = kAll;  // whose set point says nothing
};

struct WindowOptions {
  // Kept before a change and after the last that shares the window, ≥ 0; 0:
  // the model's settling time before (SettlingTime()), 1.5 times it after, and
  // 20 samples at least.
  double before = 0.0;
  double after = 0.0;
  // Changes share a window if the next follows within this, ≥ 0; 0: the model's
  // settling time, or `after` where that is shorter, and 20 samples at least.
  double join_within = 0.0;
  // Changes of set point up to this size, ≥ 0, are ignored (in the unit of each
  // output: the rounding of the set points, say).
  double min_change = 0.0;
  // Times of changes, for records without set points. If not empty, set points
  // are not used. In order of time.
  std::vector<double> change_times = {};
  // Moves of inputs in these count as changes, too, those of set points do not.
  std::vector<ByHand> by_hand = {};
  // Standard deviations that a trend or a step in steady operation must have to
  // be reported, > 0. At 5 white noise is reported in less than 1 of 10⁴ parts.
  double report_threshold = 5.0;
  // And standard deviations of the noise that its size must have, ≥ 0.
  double report_size = 1.0;
  // How warnings write times.
  TimeNames times = {};

  absl::Status Validate() const;
};

struct SetPointWindow {
  Record record;
  int source = 0;        // the record that it was cut from,
  int first_sample = 0;  // and from which sample on
  // In it; samples count from the window's first. `output` is −1 for changes
  // that are given by their time.
  std::vector<SetPointChange> changes;
  // The window is shorter than requested: the record or another window ends it.
  bool clipped_before = false;
  bool clipped_after = false;
  std::vector<SteadyOperation> before;  // p: before the change
  std::vector<SteadyOperation> after;   // p: once settled
};

// `after` begins with the sample after the last one of `before`.
bool Adjoin(const SetPointWindow& before, const SetPointWindow& after);

struct WindowSet {
  std::vector<SetPointWindow> windows;
  // As requested.
  double before = 0.0;
  double after = 0.0;
  int changes = 0;  // found, all together
  // Losses and their reasons: windows dropped, one change only, overlaps.
  std::vector<std::string> warnings;

  std::vector<Record> Records() const;
};

// The changes of set points of each record, those up to `min_change` left out;
// or those at given times (each in the record that holds it; `output` −1).
// To those of set points come moves by hand (`output` −1), where segments are
// given. Where no set point changes in any record, the moves of inputs
// (`output` −1) of each record whose inputs rest at nine samples of ten: steps
// by hand.
std::vector<std::vector<SetPointChange>> FindChanges(
    const std::vector<Record>& records, const WindowOptions& options);

// In order of the records and of time. Without any change there are no
// windows, and a warning. InvalidArgument for options, or records that are
// not valid or not of these channels.
absl::StatusOr<WindowSet> FindWindows(const std::vector<Record>& records,
                                      const ProcessModel& model,
                                      const WindowOptions& options);

}  // namespace mle

#endif  // MLE_DATA_SET_POINT_WINDOWS_H_
