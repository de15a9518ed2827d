// result.json, arx.json and step_response.csv (docs/formats.md).

#ifndef APPS_CORRECT_OUTPUTS_H_
#define APPS_CORRECT_OUTPUTS_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/correct/result.h"
#include "apps/report/html.h"

namespace mle::correct {

// Half the width of an interval of the asked-for confidence, in standard
// errors.
double BandFactor(const Result& result);

// `flags`: every flag's name and value; `command` as it was given.
absl::StatusOr<std::string> FormatResult(
    const Result& result, const std::string& command,
    const std::vector<std::pair<std::string, std::string>>& flags);

std::string FormatArx(const ArxModel& model, const ProcessModel& channels);

std::string FormatStepResponses(const Result& result);

// Into request.out. All contents are made before the first file is written;
// what a former run has left there of another result is removed. `json` is the
// text of result.json; `again` is for the page.
absl::Status WriteResult(const Result& result, const std::string& json,
                         const report::RunAgain& again);

}  // namespace mle::correct

#endif  // APPS_CORRECT_OUTPUTS_H_
