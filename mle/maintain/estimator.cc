#include "mle/maintain/estimator.h"

#include "absl/strings/str_cat.h"

namespace mle {

const std::vector<Estimator>& AllEstimators() {
  static const auto* const kAll = new std::vector<Estimator>{
      Estimator::kStructured, Estimator::kArx, Estimator::kCombined};
  return *kAll;
}

std::string_view NameOf(Estimator estimator) {
  switch (estimator) {
    case Estimator::kStructured:
      return "structured";
    case Estimator::kArx:
      return "arx";
    case Estimator::kCombined:
      return "combined";
  }
  return "";
}

absl::StatusOr<Estimator> ParseEstimator(std::string_view name) {
  std::string known;
  for (const Estimator estimator : AllEstimators()) {
    if (NameOf(estimator) == name) return estimator;
    absl::StrAppend(&known, known.empty() ? "" : ", ",
                    std::string(NameOf(estimator)));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no estimator '", std::string(name), "'; known are ", known));
}

}  // namespace mle
