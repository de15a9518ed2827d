#include "mle/database/database_name.h"

#include <libpq-fe.h>

#include <cstdlib>
#include <memory>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "mle/base/absl_view.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"

namespace mle {
namespace {

// Seconds until an unreachable host is given up, unless the name, a service or
// the environment sets a limit.
constexpr char kConnectTimeout[] = "15";

constexpr char kRemedy[] =
    "set PGPASSWORD in the environment, or have it in ~/.pgpass or a service "
    "of ~/.pg_service.conf (postgresql:///?service=NAME); on a terminal it is "
    "asked for";

// That a name has a password in it, and where it should be instead.
absl::Status PasswordError(std::string_view kind, std::string_view remedy) {
  return InvalidArgument(
      "the name of the ", AbslView(kind),
      " database has a password in it, which others could read in the list of "
      "processes and in results; take it out, and ",
      AbslView(remedy));
}

// "//user:word@host", also where a library would not read it so.
bool HasPasswordOfUser(std::string_view uri) {
  const std::size_t begin = uri.find("//");
  if (begin == std::string_view::npos) return false;
  const std::string_view rest = uri.substr(begin + 2);
  const std::size_t at = rest.rfind('@');
  if (at == std::string_view::npos) return false;
  const std::string user = absl::AsciiStrToLower(AbslView(rest.substr(0, at)));
  return absl::StrContains(user, ":") || absl::StrContains(user, "%3a");
}

// Nothing of it is repeated: a password may stand anywhere.
absl::Status NotAUri() {
  return absl::InvalidArgumentError(
      "the URI of the PostgreSQL database cannot be read; it must be of the "
      "form postgresql://USER@HOST:PORT/NAME?PARAMETER=VALUE");
}

// As a parameter of the URI; letters and digits alone go unchanged.
void Add(std::string_view keyword, std::string_view value, std::string& uri) {
  absl::StrAppend(&uri, uri.back() == '?' ? "" : "&", AbslView(keyword), "=");
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (absl::ascii_isalnum(byte)) {
      uri += c;
    } else {
      absl::StrAppend(&uri, "%", absl::Hex(byte, absl::kZeroPad2));
    }
  }
}

bool IsPostgresql(std::string_view text) {
  return absl::StartsWithIgnoreCase(AbslView(text), "postgresql://") ||
         absl::StartsWithIgnoreCase(AbslView(text), "postgres://");
}

// Whether what stands under this key is for nobody's eyes: PWD, SSLPassword,
// Auth_AccessToken, APIKey.
bool IsSecret(std::string_view key) {
  std::string letters;
  for (const char c : key) {
    if (absl::ascii_isalpha(static_cast<unsigned char>(c))) {
      letters += absl::ascii_tolower(static_cast<unsigned char>(c));
    }
  }
  if (letters == "key") return true;
  for (const char* const part :
       {"pwd", "pass", "secret", "token", "credential", "apikey", "accesskey",
        "accountkey", "privatekey"}) {
    if (absl::StrContains(letters, part)) return true;
  }
  return false;
}

// Whether text such as "KEY=VALUE;KEY=VALUE", divided by `separator`, has a
// secret in it.
bool HasSecret(std::string_view text, char separator) {
  for (const absl::string_view part :
       absl::StrSplit(AbslView(text), separator)) {
    const std::vector<absl::string_view> pair =
        absl::StrSplit(part, absl::MaxSplits('=', 1));
    if (pair.size() == 2 && IsSecret({pair[0].data(), pair[0].size()})) {
      return true;
    }
  }
  return false;
}

absl::StatusOr<DatabaseName> ParsePostgresql(std::string_view text) {
  // libpq wants the scheme in lower case.
  const std::size_t end = text.find("://");
  const std::string uri =
      absl::StrCat(absl::AsciiStrToLower(AbslView(text.substr(0, end))),
                   AbslView(text.substr(end)));
  MLE_RETURN_IF_ERROR(PostgresqlParameters(uri, "").status());
  return DatabaseName{DatabaseKind::kPostgresql, std::string(text), uri};
}

absl::StatusOr<DatabaseName> ParseSqlite(std::string_view text) {
  std::string_view path = text.substr(text.find(':') + 1);
  const std::size_t question = path.find('?');
  if (HasPasswordOfUser(path.substr(0, path.find('/', 2))) ||
      (question != std::string_view::npos &&
       HasSecret(path.substr(question + 1), '&'))) {
    return PasswordError("SQLite", "name the file alone: sqlite:FILE");
  }
  // sqlite:///FILE, as others write it: an absolute path follows the third /.
  if (path.starts_with("//")) path.remove_prefix(2);
  if (path.empty()) {
    return absl::InvalidArgumentError(
        "'sqlite:' names no file; it must be sqlite:FILE");
  }
  if (path.find('"') != std::string_view::npos ||
      path.find('\0') != std::string_view::npos) {
    return InvalidArgument(
        "'", ShowCsvText(text),
        "': the path of an SQLite file must not have a double "
        "quote in it; rename the file");
  }
  return DatabaseName{DatabaseKind::kSqlite, std::string(text),
                      std::string(path)};
}

absl::StatusOr<DatabaseName> ParseOdbc(std::string_view text) {
  const std::string_view place = text.substr(text.find(':') + 1);
  if (HasSecret(place, ';') || HasPasswordOfUser(place)) {
    return PasswordError("ODBC",
                         "set MLE_ODBC_PASSWORD (and MLE_ODBC_USER) in the "
                         "environment, or have it in odbc.ini");
  }
  // Nothing of it is repeated, as of a URI that cannot be read.
  if (place.starts_with("//")) {
    return absl::InvalidArgumentError(
        "'odbc://…' is not a name for ODBC; it must be odbc:NAME with a NAME "
        "of odbc.ini, or odbc:KEY=VALUE;KEY=VALUE");
  }
  if (place.empty()) {
    return absl::InvalidArgumentError(
        "'odbc:' names no data source; it must be odbc:NAME with a NAME of "
        "odbc.ini");
  }
  return DatabaseName{DatabaseKind::kOdbc, std::string(text),
                      std::string(place)};
}

}  // namespace

