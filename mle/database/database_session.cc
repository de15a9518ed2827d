#include "mle/database/database_session.h"

#include <soci/soci.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <exception>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "mle/base/absl_view.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// A shorter one would be found in many words.
constexpr std::size_t kShortestSecret = 4;

std::string FromEnvironment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Removes the text that SOCI puts before that of the database.
std::string_view WithoutPreamble(std::string_view text) {
  for (const std::string_view preamble :
       {"Cannot establish connection to the database.", "Cannot execute query.",
        "Cannot prepare statement.", "Fatal error.",
        "sqlite3_statement_backend::prepare: ",
        "sqlite3_statement_backend::loadOne: ", "Error "}) {
    while (!text.empty() && absl::ascii_isspace(text.front())) {
      text.remove_prefix(1);
    }
    if (text.starts_with(preamble)) text.remove_prefix(preamble.size());
  }
  return text;
}

// One line; without the marks that point into a statement.
std::string OneLine(std::string_view text) {
  const std::string_view body = WithoutPreamble(text);
  std::string line;
  for (const absl::string_view part : absl::StrSplit(AbslView(body), '\n')) {
    const absl::string_view words = absl::StripAsciiWhitespace(part);
    if (absl::StartsWith(words, "LINE ")) continue;
    if (words.find_first_not_of("^ ") == absl::string_view::npos) continue;
    absl::StrAppend(&line, line.empty() ? "" : "; ", words);
  }
  return line;
}

absl::StatusCode CodeOf(const soci::soci_error& error) {
  switch (error.get_error_category()) {
    case soci::soci_error::connection_error:
      return absl::StatusCode::kUnavailable;
    case soci::soci_error::no_privilege:
      return absl::StatusCode::kPermissionDenied;
    default:
      return absl::StatusCode::kInvalidArgument;
  }
}

// Whether libpq was asked for a password and found none.
bool WantsPassword(const absl::Status& status) {
  return absl::StrContains(status.message(), "no password supplied");
}

}  // namespace

void AddText(std::string_view value, RowBlock& rows) {
  const auto is_control = [](char c) { return absl::ascii_iscntrl(c); };
  if (std::none_of(value.begin(), value.end(), is_control)) {
    rows.Add(value);
    return;
  }
  std::string clean;
  for (const char c : value) {
    if (c == '\n' || c == '\r' || c == '\t') {
      clean += ' ';
    } else if (is_control(c)) {
      absl::StrAppend(
          &clean, "\\x",
          absl::Hex(static_cast<unsigned char>(c), absl::kZeroPad2));
    } else {
      clean += c;
    }
  }
  rows.Add(clean);
}

void AddLimitedText(std::string_view value, const SqlLimits& limits,
                    RowBlock& rows) {
  if (value.size() > limits.max_value_bytes) {
    throw soci::soci_error(absl::StrCat("a value is too big: ", value.size(),
                                        " bytes, at most ",
                                        limits.max_value_bytes));
  }
  AddText(value, rows);
}

void AddInteger(std::int64_t value, RowBlock& rows) {
  rows.Add(std::to_string(value));
}

void AddNumber(double value, RowBlock& rows) {
  std::array<char, 32> digits;
  char* const end =
      std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  rows.Add({digits.data(), static_cast<std::size_t>(end - digits.data())});
}

