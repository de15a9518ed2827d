// The tables of the console and the page.

#ifndef APPS_CORRECT_TABLES_H_
#define APPS_CORRECT_TABLES_H_

#include <string>

#include "apps/correct/result.h"
#include "apps/report/table.h"

namespace mle::correct {

// Gain, time constant and dead time of every element: as it was, as fitted
// with all elements free with its interval, as written.
report::Table ParameterTable(const Result& result);
// The corrected model as first-order elements with standard errors.
report::Table FopdtTable(const Result& result);
report::Table ValidationTable(const Result& result);
report::Table ResidualTable(const Result& result);
report::Table NoiseTable(const Result& result);
report::Table CertificateTable(const Result& result);

// The values that an engineer types into a controller: first-order elements of
// the model written, those that have changed with intervals if asked for, and
// what they were before.
report::Table ControllerTable(const Result& result, bool with_intervals);
// Where these differ from the responses of the model written by more than 2 %,
// and what to use then; empty: nowhere.
std::string WhereFirstOrderIsNotNear(const Result& result);
// Fits of both models, several steps ahead.
report::Table FitTable(const Result& result);

// The meaning of ± in all tables and sentences.
std::string IntervalNote(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_TABLES_H_
