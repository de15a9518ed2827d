#include "apps/serve/access.h"

#include <arpa/inet.h>
#include <openssl/crypto.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/strip.h"
#include "apps/common/sha256.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::serve {
namespace {

constexpr int kPortDigits = 5;

// The host without its port; empty where it is not such.
absl::string_view WithoutPort(absl::string_view host) {
  std::size_t end = host.find(':');
  if (!host.empty() && host[0] == '[') {
    end = host.find(']');
    if (end == absl::string_view::npos) return "";
    ++end;
  }
  if (end >= host.size()) return host;
  const absl::string_view port = host.substr(end + 1);
  const bool is_port =
      host[end] == ':' && port.size() <= kPortDigits &&
      std::all_of(port.begin(), port.end(), [](char c) {
        return absl::ascii_isdigit(static_cast<unsigned char>(c));
      });
  return is_port ? host.substr(0, end) : "";
}

bool IsNumericAddress(absl::string_view host) {
  unsigned char bytes[sizeof(in6_addr)];
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    const std::string inside(host.substr(1, host.size() - 2));
    return inet_pton(AF_INET6, inside.c_str(), bytes) == 1;
  }
  return inet_pton(AF_INET, std::string(host).c_str(), bytes) == 1;
}

bool IsNamed(const Access& access, absl::string_view host) {
  return std::any_of(access.host_names.begin(), access.host_names.end(),
                     [&](const std::string& name) {
                       return absl::EqualsIgnoreCase(name, host);
                     });
}

// The token in `text`, of the file or the variable `from`.
absl::StatusOr<std::string> CheckedToken(absl::string_view text,
                                         absl::string_view from) {
  const absl::string_view token = absl::StripAsciiWhitespace(text);
  if (token.size() < kLeastToken ||
      !std::all_of(token.begin(), token.end(),
                   [](char c) { return c > ' ' && c < '\x7f'; })) {
    return InvalidArgument(from, ": a token has at least ", kLeastToken,
                           " characters, which are letters, digits and signs "
                           "of ASCII; `openssl rand -hex 32` makes one");
  }
  return std::string(token);
}

}  // namespace

bool IsHostAllowed(const Access& access, absl::string_view host) {
  const absl::string_view name = WithoutPort(host);
  return absl::EqualsIgnoreCase(name, "localhost") || IsNumericAddress(name) ||
         IsNamed(access, name);
}

std::string CrossSiteFault(const Access& access, const Request& request) {
  if (!request.fetch_site.empty() && request.fetch_site != "same-origin" &&
      request.fetch_site != "none") {
    return "The request comes from another site.";
  }
  // Programs send no Origin.
  if (request.origin.empty()) return "";
  absl::string_view host = request.origin;
  if (!absl::ConsumePrefix(&host, "http://") &&
      !absl::ConsumePrefix(&host, "https://")) {
    return "The Origin of the request is not that of this server.";
  }
  // Behind a proxy, Host may be the address that the proxy knows.
  if (absl::EqualsIgnoreCase(host, request.host) ||
      IsNamed(access, WithoutPort(host))) {
    return "";
  }
  return "The Origin of the request is not that of this server.";
}

bool IsRightToken(const Access& access, absl::string_view given) {
  const std::string right = Sha256Of(access.token);
  const std::string found = Sha256Of(std::string(given));
  return !access.token.empty() &&
         CRYPTO_memcmp(right.data(), found.data(), right.size()) == 0;
}

absl::string_view BearerToken(const Request& request) {
  constexpr absl::string_view kScheme = "bearer ";
  const absl::string_view value = request.authorization;
  if (!absl::StartsWithIgnoreCase(value, kScheme)) return "";
  return absl::StripAsciiWhitespace(value.substr(kScheme.size()));
}

absl::StatusOr<std::string> ReadToken(const std::string& file,
                                      const char* variable) {
  if (file.empty()) {
    const char* const value = std::getenv(variable);
    if (value == nullptr || *value == '\0') return "";
    return CheckedToken(value, variable);
  }
  struct stat about = {};
  if (stat(file.c_str(), &about) == 0 && (about.st_mode & S_IRWXO) != 0) {
    return InvalidArgument(file,
                           ": others may read the token; chmod o= ", file);
  }
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(file));
  return CheckedToken(text, file);
}

}  // namespace mle::serve
