// A message to a web address.

#ifndef APPS_SERVE_POST_H_
#define APPS_SERVE_POST_H_

#include <chrono>
#include <string>

#include "absl/status/status.h"

namespace mle::serve {

// InvalidArgument where it is not http://HOST[:PORT][/PATH] or https://….
absl::Status CheckUrl(const std::string& url);

// POSTs the text, with `id` as Idempotency-Key. OK for a status of 200 to 299;
// Unavailable for another, or if nothing could be sent; DeadlineExceeded where
// it was sent, but no answer came. Redirections are not followed, certificates
// are checked. Not much longer than `time` passes, whatever is answered, and
// however slowly. The messages do not show the address, which may be secret.
absl::Status PostJson(
    const std::string& url, const std::string& text, const std::string& id,
    std::chrono::milliseconds time = std::chrono::seconds(20));

}  // namespace mle::serve

#endif  // APPS_SERVE_POST_H_
