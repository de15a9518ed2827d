#include "apps/lifecycle/policy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "apps/common/option_values.h"
#include "mle/base/status.h"

namespace mle::lifecycle {
namespace {

constexpr double kMaxChanges = 1e6;

absl::Status WrongPart(const std::string& part, const std::string& why) {
  return InvalidArgument("'", part, "': ", why);
}

// The number after the colon; `none` where there is no colon.
absl::StatusOr<double> Argument(const std::string& part, double none) {
  const std::size_t colon = part.find(':');
  if (colon == std::string::npos) return none;
  double value = 0.0;
  if (!absl::SimpleAtod(part.substr(colon + 1), &value) ||
      !std::isfinite(value)) {
    return WrongPart(
        part, absl::StrCat("'", part.substr(colon + 1), "' is not a number"));
  }
  return value;
}

absl::StatusOr<Policy> ParseCorrection(const std::string& part,
                                       Estimator estimator) {
  Policy policy;
  policy.kind = Policy::Kind::kCorrection;
  policy.estimator = estimator;
  MLE_ASSIGN_OR_RETURN(const double every, Argument(part, 1.0));
  if (!(every >= 1.0) || every > kMaxChanges || every != std::floor(every)) {
    return WrongPart(
        part,
        "after the colon a whole number of set-point changes ≥ 1 is needed");
  }
  policy.every = static_cast<int>(every);
  policy.name = absl::StrCat(std::string(NameOf(estimator)), ":", policy.every);
  return policy;
}

absl::StatusOr<Policy> ParsePolicy(const std::string& part) {
  const std::string kind = part.substr(0, part.find(':'));
  for (const auto estimator : {Estimator::kOutputError, Estimator::kArx}) {
    if (kind == NameOf(estimator)) {
      return ParseCorrection(part, estimator);
    }
  }
  Policy policy;
  policy.name = part;
  if (kind == "never" || kind == "perfect") {
    if (kind != part) return WrongPart(part, "takes no number");
    policy.kind =
        kind == "never" ? Policy::Kind::kNever : Policy::Kind::kPerfect;
    return policy;
  }
  if (kind == "test") {
    policy.kind = Policy::Kind::kTest;
    MLE_ASSIGN_OR_RETURN(policy.months, Argument(part, 0.0));
    if (policy.months > 0.0) return policy;
    return WrongPart(part,
                     "after a colon the months from test to test are needed, "
                     "> 0: test:12");
  }
  if (kind == "on_demand") {
    policy.kind = Policy::Kind::kOnDemand;
    MLE_ASSIGN_OR_RETURN(policy.threshold, Argument(part, 0.0));
    if (policy.threshold > 0.0 && policy.threshold < 1.0) return policy;
    return WrongPart(part,
                     "after a colon a threshold of the performance index "
                     "between 0 and 1 is needed: on_demand:0.7");
  }
  return WrongPart(
      part, absl::StrCat(DidYouMean(kind, {"never", "perfect", "output_error",
                                           "arx", "test", "on_demand"}),
                         "choose from never, perfect, output_error:N, arx:N, "
                         "test:MONTHS and on_demand:THRESHOLD"));
}

}  // namespace

absl::StatusOr<std::vector<Policy>> ParsePolicies(std::string_view text) {
  std::vector<Policy> policies;
  for (const std::string& part : ParseList(text)) {
    MLE_ASSIGN_OR_RETURN(Policy policy, ParsePolicy(part));
    const bool known =
        std::any_of(policies.begin(), policies.end(),
                    [&](const Policy& p) { return p.name == policy.name; });
    if (known) return WrongPart(part, "is duplicated");
    policies.push_back(std::move(policy));
  }
  if (policies.empty()) {
    return absl::InvalidArgumentError("names no policy");
  }
  return policies;
}

std::size_t PlaceOf(Policy::Kind kind, const std::vector<Policy>& policies) {
  const auto found =
      std::find_if(policies.begin(), policies.end(),
                   [&](const Policy& policy) { return policy.kind == kind; });
  return static_cast<std::size_t>(found - policies.begin());
}

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

constexpr char kStepTest[] =
    "The controller is off, each input goes up and back, and the model is "
    "corrected from that record. When: ";

// What a correction by this estimator is called in tables and in instructions,
// and what it estimates: the start of a sentence.
struct EstimatorWords {
  const char* shown;
  const char* by;
  const char* estimated;
};

EstimatorWords WordsFor(Estimator estimator) {
  switch (estimator) {
    case Estimator::kOutputError:
      break;
    case Estimator::kArx:
      return {"ΔR, ", " by ΔR",
              "Whole step responses (ΔR, around the model of the "
              "commissioning) are"};
  }
  return {"corrected ", "", "Gains, time constants and dead times are"};
}

struct PolicyWords {
  std::string shown;
  std::string instruction;
  std::string description;
};

PolicyWords WordsOf(const Policy& policy) {
  switch (policy.kind) {
    case Policy::Kind::kNever:
      return {"never updated", "Leave the model as it is",
              "The controller keeps the model of its commissioning. When: "
              "never."};
    case Policy::Kind::kPerfect:
      return {
          "perfect model (the reference)", "Have a perfect model",
          "The controller always has the plant's own model, at no cost: not a "
          "way to work but the reference by which the others are judged."};
    case Policy::Kind::kTest: {
      const std::string when = Months(absl::StrCat(policy.months));
      return {absl::StrCat("step test ", when),
              absl::StrCat("Make a step test ", when),
              absl::StrCat(kStepTest, when, ".")};
    }
    case Policy::Kind::kOnDemand:
      return {absl::StrCat("step test on demand, ", policy.threshold),
              absl::StrCat("Make a step test when the performance index of a "
                           "set-point change falls below ",
                           policy.threshold),
              absl::StrCat(kStepTest,
                           "after a set-point change whose performance index, "
                           "the squared error that the controller was designed "
                           "for over the measured one, is below ",
                           policy.threshold, ".")};
    case Policy::Kind::kCorrection:
      break;
  }
  const EstimatorWords words = WordsFor(policy.estimator);
  const std::string when = Every(policy.every, "set-point change");
  return {
      absl::StrCat(words.shown, Every(policy.every, "change")),
      absl::StrCat("Correct the model", words.by, " after ", when),
      absl::StrCat(words.estimated,
                   " corrected from routine records of the last set-point "
                   "changes, without a test. When: after ",
                   when, ", if the records show that the plant has changed.")};
}

}  // namespace

std::string ShortName(const Policy& policy) { return WordsOf(policy).shown; }

std::string Instruction(const Policy& policy) {
  return WordsOf(policy).instruction;
}

std::string Description(const Policy& policy) {
  return WordsOf(policy).description;
}

}  // namespace mle::lifecycle
