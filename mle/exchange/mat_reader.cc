#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/exchange/mat_file.h"
#include "mle/exchange/mat_variables.h"

namespace mle {
namespace {

class MatReader {
 public:
  MatReader(mat_t* mat, std::string path) : mat_(mat), path_(std::move(path)) {}

  absl::StatusOr<MatModel> Read();

 private:
  absl::Status Fault(std::string_view name, std::string_view what) const {
    return InvalidArgument(path_, ": variable '", std::string(name), "' ",
                           std::string(what));
  }
  bool Has(const char* name) const {
    return Variable(Mat_VarReadInfo(mat_, name)) != nullptr;
  }
  absl::StatusOr<std::string> TextOf(const char* name) const;
  absl::StatusOr<std::vector<std::string>> TextsOf(const char* name) const;
  // Real numbers of these sizes, column by column.
  absl::StatusOr<std::vector<double>> NumbersOf(const char* name,
                                                const Sizes& sizes) const;
  absl::StatusOr<std::vector<double>> NumbersIn(const char* name,
                                                const matvar_t* variable) const;
  absl::StatusOr<ProcessModel> ReadChannels() const;
  absl::Status ReadElements(ProcessModel& model) const;
  absl::StatusOr<StepResponseModel> ReadSteps(ProcessModel channels) const;

