// One file for each tag, or for some: joined by their times into a long table.
// Internal to mle/data.
//
//   TI101.PV.csv: Timestamp,Value      time,tag,value
//   FC7.csv: time,FC7.OP          →    2024-03-04 06:00,TI101.PV,71.3
//                                      2024-03-04 06:00,FC7.OP,12

#ifndef MLE_DATA_JOINED_FILES_H_
#define MLE_DATA_JOINED_FILES_H_

#include <optional>
#include <string>
#include <vector>

#include "mle/data/historian.h"
#include "mle/data/historian_file.h"
#include "mle/model/process_model.h"

namespace mle {

// The tags of a file: the names of its columns of samples; or the name of the
// file, where there is one column and it has the usual name of any value, or
// where the file's name is `wanted` (folded) and the column's is not.
std::vector<std::string> TagsOf(const HistorianSource& source,
                                const HistorianColumns& columns,
                                const std::vector<std::string>& wanted);

// The names that columns of these channels have, folded.
std::vector<std::string> WantedTags(const ProcessModel& channels,
                                    const ColumnOptions& options);

struct JoinedFiles {
  HistorianSource source;
  HistorianOptions options;  // by which it is read
};

// Nothing where files do not have tags of their own: each has the same, or one
// is not understood.
std::optional<JoinedFiles> JoinFiles(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options);

}  // namespace mle

#endif  // MLE_DATA_JOINED_FILES_H_
