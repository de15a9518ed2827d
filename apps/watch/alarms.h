// Alarms handed on to a program.
//
// The program is run once for each alarm, with the alarm's id as its argument
// and on its standard input
//
//   {"id": …, "controller": …, "day": "2024-02-29", "text": …, "repeated":
//   false}
//
// That it is being run is in the state before, that it has ended with exit code
// 0 after it. If this program was killed in between, the next run hands the
// alarm on once more, with the same id and "repeated": true: whether it arrived
// the program that takes it knows by the id.

#ifndef APPS_WATCH_ALARMS_H_
#define APPS_WATCH_ALARMS_H_

#include <string>

#include "absl/status/status.h"
#include "apps/watch/state.h"

namespace mle::watch {

// Unavailable, naming the first, where alarms could not be handed on: the next
// run tries again.
absl::Status HandOnAlarms(const std::string& program, State& state);

}  // namespace mle::watch

#endif  // APPS_WATCH_ALARMS_H_
