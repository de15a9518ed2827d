#include "apps/watch/serve_site.h"

#include <iostream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/common/command_line.h"
#include "apps/common/stop_signal.h"
#include "apps/serve/access.h"
#include "apps/serve/server.h"
#include "apps/watch/routes.h"
#include "apps/watch/site.h"
#include "mle/base/file.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

constexpr absl::Duration kTick = absl::Milliseconds(200);
constexpr int kTicksOfLook = 5;

std::string UrlOf(const serve::ServerOptions& options, int port) {
  const bool is_six = options.host.find(':') != std::string::npos;
  return absl::StrCat("http://", is_six ? "[" : "", options.host,
                      is_six ? "]" : "", ":", port, "/");
}

// Looks for news until it is to stop, and says on standard error what cannot be
// read. An error where the first reading fails.
absl::Status KeepUp(Site& site) {
  MLE_RETURN_IF_ERROR(site.Refresh(StopRequested));
  std::string said;
  for (int tick = 1; !StopRequested(); ++tick) {
    absl::SleepFor(kTick);
    if (tick % kTicksOfLook != 0) continue;
    MLE_RETURN_IF_ERROR(site.Refresh(StopRequested));
    const std::string fault = site.snapshot()->fault;
    if (fault != said && !fault.empty()) {
      SayError(absl::StrCat(fault, " (showing what was read before)"));
    }
    said = fault;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ServeSite(const Request& request) {
  absl::StatusOr<std::string> token =
      serve::ReadToken(request.token_file, kTokenVariable);
  if (!token.ok()) {
    return request.token_file.empty()
               ? token.status()
               : WithPrefix(token.status(), "--token_file: ");
  }
  const serve::Access access = {.host_names = request.host_names,
                                .token = *std::move(token)};
  MLE_RETURN_IF_ERROR(MakeWritableFolder(request.out));
  MLE_ASSIGN_OR_RETURN(const std::unique_ptr<Site> site,
                       Site::Open({.list = request.watch_path,
                                   .state = request.state,
                                   .folder = request.out,
                                   .can_acknowledge = !access.token.empty(),
                                   .threads = request.threads}));
  CatchStopSignals();
  absl::StatusOr<std::unique_ptr<serve::Server>> server =
      serve::Server::Start(request.address, [&](const serve::Request& asked) {
        return Answer(*site, access, asked);
      });
  if (!server.ok()) return WithPrefix(server.status(), "--serve: ");
  std::cout << "serving " << UrlOf(request.address, (*server)->port())
            << (access.token.empty() ? " (read-only)" : "") << std::endl;
  if (!serve::IsLoopback(request.address.host)) {
    std::cerr << "note: other machines can reach this address, and nothing is "
                 "encrypted; docs/watch.md shows a proxy that encrypts\n";
  }
  const absl::Status status = KeepUp(*site);
  (*server)->Stop();
  return status;
}

}  // namespace mle::watch
