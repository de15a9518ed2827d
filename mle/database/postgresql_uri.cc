#include "mle/database/postgresql_uri.h"

#include <libpq-fe.h>

#include <cstdlib>
#include <memory>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "mle/base/absl_view.h"
#include "mle/database/database_name.h"

namespace mle {
namespace {

// Of an unreachable host, unless somebody has said otherwise.
constexpr char kConnectTimeout[] = "15";

constexpr char kRemedy[] =
    "set PGPASSWORD in the environment, or have it in ~/.pgpass or a service "
    "of ~/.pg_service.conf (postgresql:///?service=NAME); on a terminal it is "
    "asked for";

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

}  // namespace

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
