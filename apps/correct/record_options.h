// The options of mle_correct that say how records are read and cut.

#ifndef APPS_CORRECT_RECORD_OPTIONS_H_
#define APPS_CORRECT_RECORD_OPTIONS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "mle/database/database_options.h"
#include "mle/maintain/records.h"

namespace mle::correct {

// Options of databases: query, table and columns.
std::vector<Option> OptionsOf(DatabaseOptions& database);

// `tags` are the texts TAG=CHANNEL…, `tag_file` the path of a file of tags.
std::vector<Option> OptionsOf(HistorianOptions& import,
                              std::vector<std::string>& tags,
                              std::string* tag_file);

std::vector<Option> OptionsOf(RecordOptions& options);

// The tags' columns, of both. InvalidArgument names the flag and what it
// expects.
absl::Status ParseTags(const std::vector<std::string>& tags,
                       const std::string& tag_file, const ProcessModel& model,
                       ColumnOptions& columns);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RECORD_OPTIONS_H_
