// mle_convert: a model from one form to another, with the error.

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "apps/common/option_table.h"
#include "apps/common/option_values.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/exchange/model_conversion.h"

namespace mle {
namespace {

constexpr char kUsage[] =
    R"(Writes a model in another form, and says how far its step responses are from
those of the model given.

  mle_convert --model=column.csv --form=state_space --out=column.json

Forms: transfer_functions (.json, .mat), element_table (.csv), step_responses
(.csv, .json, .mat), discrete_transfer_functions (.json), state_space (.json);
docs/formats.md has them. Exit codes: 0 done; 1 there is no such model within
the tolerance; 2 bad input or flags.)";

// Differences up to this are due to rounding, and not worth a line.
constexpr double kExact = 1e-9;

struct Request {
  std::string model;
  std::string at;
  std::string out;
  std::string form;
  ModelConversion conversion;
};

void AddOptions(Request& request, OptionTable& table) {
  ModelConversion& to = request.conversion;
  table.Add("Files",
            {{"model", &request.model,
              "Model in any form (JSON, CSV or MAT: docs/formats.md); must be "
              "given."},
             {"out", &request.out,
              "File to be written; its ending says of which type: .json, .csv, "
              ".mat. Must be given."}});
  table.Add(
      "The form",
      {{"form", &request.form,
        "transfer_functions, element_table, step_responses, "
        "discrete_transfer_functions or state_space; empty: that of --model."},
       {"at", &request.at,
        "Of a model with transforms, the linear model at an operating point: "
        "CHANNEL:VALUE,…; channels that are not named are where their "
        "transform has the slope 1. Empty: transforms stay, in forms that have "
        "them."},
       {"interval", &to.interval,
        "Interval of step responses, sample time of discrete forms; 0: that of "
        "the model, if it has one, else a sixtieth of the settling time.",
        "min", kNotNegative},
       {"coefficients", &to.coefficients,
        "Of step responses, 10 or more; 0: up to the settling time.", "",
        kNotNegative},
       {"tolerance", &to.tolerance,
        "Of a state space: the largest error of an element, relative to its "
        "largest response.",
        "", kProbability}});
  table.PutFirst({"model", "form", "out", "interval", "coefficients"});
}

absl::Status Complete(Request& request, const ModelFile& file) {
  ModelConversion& to = request.conversion;
  to.form = file.form;
  if (!request.form.empty()) {
    const std::optional<ModelForm> form = ModelFormOf(request.form);
    if (!form.has_value()) {
      return RefuseOption("form", request.form,
                          "is not a form; must be transfer_functions, "
                          "element_table, step_responses, "
                          "discrete_transfer_functions or state_space");
    }
    to.form = *form;
  }
  if (request.out.ends_with(".csv")) {
    to.type = ModelFileType::kCsv;
  } else if (request.out.ends_with(".mat")) {
    to.type = ModelFileType::kMat;
  } else if (!request.out.ends_with(".json")) {
    return RefuseOption("out", request.out,
                        "must end with .json, .csv or .mat");
  }
  const absl::Status status = to.Validate();
  if (status.ok()) return status;
  return InvalidArgument("--", status.message());
}

// CHANNEL:VALUE,… of channels that the model has.
absl::StatusOr<std::map<std::string, double>> ReadPoint(
    const std::string& text, const ProcessModel& model) {
  std::vector<std::string> names = NamesOf(model.inputs());
  for (std::string& name : NamesOf(model.outputs())) {
    names.push_back(std::move(name));
  }
  std::map<std::string, double> point;
  for (const std::string& part : ParseList(text)) {
    const std::size_t colon = part.rfind(':');
    const std::string name = part.substr(0, colon);
    double value = 0.0;
    if (colon == std::string::npos ||
        !absl::SimpleAtod(part.substr(colon + 1), &value)) {
      return RefuseOption("at", part, "is not of the form CHANNEL:VALUE");
    }
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      return RefuseOption("at", part,
                          absl::StrCat("there is no channel '", name, "'; ",
                                       DidYouMean(name, names), "choose from ",
                                       absl::StrJoin(names, ", ")));
    }
    point[name] = value;
  }
  return point;
}

