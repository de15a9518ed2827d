// Records cut into days, as batches of the watch.

#ifndef APPS_WATCH_DAYS_H_
#define APPS_WATCH_DAYS_H_

#include <string>
#include <vector>

#include "apps/watch/source.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {

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

#endif  // APPS_WATCH_DAYS_H_
