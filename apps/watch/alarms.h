// Alarms on their way: to a program, by mail, to a web address.
//
// Each channel gets each alarm once. That it is being handed on is in the state
// before, that it has arrived after it: once the program or sendmail has ended
// with exit code 0, or the address has answered with a status of 200 to 299.
// An alarm that has not arrived is tried again by the next run. If this program
// was killed in between, or no answer came, the alarm is handed on once more,
// with the same id and "repeated": true: whether it arrived the receiver knows
// by the id.
//
// The program gets the id as its argument and on its standard input what the
// web address gets as the body of a POST:
//
//   {"id": …, "controller": …, "day": "2024-02-29", "text": …, "repeated":
//   false}

#ifndef APPS_WATCH_ALARMS_H_
#define APPS_WATCH_ALARMS_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/watch/state.h"

namespace mle::watch {

// Where alarms go; what is empty is not used.
struct AlarmTargets {
  std::string command = {};                      // program
  std::vector<std::string> mail_addresses = {};  // of receivers
  std::string sendmail = "/usr/sbin/sendmail";
  std::string webhook = {};  // http://… or https://…
};

// InvalidArgument, naming the option, for addresses that are not such.
absl::Status CheckTargets(const AlarmTargets& targets);

// Hands on what has not arrived. Returns a sentence for each channel through
// which alarms did not go; a channel is given up for this run after three
// failures in a row. Errors are of the state.
absl::StatusOr<std::vector<std::string>> HandOnAlarms(
    const AlarmTargets& targets, State& state);

// The JSON above, and the message as sendmail takes it.
std::string FormatAlarm(const PendingAlarm& pending);
std::string FormatMail(const AlarmTargets& targets,
                       const PendingAlarm& pending);

}  // namespace mle::watch

#endif  // APPS_WATCH_ALARMS_H_
