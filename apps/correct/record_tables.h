// Tables of what the records hold.

#ifndef APPS_CORRECT_RECORD_TABLES_H_
#define APPS_CORRECT_RECORD_TABLES_H_

#include <string>

#include "apps/report/table.h"
#include "mle/model/process_model.h"

namespace mle::correct {

report::Table FileTable(const RecordData& data,
                        const std::vector<DataFile>& files,
                        const ProcessModel& model);
// A row for each channel over all records.
report::Table ChannelTable(const RecordData& data, const ProcessModel& model);
report::Table WindowTable(const RecordData& data, const ProcessModel& model);

// The unit of times in tables: the model's, the zone of dates, or "as recorded"
// where dates have no zone.
std::string TimeUnit(const RecordData& data, const ProcessModel& model);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RECORD_TABLES_H_
