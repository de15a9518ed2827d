#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "apps/lifecycle/report.h"

namespace mle::lifecycle {
namespace {

// "2nd", "3rd", "12th".
std::string Ordinal(int n) {
  absl::string_view ending = "th";
  if (n / 10 % 10 != 1) {
    if (n % 10 == 1) ending = "st";
    if (n % 10 == 2) ending = "nd";
    if (n % 10 == 3) ending = "rd";
  }
  return absl::StrCat(n, ending);
}

// "every change", "every 3rd change".
std::string Every(int n, absl::string_view what) {
  return n == 1 ? absl::StrCat("every ", what)
                : absl::StrCat("every ", Ordinal(n), " ", what);
}

std::string Months(const std::string& months) {
  return months == "1" ? "every month"
                       : absl::StrCat("every ", months, " months");
}

// What a correction estimates.
absl::string_view Estimated(Estimator estimator) {
  switch (estimator) {
    case Estimator::kOutputError:
      break;
    case Estimator::kCombined:
      return "Gains, time constants and dead times, and the shape of responses "
             "where these do not describe it, are";
    case Estimator::kArx:
      return "Whole step responses (ΔR, around the model of the commissioning) "
             "are";
  }
  return "Gains, time constants and dead times are";
}

constexpr char kStepTest[] =
    "The controller is off, each input goes up and back, and the model is "
    "corrected from that record. When: ";

}  // namespace

std::string ShortName(const Policy& policy) {
  switch (policy.kind) {
    case Policy::Kind::kNever:
      return "never updated";
    case Policy::Kind::kPerfect:
      return "perfect model (the floor)";
    case Policy::Kind::kTest:
      return absl::StrCat("step test ", Months(absl::StrCat(policy.months)));
    case Policy::Kind::kOnDemand:
      return absl::StrCat("step test on demand, ", policy.threshold);
    case Policy::Kind::kCorrection:
      break;
  }
  const absl::string_view how =
      policy.estimator == Estimator::kOutputError ? "corrected "
      : policy.estimator == Estimator::kCombined  ? "combined, "
                                                  : "ΔR, ";
  return absl::StrCat(how, Every(policy.every, "change"));
}

std::string Instruction(const Policy& policy) {
  switch (policy.kind) {
    case Policy::Kind::kNever:
      return "Leave the model as it is";
    case Policy::Kind::kPerfect:
      return "Have a perfect model";
    case Policy::Kind::kTest:
      return absl::StrCat("Make a step test ",
                          Months(absl::StrCat(policy.months)));
    case Policy::Kind::kOnDemand:
      return absl::StrCat(
          "Make a step test when the performance index of a set-point change "
          "falls below ",
          policy.threshold);
    case Policy::Kind::kCorrection:
      break;
  }
  const absl::string_view how = policy.estimator == Estimator::kOutputError ? ""
                                : policy.estimator == Estimator::kCombined
                                    ? " by the combined estimator"
                                    : " by ΔR";
  return absl::StrCat("Correct the model", how, " after ",
                      Every(policy.every, "set-point change"));
}

std::string Description(const Policy& policy) {
  switch (policy.kind) {
    case Policy::Kind::kNever:
      return "The controller keeps the model of its commissioning. When: "
             "never.";
    case Policy::Kind::kPerfect:
      return "The controller always has the plant's own model, at no cost: not "
             "a way to work but the floor by which the others are judged.";
    case Policy::Kind::kTest:
      return absl::StrCat(kStepTest, Months(absl::StrCat(policy.months)), ".");
    case Policy::Kind::kOnDemand:
      return absl::StrCat(
          kStepTest,
          "after a set-point change whose performance index, the squared error "
          "that the controller was designed for over the measured one, is "
          "below ",
          policy.threshold, ".");
    case Policy::Kind::kCorrection:
      break;
  }
  return absl::StrCat(
      Estimated(policy.estimator),
      " corrected from routine records of the last set-point changes, without "
      "a test. When: after ",
      Every(policy.every, "set-point change"),
      ", if the records show that the plant has changed.");
}

}  // namespace mle::lifecycle
