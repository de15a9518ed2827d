// A run that looks at some of a model's outputs only: those that are asked for,
// or those whose tags the records have. The inputs that move none of them are
// left out too. What is written in the form of the model given has all of it,
// corrected where the part is.

#ifndef APPS_CORRECT_PART_OF_MODEL_H_
#define APPS_CORRECT_PART_OF_MODEL_H_

#include <vector>

#include "absl/status/status.h"
#include "apps/correct/request.h"
#include "mle/data/historian.h"

namespace mle::correct {

// Keeps only request.outputs, if there are any, and their inputs.
// InvalidArgument names an output that the model does not have.
absl::Status ChooseOutputs(Request& request);

// Leaves out the outputs that have no column in the sources, and those that an
// input without a column moves. False, and nothing is done, if there is no such
// output, or no other. A column of nearly the name is one that was meant.
bool LeaveOutMissing(const std::vector<HistorianSource>& sources,
                     Request& request);

// The whole model with this one in place of its part.
ProcessModel InWholeModel(const Request& request, const ProcessModel& part);

}  // namespace mle::correct

#endif  // APPS_CORRECT_PART_OF_MODEL_H_
