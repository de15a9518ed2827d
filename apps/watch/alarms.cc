#include "apps/watch/alarms.h"

#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "apps/report/process.h"
#include "apps/watch/days.h"
#include "mle/base/status.h"
#include "mle/model/json_text.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

constexpr absl::Duration kLongest = absl::Minutes(2);

// OK once the program has ended with exit code 0.
absl::Status HandOn(const std::string& program, const PendingAlarm& pending) {
  const Alarm& alarm = pending.alarm;
  const std::string text = FormatJson(
      {{"id", alarm.id},
       {"controller", pending.controller},
       {"day", NameOfDay(alarm.day)},
       {"text", alarm.text},
       {"repeated", pending.delivery.state == Delivery::State::kBeingSent}});
  MLE_ASSIGN_OR_RETURN(
      const report::ProcessResult run,
      report::RunProcess(program, {alarm.id}, text, {.time_limit = kLongest}));
  if (run.exit_code == 0) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      "exit code ", run.exit_code, ": ", absl::StripAsciiWhitespace(run.err)));
}

}  // namespace

absl::Status HandOnAlarms(const std::string& program, State& state) {
  MLE_ASSIGN_OR_RETURN(const std::vector<PendingAlarm> alarms,
                       state.Undelivered(Channel::kCommand));
  absl::Status first;
  for (const PendingAlarm& pending : alarms) {
    Delivery delivery = pending.delivery;
    delivery.state = Delivery::State::kBeingSent;
    ++delivery.attempts;
    MLE_RETURN_IF_ERROR(state.SetDelivery(pending.alarm.id, delivery));
    const absl::Status status = HandOn(program, pending);
    delivery.state =
        status.ok() ? Delivery::State::kSent : Delivery::State::kToSend;
    delivery.fault = std::string(status.message());
    MLE_RETURN_IF_ERROR(state.SetDelivery(pending.alarm.id, delivery));
    if (first.ok() && !status.ok()) {
      first = absl::UnavailableError(absl::StrCat(
          "--alarm_command=", program, ": the alarm of ", pending.controller,
          " was not taken: ", status.message()));
    }
  }
  return first;
}

}  // namespace mle::watch
