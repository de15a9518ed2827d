// The query for a table and its columns. Internal to mle/database.
//
//   {.table = "plant.trend", .columns = {"TI101"}}, from 4 March on:
//   SELECT "time", "TI101" FROM "plant"."trend"
//   WHERE "time" >= timestamp '2024-03-03 00:00:00' ORDER BY "time"
//
// All names are quoted, so that none can be more than a name; columns are those
// that the table says it has. What lies more than a day outside of the range is
// not asked for; the importer cuts exactly, in the zone of the records.

#ifndef MLE_DATABASE_TABLE_QUERY_H_
#define MLE_DATABASE_TABLE_QUERY_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/database/database_options.h"
#include "mle/database/database_session.h"

namespace mle {

// "a.b" and "\"a.b\".c" as their parts. InvalidArgument for none, for empty
// ones, and for quotes that do not close.
absl::StatusOr<std::vector<std::string>> PartsOfTable(const std::string& table);

// A query with the begin and the end of the time range, a day before and after,
// in place of {begin} and {end}: "2024-03-03 00:00:00", UTC; the year 1 or 9999
// where there is no limit.
absl::StatusOr<std::string> WithLimits(const std::string& query,
                                       const HistorianOptions& import);

// InvalidArgument, with the nearest names, for a table that the database does
// not have and columns that the table does not have.
absl::StatusOr<std::string> TableQuery(const DatabaseOptions& database,
                                       const HistorianOptions& import,
                                       DatabaseSession& session);

}  // namespace mle

#endif  // MLE_DATABASE_TABLE_QUERY_H_
