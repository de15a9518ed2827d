// A historian's archive: what it keeps of a record, and what an export of it at
// the times of the samples looks like. Each tag (an output or an input) goes
// through, in this order,
//
//   spikes: single samples that are off by a given amount;
//   exception reporting: a value is sent on where it differs from the one sent
//     last by more than `exception`, together with the value before it;
//   swinging-door compression: of what is sent on, a point is archived where
//     the line from the last archived point to the next one would miss a point
//     between them by more than `compression`;
//   the export: the archived points, joined by straight lines (or held, for a
//     step tag), at the times t_k − `clock_offset`: a clock that is ahead shows
//     a value later.
//
// Both tests pass a value anyway `max_interval` after the last. Before the
// first and after the last point the export holds. So a joined export is within
// 2 `exception` + `compression` of the samples that the clock asks for, lost
// samples (NaN) stay lost, and with all of these zero the record is what it
// was. (Bristol, Swinging door trending, ISA 1990; Hale and Sellars, Historical
// data recording for process computers, Chemical Engineering Progress 77,
// 1981.)

#ifndef SIM_ARCHIVE_H_
#define SIM_ARCHIVE_H_

#include <limits>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/data/record.h"

namespace mle::sim {

struct Spike {
  double time = 0.0;  // of the sample: the first one not before
  double size = 0.0;
};

struct TagOptions {
  int channel = 0;           // of the outputs, or of the inputs
  double exception = 0.0;    // ≥ 0, in the channel's unit
  double compression = 0.0;  // ≥ 0, in the channel's unit
  double max_interval = std::numeric_limits<double>::infinity();  // > 0
  double clock_offset = 0.0;
  bool step = false;
  std::vector<Spike> spikes = {};

  absl::Status Validate(int num_channels) const;
};

struct ArchiveOptions {
  std::vector<TagOptions> outputs;
  std::vector<TagOptions> inputs;

  absl::Status Validate(int num_outputs, int num_inputs) const;
};

// The points of a series that a tag archives, as increasing indices of samples;
// values that are NaN are left out.
std::vector<int> ArchivedSamples(const TagOptions& tag,
                                 const Eigen::RowVectorXd& series,
                                 double sample_time);

// Replaces the record by its export. For valid options.
void ExportFromArchive(const ArchiveOptions& options, Record& record);

}  // namespace mle::sim

#endif  // SIM_ARCHIVE_H_
