// Tags of modes: when a controller, the loop of an output, or the loop below an
// input was in use. Words are those of control systems, and 1 and 0:
//
//   by hand           MAN, MANUAL, LOCAL, OFF, SHED, STANDBY, WARM, 0
//   by the controller CAS, RCAS, ROUT, BCAS, REMOTE, PRD, ON, 1
//   AUTO              by the controller; of an input by hand, as its loop then
//                     has a set point of its own
//   neither           IMAN, INIT, TRK, LO, OOS, HOLD: the input tracks
//   something
//
// Moves by hand are the best evidence there is: each is a change around which a
// window is made. A set point says nothing while its loop is by hand, as most
// follow the output then.

#ifndef MLE_MAINTAIN_MODES_H_
#define MLE_MAINTAIN_MODES_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/data/set_point_windows.h"
#include "mle/maintain/message.h"
#include "mle/model/process_model.h"

namespace mle {

struct Modes {
  std::vector<ByHand> by_hand;
  std::vector<Message> notes;  // one for each tag
};

// The number that a word of ReadModes() stands for where samples are numbers.
// InvalidArgument for another word.
absl::StatusOr<double> ModeCode(std::string_view word);

// From where `records` come by `options`. InvalidArgument for a channel that
// the model does not have, a column that is missing, and words and numbers that
// are no modes.
absl::StatusOr<Modes> ReadModes(const ImportOf& import,
                                const ProcessModel& model,
                                const HistorianOptions& options,
                                const std::vector<ModeTag>& tags,
                                const std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_MAINTAIN_MODES_H_
