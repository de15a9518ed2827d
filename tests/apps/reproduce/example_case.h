// A case made up by hand, to see what becomes of known numbers.

#ifndef TESTS_APPS_REPRODUCE_EXAMPLE_CASE_H_
#define TESTS_APPS_REPRODUCE_EXAMPLE_CASE_H_

#include "apps/reproduce/summary.h"
#include "mle/model/process_model.h"

namespace mle::reproduce {

// Two outputs, three inputs, elements only where both numbers are odd or even;
// gains 10 (i + 1) + j + 1, time constant 5, dead time 2, plus `gain_change`
// and `delay_change` at (0, 0).
ProcessModel ExampleModel(double gain_change, double delay_change);

// Two runs whose errors are known: summary_test.cc. E_star is 3 and 4, E_zero
// 30 and 10, E_oracle 1 and 2, λ* 2e-4 and 4e-4. At (i, j) the static gain is
// wrong by 0.3 and −0.4 and the impulse peaks at 2 and 4; the fit's gain is too
// large by 0.6 and 0.8, its dead time by 0.5 and 0.5.
CaseResult ExampleCase();

}  // namespace mle::reproduce

#endif  // TESTS_APPS_REPRODUCE_EXAMPLE_CASE_H_
