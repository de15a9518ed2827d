// The parts of result.json.

#ifndef APPS_CORRECT_RESULT_JSON_H_
#define APPS_CORRECT_RESULT_JSON_H_

#include "Eigen/Core"
#include "apps/correct/result.h"
#include "nlohmann/json.hpp"

namespace mle::correct {

// null where it is not finite.
nlohmann::ordered_json NumberJson(double value);
// Row by row.
nlohmann::ordered_json MatrixJson(const Eigen::MatrixXd& matrix);

// Decision, test, elements, distances, noise.
void AddFindings(const Result& result, nlohmann::ordered_json& json);
// Windows, validation, residuals, certificate, advice, warnings.
void AddDiagnostics(const Result& result, nlohmann::ordered_json& json);

}  // namespace mle::correct

#endif  // APPS_CORRECT_RESULT_JSON_H_