absl::StatusOr<DatabaseName> ParseDatabaseName(std::string_view text) {
  if (IsPostgresql(text)) return ParsePostgresql(text);
  if (absl::StartsWithIgnoreCase(AbslView(text), "sqlite:")) {
    return ParseSqlite(text);
  }
  if (absl::StartsWithIgnoreCase(AbslView(text), "odbc:"))
    return ParseOdbc(text);
  // The text after the scheme may have a password in it, and is not shown.
  const std::string_view scheme = text.substr(0, text.find(':'));
  return InvalidArgument(
      "'", ShowCsvText(scheme),
      ":…' is not a database that can be read; those are "
      "postgresql://USER@HOST/NAME, sqlite:FILE and odbc:NAME, the "
      "last for all others, by their ODBC drivers");
}

absl::StatusOr<std::string> PostgresqlParameters(const std::string& uri,
                                                 const std::string& password) {
  if (HasPasswordOfUser(uri)) return PasswordError("PostgreSQL", kRemedy);
  char* fault = nullptr;
  const std::unique_ptr<PQconninfoOption, void (*)(PQconninfoOption*)> options(
      PQconninfoParse(uri.c_str(), &fault), &PQconninfoFree);
  // It may have a part of the URI, and that a password.
  PQfreemem(fault);
  if (options == nullptr) return NotAUri();
  std::string parameters = "postgresql:///?";
  bool has_timeout = std::getenv("PGCONNECT_TIMEOUT") != nullptr ||
                     std::getenv("PGSERVICE") != nullptr;
  for (const PQconninfoOption* option = options.get();
       option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    const std::string_view keyword = option->keyword;
    if (keyword == "password" || keyword == "sslpassword") {
      return PasswordError("PostgreSQL", kRemedy);
    }
    if (keyword == "port" &&
        std::string_view(option->val).find_first_not_of("0123456789,") !=
            std::string_view::npos) {
      return NotAUri();
    }
    has_timeout =
        has_timeout || keyword == "connect_timeout" || keyword == "service";
    Add(keyword, option->val, parameters);
  }
  if (!has_timeout) Add("connect_timeout", kConnectTimeout, parameters);
  Add("fallback_application_name", "mle", parameters);
  if (!password.empty()) Add("password", password, parameters);
  return parameters;
}

}  // namespace mle
