#include "apps/correct/headline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/verdict.h"
#include "apps/report/number.h"

namespace mle::correct {
namespace {

using report::FormatSignificant;

// Ratios beyond which a factor reads better than a percentage.
constexpr double kReadablePercent = 2.0;

// "fell by 36 %", "is 3.1 times as large".
std::string DescribeRatio(double ratio) {
  if (ratio > kReadablePercent) {
    return absl::StrCat("is ", FormatSignificant(ratio, 2), " times as large");
  }
  return absl::StrCat(ratio < 1.0 ? "fell by " : "rose by ",
                      FormatSignificant(100.0 * std::abs(ratio - 1.0), 2),
                      " %");
}

// What one sentence can say: the gain before the time constant before the dead
// time.
std::string DescribeElement(const ElementEstimate& element,
                            const std::string& pair,
                            const std::string& time_unit) {
  if (HasMoved(element.gain) && element.gain.initial != 0.0) {
    const double ratio = element.gain.value / element.gain.initial;
    return absl::StrCat(
        "Gain of ", pair, " ",
        ratio < 0.0 ? "changed its sign" : DescribeRatio(ratio));
  }
  if (HasMoved(element.time_scale)) {
    return absl::StrCat(
        "Time constant of ", pair, " ",
        DescribeRatio(element.time_scale.value / element.time_scale.initial));
  }
  if (HasMoved(element.delay)) {
    const double shift = element.delay.value - element.delay.initial;
    return absl::StrCat("Dead time of ", pair, " is ",
                        FormatSignificant(std::abs(shift), 2), " ", time_unit,
                        shift < 0.0 ? " shorter" : " longer");
  }
  return absl::StrCat("Response of ", pair, " changed");
}

std::string DescribeChange(const Result& result, int output, int input) {
  const std::string pair = PairName(result.initial, output, input);
  if (result.corrected.process.has_value()) {
    return DescribeElement(
        result.estimate.fit.output_error.corrected.element(output, input), pair,
        result.initial.time_unit());
  }
  return absl::StrCat(
      "Response of ", pair, " changed by ",
      FormatSignificant(100.0 * result.change.elements(output, input), 2),
      " %");
}

std::string Counted(std::size_t count, const char* one, const char* many) {
  return absl::StrCat(count, " ", count == 1 ? one : many);
}

}  // namespace

std::vector<ElementChange> ElementChanges(const Result& result) {
  std::vector<ElementChange> changes;
  if (result.decision != Decision::kCorrected) return changes;
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    for (int j = 0; j < result.initial.num_inputs(); ++j) {
      if (!HasChanged(result, i, j)) continue;
      changes.push_back(
          {i, j, result.change.elements(i, j), DescribeChange(result, i, j)});
    }
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const ElementChange& a, const ElementChange& b) {
                     return a.size > b.size;
                   });
  return changes;
}

std::string Headline(const Result& result) {
  if (!result.failures.empty()) return "The result is not usable";
  switch (result.decision) {
    case Decision::kNoChange:
      return "The model in the controller still describes the plant";
    case Decision::kCannotTell:
      return "Whether the model has aged cannot be told from these records";
    case Decision::kCorrected:
      break;
  }
  const std::vector<ElementChange> changes = ElementChanges(result);
  if (changes.empty()) return "The model has changed";
  if (changes.size() == 1) return changes[0].text;
  return absl::StrCat(
      changes[0].text, "; ",
      Counted(changes.size() - 1, "other element has", "other elements have"),
      " changed");
}

std::string Instruction(const Result& result) {
  if (!result.failures.empty()) {
    return "Keep the controller's model: a fit is not certified.";
  }
  switch (result.decision) {
    case Decision::kNoChange:
      return "Keep the controller's model.";
    case Decision::kCannotTell:
      return "Keep the controller's model for now.";
    case Decision::kCorrected:
      return "Use the corrected model in the controller.";
  }
  return "";
}

std::vector<std::string> ShortVerdict(const Result& result) {
  std::vector<std::string> lines = {Instruction(result),
                                    absl::StrCat(Headline(result), ".")};
  if (std::string reason = MainReason(result);
      result.decision != Decision::kCorrected && !reason.empty()) {
    lines.push_back(std::move(reason));
  }
  if (std::string worth = WhatItIsWorth(result); !worth.empty()) {
    lines.push_back(std::move(worth));
  }
  std::string more;
  if (!result.warnings.empty()) {
    more = absl::StrCat(" (",
                        Counted(result.warnings.size(), "warning", "warnings"),
                        "; --verbose shows all)");
  }
  lines.push_back(
      absl::StrCat("Report: ", result.request.out, "/report.html", more));
  return lines;
}

}  // namespace mle::correct
