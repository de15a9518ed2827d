#include "apps/experiment/method.h"

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle::experiment {
namespace {

constexpr std::string_view kNone = "none";
constexpr std::string_view kCeres = "ceres";

}  // namespace

std::string Method::name() const {
  if (!estimator.has_value()) return std::string(kNone);
  std::string name(solve_by_ceres ? kCeres : NameOf(*estimator));
  if (change_test != Method().change_test) {
    absl::StrAppend(&name, ":", std::string(NameOf(change_test)));
  }
  return name;
}

Method PaperMethod() {
  Method method;
  method.estimator = Estimator::kArx;
  method.change_test = ChangeTest::kNone;
  return method;
}

absl::StatusOr<Method> ParseMethod(std::string_view name) {
  Method method;
  if (name == kNone) return method;
  const std::size_t colon = name.find(':');
  const std::string_view estimator = name.substr(0, colon);
  method.solve_by_ceres = estimator == kCeres;
  const absl::StatusOr<Estimator> parsed =
      method.solve_by_ceres ? Estimator::kArx : ParseEstimator(estimator);
  if (!parsed.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(parsed.status().message(), ", ", std::string(kCeres),
                     " and ", std::string(kNone)));
  }
  method.estimator = *parsed;
  if (colon != std::string_view::npos) {
    MLE_ASSIGN_OR_RETURN(method.change_test,
                         ParseChangeTest(name.substr(colon + 1)));
  }
  EstimationOptions options;
  options.estimator = *method.estimator;
  options.change_test = method.change_test;
  MLE_RETURN_IF_ERROR(options.Validate());
  return method;
}

}  // namespace mle::experiment
