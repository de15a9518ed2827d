#include "mle/exchange/element_columns.h"

#include <algorithm>
#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/str_replace.h"
#include "mle/data/civil_time.h"
#include "mle/data/csv_numbers.h"

namespace mle {
namespace {

// The first name of each is the one that is written.
const std::array<std::vector<std::string_view>, kNumElementColumns>& Names() {
  static const auto* const kNames =
      new std::array<std::vector<std::string_view>, kNumElementColumns>{{
          {"output", "cv", "controlled variable"},
          {"input", "mv", "manipulated variable"},
          {"gain", "k", "kp", "static gain", "steady state gain"},
          {"time constant", "t", "t1", "tau", "tau1", "time constant 1",
           "first time constant", "lag"},
          {"second time constant", "t2", "tau2", "time constant 2",
           "second lag"},
          {"lead", "lead time", "lead time constant"},
          {"dead time", "delay", "deadtime", "time delay", "theta", "l", "td"},
          {"integrating", "integrator", "ramp", "type"},
          {"largest difference"},
      }};
  return *kNames;
}

// Where the bracket of a unit begins; where there is none, the end.
std::size_t UnitBegin(std::string_view field) {
  if (!field.ends_with(')') && !field.ends_with(']')) return field.size();
  const std::size_t begin = field.find_first_of("([");
  return begin == 0 || begin == std::string_view::npos ? field.size() : begin;
}

// "Dead_time [min]" is "dead time".
std::string KeyOf(std::string_view field) {
  const std::string folded = FoldedKey(field);
  const std::string_view key = folded;
  return std::string(TrimCsvField(key.substr(0, UnitBegin(key))));
}

template <std::size_t N>
bool IsAmong(const std::array<std::string_view, N>& words,
             std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

std::string FoldedKey(std::string_view text) {
  return absl::StrReplaceAll(absl::AsciiStrToLower(std::string(text)),
                             {{"_", " "}});
}

const char* NameOf(ElementColumn column) {
  return Names()[column].front().data();
}

std::optional<ElementColumn> ElementColumnOf(std::string_view field) {
  const std::string key = KeyOf(field);
  for (int c = 0; c < kNumElementColumns; ++c) {
    const std::vector<std::string_view>& names = Names()[c];
    if (std::find(names.begin(), names.end(), key) != names.end()) {
      return static_cast<ElementColumn>(c);
    }
  }
  return std::nullopt;
}

std::string UnitInHeader(std::string_view field) {
  const std::string_view trimmed = TrimCsvField(field);
  const std::size_t begin = UnitBegin(trimmed);
  if (begin == trimmed.size()) return "";
  return std::string(
      TrimCsvField(trimmed.substr(begin + 1, trimmed.size() - begin - 2)));
}

bool IsDampingField(std::string_view field) {
  constexpr std::array<std::string_view, 8> kDampings = {
      "zeta",          "ζ",       "xi",   "ξ",
      "damping ratio", "damping", "damp", "damping factor"};
  return IsAmong(kDampings, KeyOf(field));
}

std::string TimeUnitInHeader(const std::vector<std::string>& fields) {
  std::string found;
  for (const std::string& field : fields) {
    const std::optional<ElementColumn> column = ElementColumnOf(field);
    if (!column.has_value() || !IsTimeColumn(*column)) continue;
    const std::string unit = UnitInHeader(field);
    const std::optional<double> seconds = SecondsPerUnit(unit);
    if (!seconds.has_value()) continue;
    if (found.empty()) found = unit;
    if (seconds != SecondsPerUnit(found)) return "";
  }
  return found;
}

bool IsElementHeader(const std::vector<std::string>& fields) {
  const auto has = [&](ElementColumn column) {
    return std::any_of(fields.begin(), fields.end(),
                       [column](const std::string& field) {
                         return ElementColumnOf(field) == column;
                       });
  };
  return has(kOutputColumn) && has(kInputColumn) && has(kGainColumn);
}

std::optional<bool> IsIntegratingField(std::string_view field) {
  constexpr std::array<std::string_view, 9> kYes = {
      "yes",         "y",          "true", "1",    "x",
      "integrating", "integrator", "ramp", "level"};
  constexpr std::array<std::string_view, 14> kNo = {"",
                                                    "no",
                                                    "n",
                                                    "false",
                                                    "0",
                                                    "-",
                                                    "stable",
                                                    "steady",
                                                    "self-regulating",
                                                    "self regulating",
                                                    "first order",
                                                    "second order",
                                                    "fopdt",
                                                    "sopdt"};
  const std::string key = FoldedKey(field);
  if (IsAmong(kYes, key)) return true;
  if (IsAmong(kNo, key)) return false;
  return std::nullopt;
}

}  // namespace mle
