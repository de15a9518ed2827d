#include "apps/common/option_values.h"

#include <cmath>
#include <memory>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "mle/base/absl_view.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

// A second name is worth showing where it is about as near as the first.
constexpr int kAlike = 2;

}  // namespace

std::string DidYouMean(std::string_view given,
                       const std::vector<std::string>& known) {
  if (given.empty()) return "";
  const std::vector<std::string> near = NearestNames(given, known, 2);
  if (near.empty()) return "";
  std::string text = "did you mean '" + near[0] + "'";
  const auto distance = [&](std::size_t k) {
    return NameDistance(given, near[k]);
  };
  if (near.size() > 1 && distance(1) <= distance(0) + kAlike)
    text += " or '" + near[1] + "'";
  return text + "? ";
}

namespace {

using Eigen::VectorXd;

enum class Channels { kOutputs, kInputs };
using Setter = std::function<void(const VectorXd&)>;

// "a, b and c".
std::string Enumerated(const std::vector<std::string>& names) {
  if (names.size() < 2) return absl::StrJoin(names, "");
  return absl::StrCat(absl::StrJoin(names.begin(), names.end() - 1, ", "),
                      " and ", names.back());
}

absl::StatusOr<double> ParseNumber(absl::string_view text,
                                   const NumberRange& range) {
  const std::string shown(text);
  double number = 0.0;
  if (!absl::SimpleAtod(text, &number) || !std::isfinite(number)) {
    return InvalidArgument("'", shown, "' is not a number");
  }
  if (range.Contains(number)) return number;
  return InvalidArgument("'", shown, "' must be ", range.Describe());
}

// A list that may be blank, and one in which `none` is a number.
struct Blank {
  bool allowed = false;
  std::optional<double> none = {};
};

TextValue ForEach(Channels channels, std::string text, Blank blank,
                  const Setter& set) {
  const auto values = std::make_shared<VectorXd>();
  return {.text = std::move(text),
          .read =
              [=](const std::string& given, const NumberRange& range) {
                values->resize(0);
                if (!blank.allowed || !ParseList(given).empty()) {
                  MLE_ASSIGN_OR_RETURN(*values,
                                       ParseNumbers(given, range, blank.none));
                }
                set(*values);
                return absl::OkStatus();
              },
          .fit =
              [=](int outputs, int inputs) {
                MLE_ASSIGN_OR_RETURN(
                    const VectorXd all,
                    FitToChannels(*values, channels == Channels::kOutputs
                                               ? outputs
                                               : inputs));
                set(all);
                return absl::OkStatus();
              }};
}

Setter SetVector(VectorXd* values) {
  return [values](const VectorXd& all) { *values = all; };
}

Setter SetDiagonal(Eigen::MatrixXd* diagonal) {
  return [diagonal](const VectorXd& all) { *diagonal = all.asDiagonal(); };
}

}  // namespace

TextValue OneOfNames(std::string text, const std::vector<ChoiceText>& choices,
                     std::function<void(std::size_t)> set) {
  std::vector<std::string> names;
  std::vector<std::string> described;
  for (const ChoiceText& choice : choices) {
    names.push_back(choice.name);
    described.push_back(
        choice.meaning.empty()
            ? choice.name
            : absl::StrCat(choice.name, " (", choice.meaning, ")"));
  }
  return {.text = std::move(text),
          .read =
              [names, set = std::move(set)](const std::string& given,
                                            const NumberRange&) {
                for (std::size_t i = 0; i < names.size(); ++i) {
                  if (names[i] != given) continue;
                  set(i);
                  return absl::OkStatus();
                }
                return InvalidArgument(DidYouMean(given, names), "choose from ",
                                       Enumerated(names));
              },
          .known = absl::StrJoin(described, ", "),
          .names = names};
}

TextValue Words(std::vector<std::string>* words) {
  return {.text = absl::StrJoin(*words, ","),
          .read = [words](const std::string& given, const NumberRange&) {
            *words = ParseList(given);
            return absl::OkStatus();
          }};
}