  mat_t* mat_;
  std::string path_;
};

void AppendUtf8(std::uint32_t code, std::string& text) {
  if (code < 0x80) {
    text += static_cast<char>(code);
  } else if (code < 0x800) {
    text += static_cast<char>(0xC0 | code >> 6);
    text += static_cast<char>(0x80 | (code & 0x3F));
  } else {
    text += static_cast<char>(0xE0 | code >> 12);
    text += static_cast<char>(0x80 | (code >> 6 & 0x3F));
    text += static_cast<char>(0x80 | (code & 0x3F));
  }
}

// Limit of the characters of a name or a unit: a damaged file may state any
// number.
constexpr std::size_t kMostCharacters = 10'000;

// A row of characters; nothing for other variables.
bool TextIn(const matvar_t* variable, std::string& text) {
  text.clear();
  if (variable == nullptr || variable->class_type != MAT_C_CHAR ||
      variable->rank != 2 || variable->dims[0] > 1) {
    return false;
  }
  if (variable->dims[0] * variable->dims[1] == 0) return true;
  if (variable->data == nullptr || variable->data_size < 1 ||
      variable->data_size > 2) {
    return false;
  }
  const std::size_t units = variable->nbytes / variable->data_size;
  if (units > kMostCharacters) return false;
  for (std::size_t i = 0; i < units; ++i) {
    if (variable->data_size == 2) {
      AppendUtf8(static_cast<const std::uint16_t*>(variable->data)[i], text);
    } else {  // UTF-8, as Octave has it
      text += static_cast<const char*>(variable->data)[i];
    }
  }
  return true;
}

absl::StatusOr<std::string> MatReader::TextOf(const char* name) const {
  const Variable variable(Mat_VarRead(mat_, name));
  if (variable == nullptr) return Fault(name, "is missing");
  std::string text;
  if (TextIn(variable.get(), text)) return text;
  return Fault(name, absl::StrCat("must be a row of at most ", kMostCharacters,
                                  " characters"));
}

absl::StatusOr<std::vector<std::string>> MatReader::TextsOf(
    const char* name) const {
  const Variable variable(Mat_VarRead(mat_, name));
  if (variable == nullptr) return Fault(name, "is missing");
  const absl::Status fault =
      Fault(name, absl::StrCat("must be a column or row of cells with texts of "
                               "at most ",
                               kMostCharacters, " characters"));
  if (variable->class_type != MAT_C_CELL || variable->rank != 2 ||
      (variable->dims[0] != 1 && variable->dims[1] != 1)) {
    return fault;
  }
  // A damaged file may state any number; a cell that is not there is null.
  const std::size_t count = std::max(variable->dims[0], variable->dims[1]);
  std::vector<std::string> texts;
  for (std::size_t c = 0; c < count; ++c) {
    const matvar_t* cell =
        variable->data == nullptr
            ? nullptr
            : Mat_VarGetCell(variable.get(), static_cast<int>(c));
    if (cell == nullptr || !TextIn(cell, texts.emplace_back())) return fault;
  }
  return texts;
}

absl::StatusOr<std::vector<double>> MatReader::NumbersIn(
    const char* name, const matvar_t* variable) const {
  if (variable == nullptr || variable->class_type != MAT_C_DOUBLE ||
      variable->data_type != MAT_T_DOUBLE || variable->isComplex != 0) {
    return Fault(name, "must be real numbers (double)");
  }
  const std::size_t count = variable->nbytes / sizeof(double);
  const auto* data = static_cast<const double*>(variable->data);
  std::vector<double> numbers;
  if (data != nullptr) numbers.assign(data, data + count);
  if (numbers.empty()) return Fault(name, "is empty");
  for (const double number : numbers) {
    if (!std::isfinite(number)) return Fault(name, "has NaN or infinity");
  }
  return numbers;
}

absl::StatusOr<std::vector<double>> MatReader::NumbersOf(
    const char* name, const Sizes& sizes) const {
  const Variable variable(Mat_VarRead(mat_, name));
  if (variable == nullptr) return Fault(name, "is missing");
  Sizes found(variable->dims, variable->dims + variable->rank);
  while (found.size() < sizes.size()) found.push_back(1);
  if (found != sizes) {
    std::string wanted;
    std::string is;
    for (const std::size_t size : sizes) absl::StrAppend(&wanted, " ", size);
    for (const std::size_t size : found) absl::StrAppend(&is, " ", size);
    return Fault(name,
                 absl::StrCat("has the sizes", is, ", must have", wanted));
  }
  MLE_ASSIGN_OR_RETURN(std::vector<double> numbers,
                       NumbersIn(name, variable.get()));
  std::size_t count = 1;
  for (const std::size_t size : sizes) count *= size;
  if (numbers.size() == count) return numbers;
  return Fault(name, "is cut off");
}

absl::StatusOr<ProcessModel> MatReader::ReadChannels() const {
  MLE_ASSIGN_OR_RETURN(std::string name, TextOf("name"));
  MLE_ASSIGN_OR_RETURN(std::string time_unit, TextOf("time_unit"));
  MLE_ASSIGN_OR_RETURN(const auto input_names, TextsOf("inputs"));
  MLE_ASSIGN_OR_RETURN(const auto output_names, TextsOf("outputs"));
  std::vector<InputChannel> inputs;
  for (const std::string& input : input_names) inputs.push_back({input, ""});
  std::vector<OutputChannel> outputs;
  for (const std::string& output : output_names)
    outputs.push_back({output, ""});
  if (Has("input_units")) {
    MLE_ASSIGN_OR_RETURN(const auto units, TextsOf("input_units"));
    if (units.size() != inputs.size()) {
      return Fault("input_units", "must have a cell for each input");
    }
    for (std::size_t j = 0; j < units.size(); ++j) inputs[j].unit = units[j];
  }
  if (Has("output_units")) {
    MLE_ASSIGN_OR_RETURN(const auto units, TextsOf("output_units"));
    if (units.size() != outputs.size()) {
      return Fault("output_units", "must have a cell for each output");
    }
    for (std::size_t i = 0; i < units.size(); ++i) outputs[i].unit = units[i];
  }
  if (Has("disturbances")) {
    MLE_ASSIGN_OR_RETURN(const std::vector<double> disturbances,
                         NumbersOf("disturbances", {inputs.size(), 1}));
    for (std::size_t j = 0; j < inputs.size(); ++j) {
      if (disturbances[j] != 0.0) inputs[j].role = InputRole::kDisturbance;
    }
  }
  ProcessModel model(std::move(name), std::move(time_unit), std::move(inputs),
                     std::move(outputs));
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return InvalidArgument(path_, ": ", status.message());
  }
  return model;
}

absl::Status MatReader::ReadElements(ProcessModel& model) const {
  const Sizes sizes = {static_cast<std::size_t>(model.num_outputs()),
                       static_cast<std::size_t>(model.num_inputs())};
  MLE_ASSIGN_OR_RETURN(const std::vector<double> delays,
                       NumbersOf("delays", sizes));
  const Variable numerators(Mat_VarRead(mat_, "numerators"));
  const Variable denominators(Mat_VarRead(mat_, "denominators"));
  for (const auto& [name, cells] :
       {std::pair("numerators", numerators.get()),
        std::pair("denominators", denominators.get())}) {
    if (cells == nullptr) return Fault(name, "is missing");
    if (cells->class_type != MAT_C_CELL || cells->rank != 2 ||
        cells->dims[0] != sizes[0] || cells->dims[1] != sizes[1]) {
      return Fault(name, "must be cells of outputs by inputs");
    }
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    for (int i = 0; i < model.num_outputs(); ++i) {
      const int c = i + model.num_outputs() * j;
      MLE_ASSIGN_OR_RETURN(
          std::vector<double> numerator,
          NumbersIn("numerators", Mat_VarGetCell(numerators.get(), c)));
      MLE_ASSIGN_OR_RETURN(
          std::vector<double> denominator,
          NumbersIn("denominators", Mat_VarGetCell(denominators.get(), c)));
      model.element(i, j) = TransferFunction(std::move(numerator),
                                             std::move(denominator), delays[c]);
    }
  }
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return InvalidArgument(path_, ": ", status.message());
  }
  return absl::OkStatus();
}

