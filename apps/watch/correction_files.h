// Files of corrections, as a server shows them.

#ifndef APPS_WATCH_CORRECTION_FILES_H_
#define APPS_WATCH_CORRECTION_FILES_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/serve/server.h"

namespace mle::watch {

// The regular file FOLDER/PATH. NotFound for anything else: names that are
// hidden or hold other characters than letters, digits and ._-, links on the
// way, more than four folders.
absl::StatusOr<serve::Response> FileBelow(const std::string& folder,
                                          std::string_view path);

}  // namespace mle::watch

#endif  // APPS_WATCH_CORRECTION_FILES_H_
