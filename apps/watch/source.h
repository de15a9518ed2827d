// Records of a controller as they lie in a folder or a database, and what of
// them is new.
//
// Files are told by path, size and time of change. Of new and changed files all
// days that they have rows of are looked at again, with the files that hold the
// time before. A file that cannot be read is left out, and said so.
//
// The rows of a database after the last day that was looked at are read, and
// those of the last Controller::overlap_days days up to it, for samples that
// came late or were corrected, with the rows before that act on these.

#ifndef APPS_WATCH_SOURCE_H_
#define APPS_WATCH_SOURCE_H_

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/data/historian.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

inline constexpr double kSecondsOfDay = 86400.0;

// Records whose times are seconds since 1970-01-01T00:00:00Z; the sample time
// stays in the model's unit.
struct DatedRecords {
  std::vector<Record> records;
  double seconds_per_unit = 1.0;

  double sample_seconds() const {
    return records.empty() ? 0.0
                           : records.front().sample_time * seconds_per_unit;
  }
  // Seconds since 1970 at sample k of a record.
  double TimeOf(const Record& record, int k) const {
    return record.start_time + k * sample_seconds();
  }
};

struct NewRecords {
  DatedRecords data;
  std::map<std::string, SeenFile> files;  // new or changed; none of a database
  // Seconds since 1970 that there are new rows of, or may be.
  double first = 0.0;
  double last = 0.0;
  std::vector<std::string> faults;  // whole sentences
};

// Seconds in the model's unit of time. InvalidArgument names a unit that tells
// no days.
absl::StatusOr<double> SecondsOf(const ProcessModel& model);

// How the controller's files are read.
absl::StatusOr<HistorianOptions> ImportOptionsOf(const Controller& controller,
                                                 const ProcessModel& model);

// Regular files in the folder whose names end in .csv, .txt or either with .gz,
// in order of their names. InvalidArgument where it cannot be read.
absl::StatusOr<std::map<std::string, SeenFile>> ListFiles(
    const std::string& folder);

// The records that are new since `watch`, with the records before them that act
// on them (three settling times of the model, and the rest of the day) and
// after them; nothing where nothing is new. Everything counts as new while the
// watch has no reference. Records without dates, a model whose unit of time is
// not known, and a database that cannot be reached are errors.
absl::StatusOr<std::optional<NewRecords>> ReadNew(const Controller& controller,
                                                  const ProcessModel& model,
                                                  const Watch& watch);

// The sources of the records between these seconds since 1970, a range that
// `options` then has too: files with rows in that time, or the database.
std::vector<std::string> SourcesBetween(const Controller& controller,
                                        const Watch& watch, double from,
                                        double to, HistorianOptions& options);

// Records cut into days, as batches of the watch.

// Days since 1970 with samples that are over: the records go on until their
// end.
std::vector<int> ClosedDays(const DatedRecords& data);

// The day with the `lead` samples before it, as far as there are any; what is
// missing is NaN. Without samples the record is empty.
WatchBatch DayOf(const DatedRecords& data, int day, int lead);

// The first 16 bytes of the SHA-256 of all samples.
std::string ChecksumOf(const WatchBatch& batch);

// "2024-02-29".
std::string NameOfDay(int day);

}  // namespace mle::watch

#endif  // APPS_WATCH_SOURCE_H_