absl::StatusOr<StepResponseModel> MatReader::ReadSteps(
    ProcessModel channels) const {
  StepResponseModel model;
  model.channels = std::move(channels);
  MLE_ASSIGN_OR_RETURN(const std::vector<double> interval,
                       NumbersOf("interval", {1, 1}));
  model.interval = interval[0];
  const auto outputs = static_cast<std::size_t>(model.channels.num_outputs());
  const auto inputs = static_cast<std::size_t>(model.channels.num_inputs());
  const Variable info(Mat_VarReadInfo(mat_, "step_responses"));
  const std::size_t length = info->rank > 0 ? info->dims[0] : 0;
  // MATLAB leaves out trailing sizes of 1.
  MLE_ASSIGN_OR_RETURN(const std::vector<double> coefficients,
                       NumbersOf("step_responses", {length, outputs, inputs}));
  std::vector<double> ramps(outputs * inputs, 0.0);
  if (Has("ramps")) {
    MLE_ASSIGN_OR_RETURN(ramps, NumbersOf("ramps", {outputs, inputs}));
  }
  for (std::size_t i = 0; i < outputs; ++i) {
    for (std::size_t j = 0; j < inputs; ++j) {
      const std::size_t at = i + outputs * j;
      PairResponse pair{
          static_cast<int>(i), static_cast<int>(j),
          Eigen::Map<const Eigen::VectorXd>(coefficients.data() + at * length,
                                            static_cast<Eigen::Index>(length)),
          ramps[at] != 0.0};
      if (!pair.coefficients.isZero(0.0))
        model.pairs.push_back(std::move(pair));
    }
  }
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return InvalidArgument(path_, ": ", status.message());
  }
  return model;
}

absl::StatusOr<MatModel> MatReader::Read() {
  MLE_ASSIGN_OR_RETURN(ProcessModel model, ReadChannels());
  if (Has("step_responses")) {
    MLE_ASSIGN_OR_RETURN(StepResponseModel steps, ReadSteps(std::move(model)));
    return MatModel(std::move(steps));
  }
  if (!Has("numerators")) {
    return InvalidArgument(
        path_,
        ": has neither the variable 'step_responses' nor 'numerators': it is "
        "not a model (docs/formats.md)");
  }
  MLE_RETURN_IF_ERROR(ReadElements(model));
  return MatModel(std::move(model));
}

}  // namespace

absl::StatusOr<MatModel> ReadMatModel(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  if (!IsWholeMatFile(bytes)) {
    return InvalidArgument(
        path,
        ": cannot be read as a MAT file of version 5: it is cut off, damaged, "
        "or of another version (save -v6 or -v7)");
  }
  const Mat mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (mat == nullptr || Mat_GetVersion(mat.get()) != MAT_FT_MAT5) {
    return InvalidArgument(
        path, ": cannot be read as a MAT file of version 5 (save -v6 or -v7)");
  }
  return MatReader(mat.get(), path).Read();
}

}  // namespace mle
