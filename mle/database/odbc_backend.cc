// ODBC: whatever database has a driver for it.
//
// Numbers are taken as numbers, dates and all else as the text that the driver
// makes of them, which has the fractions of seconds that SOCI's dates lack.

#include <soci/odbc/soci-odbc.h>
#include <soci/soci.h>

#include <array>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/database/sql_backend.h"

namespace mle {
namespace {

// A value in braces where it needs them, which not all drivers know; in them
// only the closing one must be doubled.
std::string Braced(const std::string& value) {
  if (value.find_first_of("[]{}(),;?*=!@ ") == std::string::npos) return value;
  std::string braced = "{";
  for (const char c : value) {
    if (c == '}') braced += '}';
    braced += c;
  }
  return braced + '}';
}

soci::connection_parameters Parameters(const std::string& source,
                                       const std::string& user,
                                       const std::string& password) {
  const bool is_name = source.find('=') == std::string::npos;
  std::string text = absl::StrCat(is_name ? "DSN=" : "", source);
  if (!user.empty()) absl::StrAppend(&text, ";UID=", Braced(user));
  if (!password.empty()) absl::StrAppend(&text, ";PWD=", Braced(password));
  soci::connection_parameters parameters(soci::odbc, text);
  // No windows of a driver.
  parameters.set_option(soci::odbc_option_driver_complete,
                        absl::StrCat(SQL_DRIVER_NOPROMPT));
  return parameters;
}

// SOCI takes what follows a colon outside of quotes for a parameter.
void CheckColons(const std::string& query) {
  bool is_quoted = false;
  for (const char c : query) {
    if (c == '\'') is_quoted = !is_quoted;
    if (c == ':' && !is_quoted) {
      throw soci::soci_error(
          "a colon outside of single quotes cannot be passed on by ODBC; write "
          "CAST(x AS type) for x::type, and give names with colons others in a "
          "view");
    }
  }
}

class OdbcBackend : public SqlBackend {
 public:
  OdbcBackend(const std::string& source, const std::string& user,
              const std::string& password, const SqlLimits& limits)
      : limits_(limits),
        session_(std::make_unique<soci::session>(
            Parameters(source, user, password))) {
    auto& backend =
        *static_cast<soci::odbc_session_backend*>(session_->get_backend());
    // Drivers may refuse it once they are connected; nothing is committed.
    SQLSetConnectAttr(backend.hdbc_, SQL_ATTR_ACCESS_MODE,
                      reinterpret_cast<SQLPOINTER>(SQL_MODE_READ_ONLY), 0);
    std::array<SQLCHAR, 8> quote = {};
    SQLSMALLINT size = 0;
    if (SQL_SUCCEEDED(SQLGetInfo(backend.hdbc_, SQL_IDENTIFIER_QUOTE_CHAR,
                                 quote.data(), quote.size(), &size))) {
      quote_ = std::string(reinterpret_cast<const char*>(quote.data()));
    }
    session_->begin();
    if (backend.get_database_product() ==
        soci::odbc_session_backend::prod_postgresql) {
      *session_ << "SET TIME ZONE 'UTC'";
    }
  }

  ~OdbcBackend() override;
  OdbcBackend(const OdbcBackend&) = delete;
  OdbcBackend& operator=(const OdbcBackend&) = delete;

  std::vector<SqlColumn> Start(const std::string& query) override;
  int Read(int most, RowBlock& rows) override;
  std::string Quote(const std::string& name) const override;
  std::string DateLiteral(const std::string& date) const override {
    return absl::StrCat("{ts '", date, "'}");
  }

 private:
  // Where SOCI puts a value.
  struct Cell {
    soci::data_type type = soci::dt_string;
    soci::indicator indicator = soci::i_null;
    double number = 0.0;
    long long integer = 0;
    std::string text;
  };

  void Define(Cell& cell);

  const SqlLimits limits_;
  std::unique_ptr<soci::session> session_;
  std::string quote_ = "\"";
  std::deque<Cell> cells_;  // which do not move
  std::optional<soci::statement> statement_;
};

OdbcBackend::~OdbcBackend() {
  statement_.reset();
  try {
    session_->rollback();
  } catch (const std::exception&) {
    // The connection has gone, and SOCI's destructor would throw: the session
    // is left behind.
    static_cast<void>(session_.release());
  }
}

std::string OdbcBackend::Quote(const std::string& name) const {
  if (quote_.size() != 1 || quote_ == " ") {
    throw soci::soci_error(
        "its ODBC driver does not quote names; write a query in place of a "
        "table");
  }
  std::string quoted = quote_;
  for (const char c : name) {
    if (c == quote_[0]) quoted += c;
    quoted += c;
  }
  return quoted + quote_;
}

void OdbcBackend::Define(Cell& cell) {
  switch (cell.type) {
    case soci::dt_double:
      statement_->exchange(soci::into(cell.number, cell.indicator));
      return;
    case soci::dt_integer:
    case soci::dt_long_long:
      statement_->exchange(soci::into(cell.integer, cell.indicator));
      return;
    default:
      statement_->exchange(soci::into(cell.text, cell.indicator));
  }
}

std::vector<SqlColumn> OdbcBackend::Start(const std::string& query) {
  CheckColons(query);
  statement_.emplace(*session_);
  cells_.clear();
  statement_->alloc();
  statement_->prepare(query);
  // Drivers need not know it.
  SQLSetStmtAttr(
      static_cast<soci::odbc_statement_backend*>(statement_->get_backend())
          ->hstmt_,
      SQL_ATTR_QUERY_TIMEOUT,
      reinterpret_cast<SQLPOINTER>(
          static_cast<std::uintptr_t>(limits_.max_wait_s)),
      0);
  std::vector<SqlColumn> columns;
  const int size = statement_->get_backend()->prepare_for_describe();
  for (int c = 0; c < size; ++c) {
    SqlColumn& column = columns.emplace_back();
    Cell& cell = cells_.emplace_back();
    statement_->get_backend()->describe_column(c + 1, cell.type, column.name);
    column.is_date = cell.type == soci::dt_date;
    Define(cell);
  }
  statement_->define_and_bind();
  statement_->execute(false);
  return columns;
}

int OdbcBackend::Read(int most, RowBlock& rows) {
  int count = 0;
  while (count < most && statement_->fetch()) {
    for (const Cell& cell : cells_) {
      if (cell.indicator == soci::i_null) {
        rows.Add("");
      } else if (cell.type == soci::dt_double) {
        AddNumber(cell.number, rows);
      } else if (cell.type == soci::dt_integer ||
                 cell.type == soci::dt_long_long) {
        AddInteger(cell.integer, rows);
      } else {
        AddLimitedText(cell.text, limits_, rows);
      }
    }
    ++count;
  }
  return count;
}

}  // namespace

std::unique_ptr<SqlBackend> OpenOdbc(const std::string& source,
                                     const std::string& user,
                                     const std::string& password,
                                     const SqlLimits& limits) {
  return std::make_unique<OdbcBackend>(source, user, password, limits);
}

}  // namespace mle
