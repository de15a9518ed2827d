// The head of an HTTP/1.1 request, held strictly to what may stand in it: what
// two programs could understand differently (repeated lengths, names with
// blanks, control characters) is refused.
//
//   GET /api/v1/controllers?status=aged HTTP/1.1
//   Host: localhost:8080

#ifndef APPS_SERVE_REQUEST_H_
#define APPS_SERVE_REQUEST_H_

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

namespace mle::serve {

inline constexpr std::size_t kMostHead = 16'384;   // bytes
inline constexpr std::size_t kMostBody = 16'384;   // bytes
inline constexpr std::size_t kMostTarget = 2'048;  // bytes
inline constexpr int kMostHeaders = 64;

struct Request {
  std::string method = {};
  std::string path = {};                          // as sent, without the query
  std::map<std::string, std::string> query = {};  // decoded; the last of a name
  // Headers; empty where they were not sent.
  std::string host = {};
  std::string origin = {};
  std::string fetch_site = {};  // Sec-Fetch-Site
  std::string authorization = {};
  std::string content_type = {};
  std::size_t body_bytes = 0;

  std::string body = {};
};

// The parts of a head, as they were sent.
struct Head {
  absl::string_view method, target, version;
  std::vector<std::pair<absl::string_view, absl::string_view>> headers;
};

struct ParsedHead {
  int status = 200;  // otherwise of the answer to a request that is refused
  std::string fault = {};  // in words
  Request request = {};
};

ParsedHead ParseHead(const Head& head);

// "%41+b" is "A b"; nothing where what follows a % is not hexadecimal.
std::optional<std::string> DecodePercent(absl::string_view text);

// "who=Ann+B&note=", as queries and forms have it; nothing where it cannot be
// decoded.
std::optional<std::map<std::string, std::string>> ParseForm(
    absl::string_view text);

}  // namespace mle::serve

#endif  // APPS_SERVE_REQUEST_H_
