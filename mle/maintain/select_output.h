// Parts of a model, and one output of its records: each is a problem of its
// own.

#ifndef MLE_MAINTAIN_SELECT_OUTPUT_H_
#define MLE_MAINTAIN_SELECT_OUTPUT_H_

#include <vector>

#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// These outputs (of 0 … p − 1) and inputs (of 0 … m − 1) in this order, as a
// model of its own.
ProcessModel SelectPart(const ProcessModel& model,
                        const std::vector<int>& outputs,
                        const std::vector<int>& inputs);
// The same with all inputs.
ProcessModel SelectPart(const ProcessModel& model,
                        const std::vector<int>& outputs);

// The row of the output (0 … p − 1), as a model of its own.
ProcessModel SelectOutput(const ProcessModel& model, int output);

// The output with its set point, and all inputs.
Record SelectOutput(const Record& record, int output);

}  // namespace mle

#endif  // MLE_MAINTAIN_SELECT_OUTPUT_H_
