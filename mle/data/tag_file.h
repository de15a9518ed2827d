// Tags and their channels as a file, to be written once for a plant:
//
//   tag,channel,scale,offset,unit,unit in the file
//   TI101.PV,temperature,0.5555555556,-17.77777778,degC,degF
//   TIC101.SP,temperature_setpoint,0.5555555556,-17.77777778,degC,degF
//   FC7.OP,steam,,,,
//   XI9,,,,,
//
// channel = scale × column + offset; empty: 1 and 0. A row without a channel is
// a tag that is not used: its column is ignored. `unit`, if it is not empty, is
// that of the channel after the conversion, and must be the one of the process
// model; another unit in the file needs a scale or an offset. Further columns,
// period, held (yes), late_by, average and stamp (start, end), declare the
// sampling of an input or output (process_model.h), in the model's time unit.
//
// ProposeTags() makes such a table of the columns of files, to be checked.

#ifndef MLE_DATA_TAG_FILE_H_
#define MLE_DATA_TAG_FILE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/data/record_columns.h"
#include "mle/model/process_model.h"

namespace mle {

struct TagTable {
  std::vector<TagMapping> tags;     // the rows with a channel
  std::vector<std::string> unused;  // the tags of the others
};

// InvalidArgument lists all that is wrong, with the lines: unknown channels
// (with the nearest names, or those of the model), channels and tags that stand
// twice, numbers that cannot be read, scales of 0, other units.
absl::StatusOr<TagTable> ParseTagFile(const std::string& source,
                                      const std::string& text,
                                      const ProcessModel& channels);
absl::StatusOr<TagTable> ReadTagFile(const std::string& path,
                                     const ProcessModel& channels);

struct TagProposal {
  std::string tag;
  std::string channel;     // empty: none is near
  std::string unit;        // of the channel
  std::string found_unit;  // in a row of units below the header
};

// A proposal for each column of the files but times and qualities: the channel
// of that name, or the one whose name is nearest. No channel is proposed twice.
absl::StatusOr<std::vector<TagProposal>> ProposeTags(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options);

// As a file that ReadTagFile() reads.
std::string FormatTagFile(const std::vector<TagProposal>& proposals);

}  // namespace mle

#endif  // MLE_DATA_TAG_FILE_H_
