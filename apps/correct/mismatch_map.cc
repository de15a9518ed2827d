#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"

namespace mle::correct {
namespace {

using report::FormatSignificant;

// Columns of a page or of a wide terminal.
constexpr int kMostColumns = 12;

// " ± 0.012", of the ratio or the value itself.
std::string HalfInterval(const ParameterEstimate& estimate, double unit) {
  const double half = std::abs(0.5 * (estimate.upper - estimate.lower) / unit);
  return std::isfinite(half) && half > 0.0
             ? absl::StrCat(" ± ", report::FormatHalfWidth(half))
             : "";
}

std::string Ratio(const char* name, const ParameterEstimate& estimate,
                  bool interval) {
  return absl::StrCat(name, " × ",
                      FormatSignificant(estimate.value / estimate.initial, 3),
                      interval ? HalfInterval(estimate, estimate.initial) : "");
}

std::string Shift(const ParameterEstimate& delay, const std::string& unit,
                  bool interval) {
  const double shift = delay.value - delay.initial;
  return absl::StrCat("dead time ", shift < 0.0 ? "−" : "+",
                      FormatSignificant(std::abs(shift), 3),
                      interval ? HalfInterval(delay, 1.0) : "", " ", unit);
}

// Only what left the interval of the initial value.
std::vector<std::string> Changes(const ElementEstimate& element,
                                 const std::string& time_unit, bool intervals) {
  std::vector<std::string> lines;
  if (HasMoved(element.gain) && element.gain.initial != 0.0) {
    lines.push_back(Ratio("gain", element.gain, intervals));
  }
  if (HasMoved(element.time_scale)) {
    lines.push_back(Ratio("time const.", element.time_scale, intervals));
  }
  if (HasMoved(element.delay)) {
    lines.push_back(Shift(element.delay, time_unit, intervals));
  }
  if (lines.empty()) lines.emplace_back("changed");
  return lines;
}

// Whether other values than the initial ones were proposed.
bool IsProposed(const ElementEstimate& element) {
  const auto differs = [](const ParameterEstimate& estimate) {
    return estimate.value != estimate.initial;
  };
  return differs(element.gain) || differs(element.time_scale) ||
         differs(element.delay);
}

// 0: kept; from 5 %, 15 % and 40 % of the response on a level more.
int LevelOfChange(const Result& result, int output, int input) {
  constexpr double kFrom[] = {0.0, 0.05, 0.15, 0.4};
  if (!result.accepted() || !HasChanged(result, output, input)) return 0;
  const double change = result.change.elements(output, input);
  if (!std::isfinite(change)) return report::kTableLevels;
  int level = 1;
  for (int k = 1; k < report::kTableLevels; ++k) {
    if (change >= kFrom[k]) level = k + 1;
  }
  return level;
}

// Whether DescribePair() names a change, and not why there is none.
bool IsNamed(const Result& result, int output, int input) {
  switch (result.information.pair(output, input).state) {
    case PairState::kAbsent:
    case PairState::kNotInformed:
      return false;
    case PairState::kWeak:
    case PairState::kInformed:
      break;
  }
  return (result.accepted() && HasChanged(result, output, input)) ||
         IsProposed(result.proposed.element(output, input));
}

std::string DescribePair(const Result& result, int output, int input) {
  switch (result.information.pair(output, input).state) {
    case PairState::kAbsent:
      return HasOtherShape(result, output, input) ? "new path" : "–";
    case PairState::kNotInformed:
      return result.data.obstacles.empty()
                 ? "not known: the records do not determine it"
                 : "not estimated";
    case PairState::kWeak:
    case PairState::kInformed:
      break;
  }
  if (result.accepted() && HasChanged(result, output, input)) {
    if (!result.corrected.process.has_value()) return "changed";
    return absl::StrJoin(
        Changes(
            result.estimate.fit.output_error.corrected.element(output, input),
            result.initial.time_unit(), true),
        ", ");
  }
  if (IsNamed(result, output, input)) {
    return absl::StrCat(
        absl::StrJoin(Changes(result.proposed.element(output, input),
                              result.initial.time_unit(), true),
                      ", "),
        ": not validated");
  }
  const bool weak =
      result.information.pair(output, input).state == PairState::kWeak;
  return weak ? "no change seen (weak)" : "no change seen";
}

// The relative change of the step response. A change without a finite size
// counts as the largest.
double SizeOfChange(const Result& result, int output, int input) {
  if (LevelOfChange(result, output, input) == 0) return 0.0;
  const double change = result.change.elements(output, input);
  return std::isfinite(change) ? change
                               : std::numeric_limits<double>::infinity();
}

report::Table ChangeList(const Result& result) {
  const ProcessModel& model = result.initial;
  std::vector<std::pair<int, int>> named;
  for (const auto& [i, j] : Pairs(model)) {
    if (IsNamed(result, i, j)) named.emplace_back(i, j);
  }
  std::stable_sort(named.begin(), named.end(),
                   [&](const auto& one, const auto& other) {
                     return SizeOfChange(result, one.first, one.second) >
                            SizeOfChange(result, other.first, other.second);
                   });
  report::Table table{.caption = "Changes by element, the largest first",
                      .columns = {{"element", report::Align::kLeft},
                                  {"step response by"},
                                  {"what has changed", report::Align::kLeft}},
                      .searchable = true};
  for (const auto& [i, j] : named) {
    const double size = SizeOfChange(result, i, j);
    const std::string percent =
        size > 0.0 && std::isfinite(size)
            ? absl::StrCat(FormatSignificant(100.0 * size, 2), " %")
            : "–";
    table.AddRow({PairName(model, i, j), percent, DescribePair(result, i, j)});
    table.levels.push_back({0, LevelOfChange(result, i, j)});
  }
  return table;
}

// A row for each output, with a text for each input.
report::Table PairGrid(const ProcessModel& model,
                       const std::function<std::string(int, int)>& text) {
  report::Table table{.columns = {{"output ← input", report::Align::kLeft}}};
  for (const InputChannel& input : model.inputs()) {
    table.columns.push_back({input.name, report::Align::kCenter});
  }
  for (int i = 0; i < model.num_outputs(); ++i) {
    std::vector<std::string> row = {model.outputs()[i].name};
    for (int j = 0; j < model.num_inputs(); ++j) row.push_back(text(i, j));
    table.AddRow(std::move(row));
  }
  return table;
}

}  // namespace

bool FitsInColumns(const ProcessModel& model) {
  return model.num_inputs() <= kMostColumns;
}

report::Table ChangeMap(const Result& result) {
  if (!FitsInColumns(result.initial)) return ChangeList(result);
  report::Table table = PairGrid(
      result.initial, [&](int i, int j) { return DescribePair(result, i, j); });
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    std::vector<int>& levels = table.levels.emplace_back(1);
    for (int j = 0; j < result.initial.num_inputs(); ++j) {
      levels.push_back(LevelOfChange(result, i, j));
    }
  }
  return table;
}

