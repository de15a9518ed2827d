// mle_watch: the health of every model, every day.

#include <iostream>

#include "apps/common/command_line.h"
#include "apps/watch/request.h"
#include "apps/watch/run.h"

namespace mle {
namespace {

constexpr char kUsage[] =
    R"(Watches the models of controllers: reads what is new in their records, carries
on the evidence that a gain, a time constant or a dead time has changed, raises
alarms, runs corrections, and writes pages. To be run every day, by cron or a
systemd timer; a run that was missed is caught up, a run twice changes nothing.

  mle_watch --controllers=controllers.json --out=watch

Serves the pages, until it is stopped:

  mle_watch --controllers=controllers.json --out=watch --serve=127.0.0.1:8080

Acknowledges an alarm:

  mle_watch --out=watch --acknowledge=3f9a12c0 --note="valve ordered"

It never writes to a controller. Exit codes: 0 done, whatever was found; 1 a
controller could not be looked at, or an alarm not handed on; 2 bad input or
flags.)";

int End(const absl::Status& status) {
  return status.ok() ? kExitDone : Fail(status);
}

int Main(watch::Request& request) {
  if (const absl::Status status = watch::Complete(request); !status.ok()) {
    return Fail(status);
  }
  if (!request.acknowledge.empty())
    return End(watch::AcknowledgeAlarm(request));
  if (!request.serve.empty()) return End(watch::ServeSite(request));
  const absl::StatusOr<watch::RunSummary> summary = watch::RunWatches(request);
  if (!summary.ok()) return Fail(summary.status());
  std::cout << summary->aged << " of " << summary->controllers
            << " models have aged; see " << request.out << "/index.html\n";
  for (const std::string& failure : summary->failures) {
    SayError(failure);
  }
  return summary->failures.empty() ? kExitDone : kExitNotUsable;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  mle::watch::Request request;
  mle::OptionTable table;
  mle::watch::AddOptions(request, table);
  mle::StartCommand(mle::kUsage, table, argc, argv);
  return mle::Main(request);
}
