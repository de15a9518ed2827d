// The parts of result.json.

#ifndef APPS_CORRECT_RESULT_JSON_H_
#define APPS_CORRECT_RESULT_JSON_H_

#include "apps/correct/result.h"
#include "nlohmann/json.hpp"

namespace mle::correct {

// The date of `time`, where the records have dates.
void AddDate(const TimeNames& times, const char* key, double time,
             nlohmann::ordered_json& json);

// One element (element_json.cc).
nlohmann::ordered_json ElementJson(const Result& result, int i, int j);

// Parts of the diagnostics (record_json.cc).
nlohmann::ordered_json WindowsJson(const Result& result);
nlohmann::ordered_json ChannelsJson(const Result& result);

// The filter of each output (disturbance_filter.cc).
nlohmann::ordered_json FilterJson(const Result& result);

// The next move, where it was asked for (next_move_text.cc).
nlohmann::ordered_json NextMoveJson(const Result& result);

// Decision, test, elements, distances, noise.
void AddFindings(const Result& result, nlohmann::ordered_json& json);
// Windows, validation, residuals, certificate, advice, warnings.
void AddDiagnostics(const Result& result, nlohmann::ordered_json& json);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RESULT_JSON_H_
