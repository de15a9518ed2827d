#include "mle/exchange/model_file.h"

#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/exchange/mat_file.h"
#include "mle/exchange/model_table.h"
#include "mle/exchange/state_space_correction.h"
#include "mle/exchange/state_space_responses.h"
#include "mle/exchange/step_response_text.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle {
namespace {

absl::StatusOr<ModelFile> OfSteps(absl::StatusOr<StepResponseModel> steps,
                                  std::string_view source) {
  if (steps.ok()) return OfStepResponses(*std::move(steps), source);
  return InvalidArgument(std::string(source), ": ", steps.status().message());
}

// A model in discrete time, described by its step responses and kept as
// `member`.
template <typename Model>
absl::StatusOr<ModelFile> OfSampled(Model model, Model ModelFile::*member,
                                    ModelForm form, std::string_view source) {
  MLE_ASSIGN_OR_RETURN(ModelFile file, OfSteps(StepResponsesOf(model), source));
  file.form = form;
  file.*member = std::move(model);
  return file;
}

absl::StatusOr<ModelFile> ParseJson(std::string_view text,
                                    std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json json,
                       ParseStrictJson(text, source));
  if (json.contains("step_responses")) {
    MLE_ASSIGN_OR_RETURN(StepResponseModel model,
                         ParseStepResponseJson(text, source));
    return OfStepResponses(std::move(model), source);
  }
  if (json.contains("sample_time") && json.contains("elements")) {
    MLE_ASSIGN_OR_RETURN(DiscreteModel model, ParseDiscreteModel(text, source));
    return OfSampled(std::move(model), &ModelFile::discrete,
                     ModelForm::kDiscreteTransferFunctions, source);
  }
  if (json.contains("A") && json.contains("B")) {
    MLE_ASSIGN_OR_RETURN(NamedStateSpace named, ParseStateSpace(text, source));
    return OfStateSpace(std::move(named), source);
  }
  if (json.contains("R") && json.contains("sample_time")) {
    return InvalidArgument(
        std::string(source),
        ": is an ARX model, which is not taken as a process model; take the "
        "model.json beside it");
  }
  ModelFile file;
  MLE_ASSIGN_OR_RETURN(file.process, ParseProcessModel(text, source));
  return file;
}

absl::StatusOr<ModelFile> ParseCsv(std::string_view text,
                                   std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const ModelTable table, ReadModelTable(text, source));
  ModelFile file;
  if (HoldsStepResponses(table)) {
    MLE_ASSIGN_OR_RETURN(StepResponseModel model, StepResponsesOf(table));
    MLE_ASSIGN_OR_RETURN(file, OfStepResponses(std::move(model), source));
  } else {
    file.form = ModelForm::kElementTable;
    MLE_ASSIGN_OR_RETURN(file.elements, ElementsOf(table));
    file.process = file.elements.Process();
  }
  file.type = ModelFileType::kCsv;
  return file;
}

absl::StatusOr<ModelFile> FromMat(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(MatModel model, ReadMatModel(path));
  ModelFile file;
  if (auto* steps = std::get_if<StepResponseModel>(&model)) {
    MLE_ASSIGN_OR_RETURN(file, OfStepResponses(std::move(*steps), path));
  } else {
    file.process = std::get<ProcessModel>(std::move(model));
  }
  file.type = ModelFileType::kMat;
  return file;
}

}  // namespace

std::string_view NameOf(ModelForm form) {
  switch (form) {
    case ModelForm::kTransferFunctions:
      return "transfer_functions";
    case ModelForm::kElementTable:
      return "element_table";
    case ModelForm::kStepResponses:
      return "step_responses";
    case ModelForm::kDiscreteTransferFunctions:
      return "discrete_transfer_functions";
    case ModelForm::kStateSpace:
      return "state_space";
  }
  return "";
}

absl::StatusOr<ModelFile> ParseModelFile(std::string_view text,
                                         std::string_view source) {
  // A file named as JSON is judged as JSON, whatever it holds.
  return IsJsonText(text) || source.ends_with(".json") ? ParseJson(text, source)
                                                       : ParseCsv(text, source);
}

absl::StatusOr<ModelFile> ReadModelFile(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  if (IsMatFile(text)) return FromMat(path);
  return ParseModelFile(text, path);
}

absl::StatusOr<ModelFile> OfStepResponses(StepResponseModel model,
                                          std::string_view source) {
  absl::StatusOr<Description> description = Describe(model);
  if (!description.ok()) {
    return InvalidArgument(std::string(source), ": ",
                           description.status().message());
  }
  ModelFile file;
  file.form = ModelForm::kStepResponses;
  file.process = std::move(description->process);
  file.descriptions = std::move(description->pairs);
  file.step_responses = std::move(model);
  return file;
}

