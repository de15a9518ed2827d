// Who may ask a server for what.
//
// A page of another site, opened in a browser that reaches the server, must
// neither read nor change anything:
// - Host must be an address in numbers, "localhost", or a name that the server
//   was told. (By DNS rebinding a site's own name comes to mean this server;
//   Host is then that name.)
// - What changes anything must not come from another origin, and needs the
//   token.

#ifndef APPS_SERVE_ACCESS_H_
#define APPS_SERVE_ACCESS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "apps/serve/request.h"

namespace mle::serve {

inline constexpr std::size_t kLeastToken = 16;  // bytes

struct Access {
  std::vector<std::string> host_names = {};  // besides "localhost"
  std::string token = {};                    // empty: nothing can be changed
};

// "name", "127.0.0.1:8080", "[::1]:80".
bool IsHostAllowed(const Access& access, absl::string_view host);

// The reason why the origin of the request is refused; empty if it is allowed.
std::string CrossSiteFault(const Access& access, const Request& request);

// In a time that does not depend on where the two differ.
bool IsRightToken(const Access& access, absl::string_view given);

// "Bearer TOKEN" without its first word; empty if it is not such.
absl::string_view BearerToken(const Request& request);

// From the file, or else from the environment; empty if there is neither.
// InvalidArgument for a token that is too short, or whose file others may read.
absl::StatusOr<std::string> ReadToken(const std::string& file,
                                      const char* variable);

}  // namespace mle::serve

#endif  // APPS_SERVE_ACCESS_H_
