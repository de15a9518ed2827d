#include "absl/strings/str_cat.h"
#include "mle/maintain/estimation.h"

namespace mle {
namespace {

const std::vector<ChangeTest>& AllChangeTests() {
  static const auto* const kAll = new std::vector<ChangeTest>{
      ChangeTest::kCalibrated, ChangeTest::kChiSquare, ChangeTest::kAdequacy,
      ChangeTest::kNone};
  return *kAll;
}

// The one of `all` with this name.
template <typename Named>
absl::StatusOr<Named> Find(const std::vector<Named>& all, const char* what,
                           std::string_view name) {
  std::string known;
  for (const Named one : all) {
    if (NameOf(one) == name) return one;
    absl::StrAppend(&known, known.empty() ? "" : ", ",
                    std::string(NameOf(one)));
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no ", what, " '", std::string(name), "'; choose from ", known));
}

}  // namespace

const std::vector<Estimator>& AllEstimators() {
  static const auto* const kAll =
      new std::vector<Estimator>{Estimator::kOutputError, Estimator::kArx};
  return *kAll;
}

std::string_view NameOf(Estimator estimator) {
  switch (estimator) {
    case Estimator::kOutputError:
      return "output_error";
    case Estimator::kArx:
      return "arx";
  }
  return "";
}

std::string_view NameOf(ChangeTest test) {
  switch (test) {
    case ChangeTest::kCalibrated:
      return "calibrated";
    case ChangeTest::kChiSquare:
      return "chi_square";
    case ChangeTest::kAdequacy:
      return "adequacy";
    case ChangeTest::kNone:
      return "none";
  }
  return "";
}

absl::StatusOr<Estimator> ParseEstimator(std::string_view name) {
  return Find(AllEstimators(), "estimator", name);
}

absl::StatusOr<ChangeTest> ParseChangeTest(std::string_view name) {
  return Find(AllChangeTests(), "test of no change", name);
}

}  // namespace mle