absl::StatusOr<ModelFile> OfStateSpace(NamedStateSpace named,
                                       std::string_view source) {
  return OfSampled(std::move(named), &ModelFile::state_space,
                   ModelForm::kStateSpace, source);
}

StepResponseModel CorrectedStepResponses(const ModelFile& file,
                                         const ProcessModel& corrected) {
  const StepResponseModel& given = file.step_responses;
  const int samples = given.length() + 1;
  return WithChange(given,
                    file.process.ComputeStepResponse(given.interval, samples),
                    corrected.ComputeStepResponse(given.interval, samples));
}

absl::StatusOr<NamedStateSpace> CorrectedStateSpace(
    const ModelFile& file, const ProcessModel& corrected) {
  NamedStateSpace changed = file.state_space;
  MLE_ASSIGN_OR_RETURN(changed.system, WithChange(file.state_space.system,
                                                  file.process, corrected));
  // The accuracy stated in the file is that of the states given.
  if (changed.system.order() != file.state_space.system.order()) {
    changed.accuracy.reset();
  }
  return changed;
}

std::vector<std::string> NotableDifferences(const ModelFile& file) {
  std::vector<std::string> differences;
  if (const int left_out = file.state_space.unreached_states; left_out > 0) {
    differences.push_back(absl::StrCat(
        left_out, left_out == 1 ? " state is" : " states are",
        " reached by no input (the controller's model of disturbances, "
        "usually) and left out: responses to inputs do not know ",
        left_out == 1 ? "it." : "them."));
  }
  for (const PairDescription& pair : file.descriptions) {
    if (pair.moves_on > kAcceptedDifference) {
      differences.push_back(absl::StrFormat(
          "%s: its step response has not settled at the last coefficient; the "
          "transfer function through it goes on from there by %.2g %% of the "
          "range, which its gain rests on. Give more coefficients.",
          PairName(file.process, pair.output, pair.input),
          100.0 * pair.moves_on));
    }
    if (pair.largest_difference <= kUnremarkableDifference) continue;
    differences.push_back(absl::StrCat(
        "The transfer function that describes the step response differs from "
        "it: ",
        DifferenceText(file.process, pair), "."));
  }
  return differences;
}

std::string CorrectedName(const ModelFile& file) {
  if (file.form == ModelForm::kTransferFunctions) return "";
  switch (file.type) {
    case ModelFileType::kJson:
      return "model_corrected.json";
    case ModelFileType::kCsv:
      return "model_corrected.csv";
    case ModelFileType::kMat:
      return "model_corrected.mat";
  }
  return "";
}

namespace {

// Transforms are of the channels, whatever form the elements have.
void TakeTransforms(const ProcessModel& from, ProcessModel& to) {
  for (int j = 0; j < from.num_inputs(); ++j) {
    to.set_input_transform(j, from.inputs()[j].transform);
  }
  for (int i = 0; i < from.num_outputs(); ++i) {
    to.set_output_transform(i, from.outputs()[i].transform);
  }
}

}  // namespace

absl::StatusOr<FormattedModel> FormatCorrected(const ModelFile& file,
                                               const ProcessModel& corrected) {
  FormattedModel formatted;
  formatted.name = CorrectedName(file);
  if (file.form == ModelForm::kElementTable) {
    ElementTable changed =
        ForTyping(file.elements, WithElements(file.elements, corrected));
    TakeTransforms(corrected, changed.channels);
    formatted.text = FormatElementTable(changed);
    for (const ElementRow& row : changed.rows) {
      if (row.largest_difference == 0.0) continue;
      formatted.differences.push_back(
          {.output = row.output,
           .input = row.input,
           .largest_difference = row.largest_difference});
    }
    return formatted;
  }
  if (file.form == ModelForm::kDiscreteTransferFunctions) {
    MLE_ASSIGN_OR_RETURN(DiscreteModel changed,
                         WithChange(file.discrete, file.process, corrected));
    TakeTransforms(corrected, changed.channels);
    formatted.text = FormatDiscreteModel(changed);
    return formatted;
  }
  if (file.form == ModelForm::kStateSpace) {
    MLE_ASSIGN_OR_RETURN(const NamedStateSpace changed,
                         CorrectedStateSpace(file, corrected));
    formatted.text = FormatStateSpace(changed);
    return formatted;
  }
  StepResponseModel changed = CorrectedStepResponses(file, corrected);
  TakeTransforms(corrected, changed.channels);
  if (file.type == ModelFileType::kMat) {
    MLE_ASSIGN_OR_RETURN(formatted.text, FormatMat(changed));
  } else if (file.type == ModelFileType::kCsv) {
    formatted.text = FormatStepResponseCsv(changed);
  } else {
    formatted.text = FormatStepResponseJson(changed);
  }
  return formatted;
}

}  // namespace mle
