// All that a correction writes: models, step responses, page, result.json
// (docs/formats.md).

#ifndef APPS_CORRECT_RESULT_FILES_H_
#define APPS_CORRECT_RESULT_FILES_H_

#include <string>

#include "absl/status/status.h"
#include "apps/correct/result.h"
#include "apps/report/html.h"

namespace mle::correct {

// Into request.out. All contents are made before the first file is written;
// what a former run has left there of another result is removed. `json` is the
// text of result.json; `again` is for the page.
absl::Status WriteResult(const Result& result, const std::string& json,
                         const report::RunAgain& again);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RESULT_FILES_H_