std::string SqlBackend::Quote(const std::string& name) const {
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

absl::Status DatabaseSession::Guard(const std::function<void()>& call) const {
  absl::StatusCode code = absl::StatusCode::kInvalidArgument;
  std::string text;
  try {
    call();
    return absl::OkStatus();
  } catch (const soci::soci_error& error) {
    code = CodeOf(error);
    text = error.get_error_message();
  } catch (const std::exception& error) {
    text = error.what();
  }
  text = OneLine(text);
  for (const std::string& secret : secrets_) {
    if (secret.size() < kShortestSecret) continue;
    text = absl::StrReplaceAll(text, {{secret, "****"}});
  }
  return absl::Status(code, text);
}

absl::Status DatabaseSession::Open(const DatabaseName& name,
                                   const std::string& password) {
  switch (name.kind) {
    case DatabaseKind::kPostgresql: {
      MLE_ASSIGN_OR_RETURN(const std::string uri,
                           PostgresqlParameters(name.place, password));
      return Guard([&] { backend_ = OpenPostgresql(uri, limits_); });
    }
    case DatabaseKind::kSqlite:
      return Guard([&] { backend_ = OpenSqlite(name.place, limits_); });
    case DatabaseKind::kOdbc:
      return Guard([&] {
        backend_ = OpenOdbc(name.place, FromEnvironment("MLE_ODBC_USER"),
                            FromEnvironment("MLE_ODBC_PASSWORD"), limits_);
      });
  }
  return absl::InternalError("a kind of database that is not known");
}

absl::StatusOr<std::unique_ptr<DatabaseSession>> DatabaseSession::Connect(
    const DatabaseName& name, const SqlLimits& limits, const AskPassword& ask) {
  std::unique_ptr<DatabaseSession> session(new DatabaseSession);
  session->limits_ = limits;
  session->secrets_ = {FromEnvironment("PGPASSWORD"),
                       FromEnvironment("MLE_ODBC_PASSWORD")};
  absl::Status status = session->Open(name, "");
  if (WantsPassword(status) && name.kind == DatabaseKind::kPostgresql && ask) {
    if (std::optional<std::string> password =
            ask(absl::StrCat("Password of ", name.text, ": "))) {
      session->secrets_.push_back(*password);
      status = session->Open(name, *password);
    }
  }
  if (status.ok()) return session;
  if (WantsPassword(status)) {
    return absl::PermissionDeniedError(absl::StrCat(
        status.message(),
        "; set PGPASSWORD in the environment, or have it in ~/.pgpass"));
  }
  if (status.code() == absl::StatusCode::kInvalidArgument) {
    // SOCI does not tell why it could not connect.
    return absl::UnavailableError(
        absl::StrCat("cannot be opened: ", status.message()));
  }
  return status;
}

absl::StatusOr<std::vector<SqlColumn>> DatabaseSession::Start(
    const std::string& query) {
  std::vector<SqlColumn> columns;
  rows_ = 0;
  MLE_RETURN_IF_ERROR(Guard([&] { columns = backend_->Start(query); }));
  return columns;
}

absl::StatusOr<int> DatabaseSession::Read(int most, RowBlock& rows) {
  int count = 0;
  MLE_RETURN_IF_ERROR(Guard([&] { count = backend_->Read(most, rows); }));
  rows_ += count;
  if (rows_ <= limits_.max_rows) return count;
  return absl::ResourceExhaustedError(
      absl::StrCat("more than ", limits_.max_rows,
                   " rows are not read: does its view or query end?"));
}

std::vector<std::string> DatabaseSession::Tables() {
  std::vector<std::string> tables;
  const absl::Status status = Guard([&] { tables = backend_->Tables(); });
  return status.ok() ? tables : std::vector<std::string>();
}

absl::StatusOr<std::string> DatabaseSession::Order(const std::string& table,
                                                   const std::string& column) {
  std::string order;
  MLE_RETURN_IF_ERROR(Guard([&] { order = backend_->Order(table, column); }));
  return order;
}

absl::StatusOr<bool> DatabaseSession::HasTextDates(const std::string& table,
                                                   const std::string& column) {
  bool has = false;
  MLE_RETURN_IF_ERROR(
      Guard([&] { has = backend_->HasTextDates(table, column); }));
  return has;
}

absl::StatusOr<std::string> DatabaseSession::Quote(
    const std::string& name) const {
  std::string quoted;
  MLE_RETURN_IF_ERROR(Guard([&] { quoted = backend_->Quote(name); }));
  return quoted;
}

}  // namespace mle