std::string WhatOthersShow(const Result& result) {
  const ProcessModel& model = result.initial;
  if (FitsInColumns(model)) return "";
  int named = 0;
  int others = 0;
  int weak = 0;
  int unknown = 0;
  for (const auto& [i, j] : Pairs(model)) {
    const PairState state = result.information.pair(i, j).state;
    if (state == PairState::kAbsent) continue;
    if (IsNamed(result, i, j)) {
      ++named;
      continue;
    }
    ++others;
    if (state == PairState::kWeak) ++weak;
    if (state == PairState::kNotInformed) ++unknown;
  }
  if (others == 0) return "";
  if (!result.data.obstacles.empty()) {
    return absl::StrCat("Elements that are not estimated: ", others, ".");
  }
  const std::string all =
      absl::StrCat(named > 0 ? "the other " : "the ", others,
                   others == 1 ? " element" : " elements", " of the model");
  if (unknown == others) {
    return absl::StrCat("The records do not determine ", all, ".");
  }
  const std::string of_weak =
      weak > 0 ? absl::StrCat(" (", weak, " weak)") : "";
  if (unknown == 0) {
    return absl::StrCat("No change is seen in ", all, of_weak, ".");
  }
  return absl::StrCat("Of ", all, " no change is seen in ", others - unknown,
                      of_weak, "; the records do not determine ", unknown, ".");
}

std::string WhyNotEstimated(const Result& result) {
  if (result.data.obstacles.empty()) return "";
  const std::string& why = result.data.obstacles.front().text;
  return absl::StrCat("Not estimated, because: ", why.substr(0, why.find(". ")),
                      why.find(". ") == std::string::npos ? "" : ".");
}

std::vector<std::string> DescribeMismatch(const Result& result, int output,
                                          int input) {
  const OutputErrorCorrection& output_error = result.estimate.fit.output_error;
  const ElementEstimate& full = output_error.full.element(output, input);
  const PairState state = result.information.pair(output, input).state;
  if (state == PairState::kAbsent) {
    return {HasOtherShape(result, output, input) ? "new path" : "–"};
  }
  if (full.state == ElementState::kNotInformed) return {"kept", "not informed"};
  const bool by_structure = result.corrected.process.has_value();
  std::vector<std::string> lines;
  if (!result.accepted() ||
      (by_structure && !output_error.aged(output, input))) {
    lines.emplace_back("kept");
  } else if (by_structure) {
    lines = Changes(output_error.corrected.element(output, input),
                    result.initial.time_unit(), false);
  } else {
    lines.push_back(absl::StrCat(
        "response by ",
        FormatSignificant(100.0 * result.change.elements(output, input), 2),
        " %"));
  }
  if (by_structure && full.state == ElementState::kFitted) {
    const std::string p =
        report::ShortProbability(output_error.element_p_values(output, input));
    lines.push_back(p.front() == '<' ? absl::StrCat("p ", p)
                                     : absl::StrCat("p = ", p));
  }
  if (state != PairState::kInformed) {
    lines.emplace_back(NameOf(state));
  }
  return lines;
}

report::Table MismatchTable(const Result& result) {
  const ProcessModel& model = result.initial;
  const auto text = [&](int i, int j) {
    return absl::StrJoin(DescribeMismatch(result, i, j), "; ");
  };
  report::Table table;
  if (FitsInColumns(model)) {
    table = PairGrid(model, text);
  } else {
    table.columns = {{"element", report::Align::kLeft},
                     {"mismatch", report::Align::kLeft}};
    for (const auto& [i, j] : Pairs(model)) {
      if (result.information.pair(i, j).state == PairState::kAbsent) continue;
      table.AddRow({PairName(model, i, j), text(i, j)});
    }
  }
  table.caption =
      "Mismatch by element: changes, and p-value of the controller's values";
  return table;
}

}  // namespace mle::correct
