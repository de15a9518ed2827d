// The operations that differ between databases. Every one may throw what SOCI
// throws; DatabaseSession (database_session.h) turns that into a status.
// Internal to mle/database.

#ifndef MLE_DATABASE_SQL_BACKEND_H_
#define MLE_DATABASE_SQL_BACKEND_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mle/data/row_source.h"

namespace mle {

struct SqlColumn {
  std::string name;
  bool is_date = false;  // of a type of dates, not text or numbers
};

// Limits of a query; more is an error: a view need not end, and a value may be
// as long as memory.
struct SqlLimits {
  std::size_t max_value_bytes = std::size_t{1} << 20;  // > 0
  std::int64_t max_rows = 1'000'000'000;               // of a query
  int max_wait_s = 600;  // until the next rows have come; > 0
};

class SqlBackend {
 public:
  virtual ~SqlBackend() = default;

  // Begins to read the rows of a query; its columns. Ends what was read before.
  virtual std::vector<SqlColumn> Start(const std::string& query) = 0;
  // Adds the next rows, `most` or fewer; their number, 0 at the end.
  virtual int Read(int most, RowBlock& rows) = 0;
  // Names of the tables and views, for messages; empty: not known.
  virtual std::vector<std::string> Tables() { return {}; }
  // By what rows of a table are put in order of a column of times, both names
  // quoted; empty: as they stand.
  virtual std::string Order(const std::string& /*table*/,
                            const std::string& column) {
    return column;
  }
  // A name as SQL has it, whatever stands in it.
  virtual std::string Quote(const std::string& name) const;
  // Whether a column of another type has dates that are compared as text: the
  // year first, then month and day. Both names quoted.
  virtual bool HasTextDates(const std::string& /*table*/,
                            const std::string& /*column*/) {
    return false;
  }
  // "YYYY-MM-DD hh:mm:ss" in SQL, to be compared with dates; empty: not to be.
  virtual std::string DateLiteral(const std::string& /*date*/) const {
    return {};
  }
};

// Values as fields of a row, which stay in one line of a message: line breaks
// and tabs become blanks, other control characters are written as \x00.
void AddText(std::string_view value, RowBlock& rows);
// As AddText(); throws where the value has more bytes than `limits` allow.
void AddLimitedText(std::string_view value, const SqlLimits& limits,
                    RowBlock& rows);
void AddInteger(std::int64_t value, RowBlock& rows);
// With as many digits as make it the same number again.
void AddNumber(double value, RowBlock& rows);

// Sessions that only read, of what database_name.h calls a place.
std::unique_ptr<SqlBackend> OpenPostgresql(const std::string& uri,
                                           const SqlLimits& limits);
std::unique_ptr<SqlBackend> OpenSqlite(const std::string& path,
                                       const SqlLimits& limits);
// `user` and `password` may be empty.
std::unique_ptr<SqlBackend> OpenOdbc(const std::string& source,
                                     const std::string& user,
                                     const std::string& password,
                                     const SqlLimits& limits);

}  // namespace mle

#endif  // MLE_DATABASE_SQL_BACKEND_H_
