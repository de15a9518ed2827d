#include "mle/exchange/mat_file.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/exchange/mat_variables.h"

namespace mle {
namespace {

constexpr char kHeaderText[] = "MATLAB 5.0 MAT-file, Model Life Extension";

// Empty if there is none.
std::string ScratchFolder() {
  std::error_code ignored;
  return std::filesystem::temp_directory_path(ignored).string();
}

// A file that is removed at the end.
class ScratchFile {
 public:
  ScratchFile() {
    std::string name = ScratchFolder() + "/mle_XXXXXX";
    const int file = mkstemp(name.data());
    if (file < 0) return;
    close(file);
    path_ = name;
  }
  ~ScratchFile() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove(path_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

Variable Numbers(const char* name, const Sizes& sizes,
                 const std::vector<double>& values) {
  Sizes copy = sizes;
  std::vector<double> data = values;
  return Variable(Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE,
                                static_cast<int>(copy.size()), copy.data(),
                                data.data(), 0));
}

// UTF-8, of which MAT files take whole characters of 16 bits.
std::vector<std::uint16_t> Utf16(std::string_view text) {
  std::vector<std::uint16_t> units;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const int more = lead < 0x80 ? 0 : lead < 0xE0 ? 1 : lead < 0xF0 ? 2 : 3;
    std::uint32_t code = more == 0 ? lead : lead & (0x3F >> more);
    for (int k = 1; k <= more && i + k < text.size(); ++k) {
      code = code << 6 | (static_cast<unsigned char>(text[i + k]) & 0x3F);
    }
    i += more + 1;
    if (code > 0xFFFF) code = 0xFFFD;
    units.push_back(static_cast<std::uint16_t>(code));
  }
  return units;
}

Variable Text(const char* name, std::string_view text) {
  std::vector<std::uint16_t> units = Utf16(text);
  std::array<std::size_t, 2> sizes = {units.empty() ? 0U : 1U, units.size()};
  return Variable(Mat_VarCreate(name, MAT_C_CHAR, MAT_T_UINT16, 2, sizes.data(),
                                units.data(), 0));
}

// A column of cells; `cells` are taken over.
Variable Cells(const char* name, std::array<std::size_t, 2> sizes,
               std::vector<Variable> cells) {
  Variable variable(
      Mat_VarCreate(name, MAT_C_CELL, MAT_T_CELL, 2, sizes.data(), nullptr, 0));
  for (std::size_t c = 0; c < cells.size(); ++c) {
    Mat_VarSetCell(variable.get(), static_cast<int>(c), cells[c].release());
  }
  return variable;
}

template <typename Channel>
Variable Texts(const char* name, const std::vector<Channel>& channels,
               std::string Channel::*member) {
  std::vector<Variable> cells;
  for (const Channel& channel : channels) {
    cells.push_back(Text(nullptr, channel.*member));
  }
  return Cells(name, {channels.size(), 1}, std::move(cells));
}

std::vector<Variable> Channels(const ProcessModel& model) {
  std::vector<double> disturbances;
  for (const InputChannel& input : model.inputs()) {
    disturbances.push_back(input.role == InputRole::kDisturbance ? 1.0 : 0.0);
  }
  std::vector<Variable> variables;
  variables.push_back(Text("name", model.name()));
  variables.push_back(Text("time_unit", model.time_unit()));
  variables.push_back(Texts("inputs", model.inputs(), &InputChannel::name));
  variables.push_back(
      Texts("input_units", model.inputs(), &InputChannel::unit));
  variables.push_back(
      Numbers("disturbances", {disturbances.size(), 1}, disturbances));
  variables.push_back(Texts("outputs", model.outputs(), &OutputChannel::name));
  variables.push_back(
      Texts("output_units", model.outputs(), &OutputChannel::unit));
  return variables;
}

// N + 1 × p × m.
void AddResponse(const StepResponse& response,
                 std::vector<Variable>& variables) {
  std::vector<double> values;
  for (int j = 0; j < response.num_inputs; ++j) {
    for (int i = 0; i < response.num_outputs; ++i) {
      const auto column = response.element(i, j);
      values.insert(values.end(), column.begin(), column.end());
    }
  }
  const Sizes sizes = {static_cast<std::size_t>(response.samples()),
                       static_cast<std::size_t>(response.num_outputs),
                       static_cast<std::size_t>(response.num_inputs)};
  variables.push_back(Numbers("sample_time", {1, 1}, {response.sample_time}));
  variables.push_back(Numbers("step_response", sizes, values));
}

absl::StatusOr<std::string> Written(const std::vector<Variable>& variables) {
  const ScratchFile file;
  Mat mat(file.path().empty()
              ? nullptr
              : Mat_CreateVer(file.path().c_str(), kHeaderText, MAT_FT_MAT5));
  bool done = mat != nullptr;
  for (const Variable& variable : variables) {
    done = done && variable != nullptr &&
           Mat_VarWrite(mat.get(), variable.get(), MAT_COMPRESSION_NONE) == 0;
  }
  mat.reset();
  if (!done) {
    return absl::InternalError(absl::StrCat(
        "MAT file: no temporary file can be written to '", ScratchFolder(),
        "'; TMPDIR must name a folder where it can"));
  }
  return ReadFile(file.path());
}

}  // namespace

bool IsMatFile(std::string_view start) {
  return start.starts_with("MATLAB 5.0 MAT-file");
}

absl::StatusOr<std::string> FormatMat(const ProcessModel& model,
                                      const StepResponse* response) {
  const auto outputs = static_cast<std::size_t>(model.num_outputs());
  const auto inputs = static_cast<std::size_t>(model.num_inputs());
  std::vector<Variable> numerators;
  std::vector<Variable> denominators;
  std::vector<double> delays;
  for (int j = 0; j < model.num_inputs(); ++j) {
    for (int i = 0; i < model.num_outputs(); ++i) {
      const TransferFunction& g = model.element(i, j);
      numerators.push_back(
          Numbers(nullptr, {1, g.numerator().size()}, g.numerator()));
      denominators.push_back(
          Numbers(nullptr, {1, g.denominator().size()}, g.denominator()));
      delays.push_back(g.delay());
    }
  }
  std::vector<Variable> variables = Channels(model);
  variables.push_back(
      Cells("numerators", {outputs, inputs}, std::move(numerators)));
  variables.push_back(
      Cells("denominators", {outputs, inputs}, std::move(denominators)));
  variables.push_back(Numbers("delays", {outputs, inputs}, delays));
  if (response != nullptr) AddResponse(*response, variables);
  return Written(variables);
}

absl::StatusOr<std::string> FormatMat(const StepResponseModel& model) {
  const auto outputs = static_cast<std::size_t>(model.channels.num_outputs());
  const auto inputs = static_cast<std::size_t>(model.channels.num_inputs());
  const auto length = static_cast<std::size_t>(model.length());
  std::vector<double> coefficients(length * outputs * inputs, 0.0);
  std::vector<double> ramps(outputs * inputs, 0.0);
  for (const PairResponse& pair : model.pairs) {
    const std::size_t at = pair.output + outputs * pair.input;
    ramps[at] = pair.is_ramp ? 1.0 : 0.0;
    std::copy(pair.coefficients.begin(), pair.coefficients.end(),
              coefficients.begin() + static_cast<std::ptrdiff_t>(at * length));
  }
  std::vector<Variable> variables = Channels(model.channels);
  variables.push_back(Numbers("interval", {1, 1}, {model.interval}));
  variables.push_back(
      Numbers("step_responses", {length, outputs, inputs}, coefficients));
  variables.push_back(Numbers("ramps", {outputs, inputs}, ramps));
  return Written(variables);
}

}  // namespace mle
