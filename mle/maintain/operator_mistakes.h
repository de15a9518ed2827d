// Mistakes that look like ageing: tags swapped, a sign reversed, a channel or
// all times in another unit.
//
// Every mistake is a model without free parameters: the same elements with
// other tags, signs, units or times. It is compared, by the likelihood of the
// innovations (whitened_fit.h) at every sample and in means of 5 and 20, with
// the model as it is and with one in which the channels concerned do nothing.
// Other than the plant, a mistake moves a whole row or column at once: signs
// and factors are looked for only where all elements of the row or column that
// the records determine agree, of four or more one in four excepted, which may
// have aged besides.
//
//   each       by 10 better than as recorded and than no response, in one of
//              the three comparisons, and worse in none; and the model,
//              simulated without the mistake, follows the outputs better
//   exchange   by 10 better with few gains free on both sides, too: elements
//              may have aged; the simulation explains a quarter of what the
//              outputs do, three fifths where the channels have other units or
//              roles
//   sign       gains of −4 to −1/4 of the model's in all elements, which may
//              have aged besides
//   factor     beyond 20: gains that agree to a factor of 2; 1.8, or beyond 4:
//              gains that agree to 5 and 10 % in all three comparisons
//   time unit  by 10 better than as recorded with free gains
//
// Where a row or column has one element only, nothing distinguishes a mistake
// from ageing but the number: 60, 100, 1000 and their inverses, to 2 %, and a
// sign, which ageing does not turn.

#ifndef MLE_MAINTAIN_OPERATOR_MISTAKES_H_
#define MLE_MAINTAIN_OPERATOR_MISTAKES_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/data/record_columns.h"
#include "mle/model/process_model.h"

namespace mle {

struct OperatorMistake {
  enum class Kind { kExchanged, kSign, kFactor, kTimeUnit };
  Kind kind = Kind::kExchanged;
  bool outputs = false;       // the channels are outputs, not inputs
  std::vector<int> channels;  // the two exchanged; none for kTimeUnit
  // kFactor: gains of the records over those of the model; kTimeUnit: of times.
  double factor = 1.0;
  // Log-likelihood ratio to the model as it is; the least of the comparisons.
  double log_likelihood = 0.0;
  // One element alone tells: it may as well have aged.
  bool ambiguous = false;

  // "The tags of reflux and steam seem to be swapped. Correct it with …": the
  // lines of the file of tags, or the option, that correct it, where `tags`
  // says which columns the channels are.
  std::string Describe(const ProcessModel& model,
                       const std::vector<TagMapping>& tags = {}) const;
};

// The likeliest mistake, if there is one. Needs some hundred samples around
// changes of set points, and takes as many that inputs × elements × samples are
// at most 10⁹: of so many samples responses are simulated, each of two
// exchanged inputs by the other. Errors as of SimulateResponse().
absl::StatusOr<std::optional<OperatorMistake>> FindOperatorMistake(
    const ProcessModel& model, const std::vector<Record>& records,
    int threads = 1);

}  // namespace mle

#endif  // MLE_MAINTAIN_OPERATOR_MISTAKES_H_
