// Records from files and databases, for the one import of historian.h:
//
//   march.csv                      a file, or - for standard input
//   postgresql://USER@HOST/NAME    PostgreSQL, a URI as libpq has it
//   sqlite:FILE                    SQLite
//   odbc:NAME                      ODBC, a data source of odbc.ini
//
//   MLE_ASSIGN_OR_RETURN(
//       const std::vector<HistorianSource> sources,
//       RecordSources({"postgresql:///plant"}, {.table = "trend"}, import));
//   MLE_ASSIGN_OR_RETURN(const HistorianImport imported,
//                        ImportHistorianSources(sources, model, import));
//
// A database is opened for reading only, when a source is first opened, and
// closed with the last copy of its source; all that is read of it is of one
// moment where the database can do that (PostgreSQL, SQLite). Rows are taken in
// blocks, so that no copy of them is held.
//
// Passwords are never part of a name: they are in the environment (PGPASSWORD,
// PGPASSFILE, PGSERVICE; MLE_ODBC_USER and MLE_ODBC_PASSWORD), in a file
// (~/.pgpass, ~/.pg_service.conf, odbc.ini), or asked for.

#ifndef MLE_DATABASE_RECORD_SOURCES_H_
#define MLE_DATABASE_RECORD_SOURCES_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/database/database_options.h"

namespace mle {

// Whether `name` is that of a database, not of a file.
bool IsDatabase(std::string_view name);

// One for each of `names`. Of `import` the column of times and the time range
// are used; the importer takes the rest. InvalidArgument, naming the option,
// for a password in a name, a kind of database that is not known, and as of
// DatabaseOptions::Validate(). Errors of a database come when a source is
// opened or read, and name database, query or table, and row; they never have a
// password.
absl::StatusOr<std::vector<HistorianSource>> RecordSources(
    const std::vector<std::string>& names, const DatabaseOptions& database,
    const HistorianOptions& import);

}  // namespace mle

#endif  // MLE_DATABASE_RECORD_SOURCES_H_
