#include "apps/watch/alarms.h"

#include <utility>

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
absl::Status HandOn(const std::string& program, const std::string& controller,
                    const Alarm& alarm) {
  const std::string text =
      FormatJson({{"id", alarm.id},
                  {"controller", controller},
                  {"day", NameOfDay(alarm.day)},
                  {"text", alarm.text},
                  {"repeated", alarm.delivery == Alarm::Delivery::kBeingSent}});
  MLE_ASSIGN_OR_RETURN(
      const report::ProcessResult run,
      report::RunProcess(program, {alarm.id}, text, {.time_limit = kLongest}));
  if (run.exit_code == 0) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      "exit code ", run.exit_code, ": ", absl::StripAsciiWhitespace(run.err)));
}

}  // namespace

absl::Status HandOnAlarms(const std::string& program, State& state) {
  MLE_ASSIGN_OR_RETURN(const auto alarms, state.Undelivered());
  absl::Status first;
  for (const auto& [controller, alarm] : alarms) {
    MLE_RETURN_IF_ERROR(
        state.SetDelivery(alarm.id, Alarm::Delivery::kBeingSent));
    const absl::Status status = HandOn(program, controller, alarm);
    MLE_RETURN_IF_ERROR(
        state.SetDelivery(alarm.id, status.ok() ? Alarm::Delivery::kSent
                                                : Alarm::Delivery::kToSend));
    if (first.ok() && !status.ok()) {
      first = absl::UnavailableError(
          absl::StrCat("--alarm_command=", program, ": the alarm of ",
                       controller, " was not taken: ", status.message()));
    }
  }
  return first;
}

}  // namespace mle::watch
