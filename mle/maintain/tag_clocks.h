// Tags whose clocks differ: time stamps of one tag that are early or late
// beside all others.
//
// A late output delays its whole row of the model by the same time, a late
// input its whole column by the negative. The delay is found by maximum
// likelihood (whitened_fit.h) and reported if it explains the row or column, of
// two elements or more, completely: it gains 10 nats, 10 more than a delay of
// any one element, whose dead time does not become negative by it, and beside
// it free gains and delays of its rows are not significant (1 %).
//
// Longer dead times in a whole row or column look the same, and may be what
// they seem: an analyser's sample line, a valve. Only a dead time that becomes
// negative is impossible.

#ifndef MLE_MAINTAIN_TAG_CLOCKS_H_
#define MLE_MAINTAIN_TAG_CLOCKS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct TagClock {
  bool is_output = false;
  int channel = 0;
  // By which its time stamps are late, in the model's time unit, with standard
  // error.
  double late = 0.0;
  double error = 0.0;
  double log_likelihood = 0.0;  // gained
  bool impossible = false;      // else: a dead time would be negative

  std::string Describe(const ProcessModel& model) const;
};

// Outputs first; of inputs only the likeliest, and only if no output is late.
// Needs some hundred samples around changes of set points, and takes as many
// that elements × samples are at most 2·10⁷. Errors as of SimulateResponse().
absl::StatusOr<std::vector<TagClock>> FindTagClocks(
    const ProcessModel& model, const std::vector<Record>& records,
    int threads = 1);

// Shifts the tag's samples to when they were measured: an output by straight
// lines between samples, an input, which is held, by whole samples. What no
// sample is known of at an end becomes NaN.
void CorrectClock(const TagClock& clock, std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_MAINTAIN_TAG_CLOCKS_H_