TextValue Numbers(std::vector<double>* numbers) {
  return {
      .text = absl::StrJoin(*numbers, ","),
      .read = [numbers](const std::string& given, const NumberRange& range) {
        numbers->clear();
        for (const std::string& part : ParseList(given)) {
          MLE_ASSIGN_OR_RETURN(const double number, ParseNumber(part, range));
          numbers->push_back(number);
        }
        return absl::OkStatus();
      }};
}

TextValue OptionalNumber(std::optional<double>* number) {
  return {.read = [number](const std::string& given, const NumberRange& range) {
    number->reset();
    if (ParseList(given).empty()) return absl::OkStatus();
    MLE_ASSIGN_OR_RETURN(*number, ParseNumber(given, range));
    return absl::OkStatus();
  }};
}

TextValue ZeroForInfinity(double* number) {
  return {.text = *number == kInfinity ? "0" : absl::StrCat(*number),
          .read = [number](const std::string& given, const NumberRange& range) {
            double zero = 1.0;
            if (absl::SimpleAtod(given, &zero) && zero == 0.0) {
              *number = kInfinity;
              return absl::OkStatus();
            }
            MLE_ASSIGN_OR_RETURN(*number, ParseNumber(given, range));
            return absl::OkStatus();
          }};
}

TextValue ForEachOutput(VectorXd* values, std::string text) {
  return ForEach(Channels::kOutputs, std::move(text), {}, SetVector(values));
}

TextValue ForEachOutput(Eigen::MatrixXd* diagonal, std::string text) {
  return ForEach(Channels::kOutputs, std::move(text), {},
                 SetDiagonal(diagonal));
}

TextValue ForEachInput(VectorXd* values, std::string text) {
  return ForEach(Channels::kInputs, std::move(text), {}, SetVector(values));
}

TextValue ForEachInput(Eigen::MatrixXd* diagonal, std::string text) {
  return ForEach(Channels::kInputs, std::move(text), {}, SetDiagonal(diagonal));
}

TextValue OptionalForEachOutput(VectorXd* values) {
  return ForEach(Channels::kOutputs, "", {true}, SetVector(values));
}

TextValue OptionalForEachInput(VectorXd* values) {
  return ForEach(Channels::kInputs, "", {true}, SetVector(values));
}

TextValue LimitOfEachOutput(VectorXd* limits, double unlimited) {
  return ForEach(Channels::kOutputs, "", {true, unlimited}, SetVector(limits));
}

TextValue LimitOfEachInput(VectorXd* limits, double unlimited) {
  return ForEach(Channels::kInputs, "", {true, unlimited}, SetVector(limits));
}

std::vector<std::string> ParseList(std::string_view text) {
  std::vector<std::string> parts;
  for (const absl::string_view part :
       absl::StrSplit(AbslView(text), ',', absl::SkipWhitespace())) {
    parts.emplace_back(absl::StripAsciiWhitespace(part));
  }
  return parts;
}

absl::StatusOr<VectorXd> ParseNumbers(std::string_view text,
                                      const NumberRange& range,
                                      std::optional<double> unlimited) {
  // Empty parts stay: they are typing errors.
  const std::vector<std::string> parts = absl::StrSplit(AbslView(text), ',');
  VectorXd numbers(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double& number = numbers[static_cast<Eigen::Index>(i)];
    if (unlimited.has_value() &&
        absl::StripAsciiWhitespace(parts[i]) == "none") {
      number = *unlimited;
      continue;
    }
    const absl::StatusOr<double> parsed = ParseNumber(parts[i], range);
    if (!parsed.ok()) {
      return InvalidArgument(
          parsed.status().message(),
          unlimited.has_value() ? ", or none for no limit" : "");
    }
    number = *parsed;
  }
  return numbers;
}

absl::StatusOr<VectorXd> FitToChannels(const VectorXd& values, int count) {
  if (values.size() == 1) return VectorXd::Constant(count, values[0]).eval();
  if (values.size() == 0 || values.size() == count) return values;
  return InvalidArgument(values.size(),
                         " values; one is needed, or one for each of ", count,
                         " channels");
}

}  // namespace mle