// The model that is converted: at a point, or where the form has no transforms.
absl::StatusOr<ModelFile> LinearFile(const Request& request, ModelFile file) {
  const ModelConversion& to = request.conversion;
  const bool lost =
      to.form == ModelForm::kStateSpace || to.type == ModelFileType::kMat;
  if (!HasTransforms(file.process)) {
    if (request.at.empty()) return file;
    return RefuseOption("at", request.at,
                        "the model has no transforms: it is the same at every "
                        "operating point");
  }
  if (request.at.empty() && !lost) return file;
  MLE_ASSIGN_OR_RETURN(const auto point, ReadPoint(request.at, file.process));
  absl::StatusOr<ProcessModel> linear = LinearAt(file.process, point);
  if (!linear.ok()) {
    return RefuseOption("at", request.at,
                        std::string(linear.status().message()));
  }
  ModelFile changed;
  changed.type = file.type;
  changed.process = *std::move(linear);
  return changed;
}

// What a linear model lacks: how far gains are others elsewhere.
void PrintRange(const ProcessModel& model) {
  const auto print = [](const std::string& name, const Transform& transform,
                        bool is_output) {
    if (transform.IsNone()) return;
    // Half of the way to where the curve ends or its gain has changed by e.
    const double half =
        0.5 * (transform.curvature != 0.0 ? 1.0 / transform.curvature
                                          : transform.at - transform.zero);
    double low = transform.at - std::abs(half);
    double high = transform.at + std::abs(half);
    if (!transform.points.empty()) {
      low = transform.points.front().first;
      high = transform.points.back().first;
    } else if (transform.high > transform.low) {
      low = transform.low;
      high = transform.high;
    }
    std::vector<std::string> gains;
    for (const double value : {low, high}) {
      const double slope = transform.Slope(value);
      if (!(slope > 0.0 && std::isfinite(slope))) continue;  // a closed valve
      gains.push_back(absl::StrFormat("× %.3g at %.4g",
                                      is_output ? 1.0 / slope : slope, value));
    }
    std::cout << absl::StrFormat(
        "note: a linear model at one point: relative to %s = %.4g its gains "
        "are %s\n",
        name, transform.at, absl::StrJoin(gains, " and "));
  };
  for (const InputChannel& input : model.inputs()) {
    print(input.name, input.transform, false);
  }
  for (const OutputChannel& output : model.outputs()) {
    print(output.name, output.transform, true);
  }
}

void Print(const Request& request, const ModelFile& file,
           const ConvertedModel& converted) {
  for (const std::string& difference : NotableDifferences(file)) {
    std::cout << "note: " << difference << "\n";
  }
  std::cout << request.out << ": " << NameOf(request.conversion.form);
  if (converted.states > 0) std::cout << ", " << converted.states << " states";
  if (converted.interval > 0.0) {
    const std::string& unit = file.process.time_unit();
    std::cout << absl::StrFormat(", every %.6g%s%s", converted.interval,
                                 unit.empty() ? "" : " ", unit);
  }
  const double largest = converted.differences.maxCoeff();
  if (largest <= kExact) {
    std::cout << "; its step responses are those of the model given\n";
    return;
  }
  std::cout << absl::StrFormat(
      "; its step responses differ by at most %.2g %% of their range:\n",
      100.0 * largest);
  for (const auto& [i, j] : Pairs(file.process)) {
    const double difference = converted.differences(i, j);
    if (difference <= kExact) continue;
    std::cout << absl::StrFormat(
        "  %s: %.2g %%\n", PairName(file.process, i, j), 100.0 * difference);
  }
}

absl::StatusOr<int> Run(Request& request, OptionTable& /*table*/) {
  if (request.model.empty() || request.out.empty()) {
    return absl::InvalidArgumentError(
        "--model=FILE and --out=FILE must be given (see --help)");
  }
  MLE_ASSIGN_OR_RETURN(ModelFile given,
                       AboutOption("model", ReadModelFile(request.model)));
  MLE_RETURN_IF_ERROR(Complete(request, given));
  const ProcessModel whole = given.process;
  MLE_ASSIGN_OR_RETURN(const ModelFile file,
                       LinearFile(request, std::move(given)));
  MLE_ASSIGN_OR_RETURN(const ConvertedModel converted,
                       ConvertModel(file, request.conversion));
  MLE_RETURN_IF_ERROR(
      AboutOption("out", WriteFileAtomically(request.out, converted.text)));
  Print(request, file, converted);
  if (!HasTransforms(file.process)) PrintRange(whole);
  return kExitDone;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  return mle::RunCommand(mle::kUsage, mle::AddOptions, mle::Run, argc, argv);
}
