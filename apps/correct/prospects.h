// What records tell before anything is fitted to them: the report of
// mle_correct --dry_run and of mle.advice() in Python.
//
// The noise of an output is what the given model leaves of its predictions one
// sample ahead, outside of the windows if there is enough of that; in windows
// it is too large where the model has aged, and what is expected of a
// correction is on the safe side.
//
//   std::cout << DescribeRecords(data, files, model,
//                                FindProspects(data, model, 0));

#ifndef APPS_CORRECT_PROSPECTS_H_
#define APPS_CORRECT_PROSPECTS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/correct/data_sources.h"
#include "apps/report/table.h"
#include "mle/correction/pair_information.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle::correct {

struct Prospects {
  PairInformation information;  // of the windows
  // p: inputs answer to the output (feedback.h), by a test that errs in one
  // record of a hundred.
  std::vector<bool> feedback;
};

// FailedPrecondition where the data forbid a correction, with the reason;
// otherwise errors as of AssessInformation(). `threads`: 0 for each processor.
absl::StatusOr<Prospects> FindProspects(const RecordData& data,
                                        const ProcessModel& model, int threads);

// A row for each element: how well its parameters can be estimated.
report::Table ProspectTable(const Prospects& prospects,
                            const ProcessModel& model);

// Tables of files, channels, windows and elements, then sentences on feedback
// and what was found.
std::string DescribeRecords(const RecordData& data,
                            const std::vector<DataFile>& files,
                            const ProcessModel& model,
                            const absl::StatusOr<Prospects>& prospects);

}  // namespace mle::correct

#endif  // APPS_CORRECT_PROSPECTS_H_
