// The text about a configuration error: what it seems to be, and the lines of
// the mapping of tags, or the option, that correct it.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "mle/maintain/operator_mistakes.h"

namespace mle {
namespace {

using Kind = OperatorMistake::Kind;

constexpr double kFahrenheit = 1.8;
constexpr double kFahrenheitOffset = 32.0;

bool IsNear(double factor, double other) {
  return std::abs(std::log(std::abs(factor / other))) < 1e-9;
}

bool IsFahrenheit(double factor) {
  return IsNear(factor, kFahrenheit) || IsNear(factor, 1.0 / kFahrenheit);
}

std::string FactorText(double factor) {
  if (factor >= 1.0) return absl::StrFormat("%.4g", factor);
  return absl::StrFormat("1/%.4g", 1.0 / factor);
}

std::vector<std::string> NamesOf(const OperatorMistake& mistake,
                                 const ProcessModel& model) {
  std::vector<std::string> names;
  for (const int c : mistake.channels) {
    names.push_back(mistake.outputs ? model.outputs()[c].name
                                    : model.inputs()[c].name);
  }
  return names;
}

std::string WhatItIs(const OperatorMistake& mistake,
                     const ProcessModel& model) {
  const std::string tags = absl::StrJoin(NamesOf(mistake, model), " and ");
  switch (mistake.kind) {
    case Kind::kExchanged:
      return absl::StrCat("The tags of ", tags, " seem to be swapped.");
    case Kind::kSign:
      return absl::StrCat("The sign of ", tags,
                          " seems to be reversed, in the tag or in the model.");
    case Kind::kFactor:
      return absl::StrCat("The unit of ", tags,
                          " does not seem to be that of the model: the gains "
                          "in the records are ",
                          FactorText(mistake.factor), " times the model's",
                          IsFahrenheit(mistake.factor)
                              ? " (degrees Fahrenheit and Celsius, say)."
                              : ".");
    case Kind::kTimeUnit:
      return absl::StrCat(
          "The model's time unit does not seem to be that of the records: its "
          "times fit when multiplied by ",
          FactorText(mistake.factor), ".");
  }
  return "";
}

// The unit whose length is `factor` times that of `unit`; empty: not known.
std::string OtherUnit(std::string_view unit, double factor) {
  constexpr std::array<std::pair<std::string_view, double>, 3> kUnits = {
      {{"s", 1.0}, {"min", 60.0}, {"h", 3600.0}}};
  for (const auto& [name, seconds] : kUnits) {
    if (name != unit) continue;
    for (const auto& [other, length] : kUnits) {
      if (IsNear(length, factor * seconds)) return std::string(other);
    }
  }
  return "";
}

std::string OnTimes(double factor, const ProcessModel& model) {
  const std::string unit = OtherUnit(model.time_unit(), factor);
  const std::string read = OtherUnit(model.time_unit(), 1.0 / factor);
  std::vector<std::string> ways;
  if (!unit.empty()) {
    ways.push_back(absl::StrCat("\"time_unit\": \"", unit, "\" in the model"));
  }
  if (!read.empty()) {
    ways.push_back(absl::StrCat("number_unit = ", read,
                                " where the records have times as numbers"));
  }
  if (ways.empty()) return "";
  return absl::StrCat(" Correct it with ", absl::StrJoin(ways, ", or with "),
                      ".");
}

// A tag in another unit or with another sign: its gains were `factor` times the
// model's.
TagMapping InUnit(TagMapping tag, bool is_output, double factor) {
  const double scale = is_output ? 1.0 / factor : factor;
  double offset = 0.0;
  if (IsNear(scale, kFahrenheit) && scale > 0.0) offset = kFahrenheitOffset;
  if (IsNear(scale, 1.0 / kFahrenheit) && scale > 0.0) {
    offset = -kFahrenheitOffset / kFahrenheit;
  }
  tag.scale *= scale;
  tag.offset = scale * tag.offset + offset;
  return tag;
}

// The same tags, those of the mistake corrected.
std::vector<TagMapping> Corrected(const OperatorMistake& mistake,
                                  const ProcessModel& model,
                                  std::vector<TagMapping> tags) {
  const std::vector<std::string> names = NamesOf(mistake, model);
  for (TagMapping& tag : tags) {
    if (mistake.kind == Kind::kExchanged) {
      for (const auto& [from, to] : {std::pair(0, 1), std::pair(1, 0)}) {
        if (tag.channel != names[from]) continue;
        tag.channel = names[to];
        break;
      }
      continue;
    }
    const bool concerned =
        std::any_of(names.begin(), names.end(), [&](const std::string& name) {
          return tag.channel == name ||
                 (mistake.outputs && tag.channel == SetPointName(name));
        });
    if (concerned)
      tag = InUnit(std::move(tag), mistake.outputs, mistake.factor);
  }
  return tags;
}

bool AreSame(const TagMapping& a, const TagMapping& b) {
  return a.channel == b.channel && a.scale == b.scale && a.offset == b.offset;
}

// The line of a file of tags.
std::string Line(const TagMapping& tag) {
  std::string line = absl::StrCat(tag.tag, ",", tag.channel);
  const bool has_offset = tag.offset != 0.0;
  if (tag.scale != 1.0 || has_offset) {
    absl::StrAppendFormat(&line, ",%.6g", tag.scale);
  }
  if (has_offset) absl::StrAppendFormat(&line, ",%.6g", tag.offset);
  return line;
}

// The same as a part of the option.
std::string Part(const TagMapping& tag) {
  std::string part = absl::StrCat(tag.tag, "=", tag.channel);
  const bool has_offset = tag.offset != 0.0;
  if (tag.scale != 1.0 || has_offset) {
    absl::StrAppendFormat(&part, "*%.6g", tag.scale);
  }
  if (has_offset) absl::StrAppendFormat(&part, "%+.6g", tag.offset);
  return part;
}

std::string OnTags(const std::vector<TagMapping>& tags,
                   const std::vector<TagMapping>& corrected) {
  std::vector<std::string> lines;
  std::vector<std::string> parts;
  bool differ = false;
  for (std::size_t t = 0; t < tags.size(); ++t) {
    const bool same = AreSame(tags[t], corrected[t]);
    if (!tags[t].place.empty()) {
      if (same) continue;
      lines.push_back(absl::StrCat(tags[t].place, ": ", Line(corrected[t])));
      continue;
    }
    // Columns that have the names of their channels need no mapping.
    if (same && corrected[t].tag == corrected[t].channel &&
        corrected[t].scale == 1.0 && corrected[t].offset == 0.0) {
      continue;
    }
    differ = differ || !same;
    parts.push_back(Part(corrected[t]));
  }
  if (differ) {
    lines.push_back(absl::StrCat("tags = '", absl::StrJoin(parts, ","), "'"));
  }
  if (lines.empty()) return "";
  return absl::StrCat(" Correct it with ", absl::StrJoin(lines, "; "), ".");
}

}  // namespace

std::string OperatorMistake::Describe(
    const ProcessModel& model, const std::vector<TagMapping>& tags) const {
  std::string text = WhatItIs(*this, model);
  text += kind == Kind::kTimeUnit ? OnTimes(factor, model)
                                  : OnTags(tags, Corrected(*this, model, tags));
  if (ambiguous && kind != Kind::kSign) {
    text += " Only one element tells, which may as well have aged.";
  }
  return text;
}

}  // namespace mle
