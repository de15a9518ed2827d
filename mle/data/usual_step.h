// The usual distance between the rows of a file. Internal to mle/data.

#ifndef MLE_DATA_USUAL_STEP_H_
#define MLE_DATA_USUAL_STEP_H_

#include <vector>

namespace mle {

// Of steps above 0, at least one: the mean of those near the median, rounded to
// as few digits as keep it to 1e-6, or, where steps are uneven, to 0.5 %.
double UsualStep(const std::vector<double>& steps);

}  // namespace mle

#endif  // MLE_DATA_USUAL_STEP_H_
