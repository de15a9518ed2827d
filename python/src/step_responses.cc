// mle.StepResponseModel: the coefficients of a file (ModelFile) and the
// transfer functions that describe them.

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/exchange/model_file.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/models.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

ModelFile WithStepResponses(ModelFile file, const std::string& source) {
  if (file.form == ModelForm::kStepResponses) return file;
  throw py::value_error(absl::StrCat(
      source,
      " holds transfer functions, not step responses; mle.ProcessModel reads "
      "it"));
}

ModelFile ParsedFile(const std::string& text, const std::string& source) {
  absl::StatusOr<ModelFile> file;
  {
    const py::gil_scoped_release release;
    file = ParseModelFile(text, source);
  }
  return WithStepResponses(ValueOrThrow(std::move(file)), source);
}

ModelFile Read(const py::object& argument) {
  const std::string path = PathOf(argument);
  absl::StatusOr<ModelFile> file;
  {
    const py::gil_scoped_release release;
    file = ReadModelFile(path);
  }
  return WithStepResponses(ValueOrThrow(std::move(file)), path);
}

// (N, p, m): c_1 … c_N, zeros for pairs that are not there.
py::array CoefficientsOf(const ModelFile& file) {
  const StepResponseModel& model = file.step_responses;
  auto* const response =
      new StepResponse(model.interval, model.channels.num_outputs(),
                       model.channels.num_inputs(), model.length());
  for (const PairResponse& pair : model.pairs) {
    response->element(pair.output, pair.input) = pair.coefficients;
  }
  const py::capsule owner(response, [](void* pointer) {
    delete static_cast<StepResponse*>(pointer);
  });
  return ViewOf(*response, owner);
}

// (p, m): how far the transfer functions are off, relative to the range.
py::array DifferencesOf(const ModelFile& file) {
  Eigen::MatrixXd differences = Eigen::MatrixXd::Zero(
      file.process.num_outputs(), file.process.num_inputs());
  for (const PairResponse& pair : file.step_responses.pairs) {
    const Eigen::VectorXd& given = pair.coefficients;
    const double range =
        std::max(given.maxCoeff(), 0.0) - std::min(given.minCoeff(), 0.0);
    if (!(range > 0.0)) continue;
    const Eigen::VectorXd described =
        file.process.element(pair.output, pair.input)
            .StepResponse(file.step_responses.interval,
                          static_cast<int>(given.size()) + 1)
            .tail(given.size());
    differences(pair.output, pair.input) =
        (described - given).cwiseAbs().maxCoeff() / range;
  }
  return CopyOf(differences);
}

std::string JsonOf(const ModelFile& file) {
  return FormatStepResponseJson(file.step_responses);
}

// The transfer functions are kept, too: those that describe a corrected model
// are not those that a fit to its step responses would give.
ModelFile UnpickledFile(const py::tuple& state) {
  ModelFile file;
  file.form = ModelForm::kStepResponses;
  file.step_responses = ValueOrThrow(
      ParseStepResponseModel(state[0].cast<std::string>(), "pickle"));
  file.process =
      ValueOrThrow(ParseProcessModel(state[1].cast<std::string>(), "pickle"));
  return file;
}

void AddChannels(py::class_<ModelFile>& type) {
  // Those of the transfer functions are the same.
  for (const char* const name :
       {"name", "time_unit", "inputs", "outputs", "input_units", "output_units",
        "input_roles"}) {
    type.def_property_readonly(
        name,
        [name](const ModelFile& file) -> py::object {
          return py::cast(file.process).attr(name);
        },
        "As of ProcessModel.");
  }
}

std::string Representation(const ModelFile& file) {
  const StepResponseModel& model = file.step_responses;
  return absl::StrCat("<mle.StepResponseModel '", model.channels.name(),
                      "': ", model.channels.num_outputs(), " outputs, ",
                      model.channels.num_inputs(), " inputs, ", model.length(),
                      " coefficients every ", model.interval, " ",
                      model.channels.time_unit(), ">");
}

}  // namespace

void AddStepResponses(py::module_& module) {
  py::class_<ModelFile> type(
      module, "StepResponseModel",
      "A step-response (FIR) model, as model predictive controllers keep them: "
      "of each pair the response of the output to a unit step of the input at "
      "0, at dt, 2 dt, ..., N dt; after that it stays. Transfer functions "
      "describe it (`process`). Models do not change.");
  type.def_static("from_json", &ParsedFile, py::arg("json"),
                  py::arg("source") = "json",
                  "A model of the text of a file with step responses, JSON or "
                  "CSV (docs/formats.md). Raises InvalidInputError; `source` "
                  "opens the message.")
      .def_static("read", &Read, py::arg("path"),
                  "A model of a file with step responses: CSV, JSON or MAT.")
      .def("to_json", &JsonOf, "The text of the file in JSON.")
      .def(
          "to_csv",
          [](const ModelFile& file) {
            return FormatStepResponseCsv(file.step_responses);
          },
          "The text of the file in CSV.")
      .def_property_readonly(
          "dt",
          [](const ModelFile& file) { return file.step_responses.interval; },
          "The interval of the coefficients, in `time_unit`.")
      .def_property_readonly("coefficients", &CoefficientsOf,
                             "(N, p, m), at dt, 2 dt, ..., N dt; zeros where "
                             "an input does not reach an output.")
      .def_property_readonly(
          "process", [](const ModelFile& file) { return file.process; },
          "The ProcessModel that describes it.")
      .def_property_readonly(
          "differences", &DifferencesOf,
          "(p, m): the largest differences of the responses of `process`, "
          "relative to the range of the coefficients.")
      .def("__len__",
           [](const ModelFile& file) { return file.step_responses.length(); })
      .def("__eq__",
           [](const ModelFile& a, const py::object& b) {
             return py::isinstance<ModelFile>(b) &&
                    JsonOf(a) == JsonOf(b.cast<const ModelFile&>());
           })
      .def(
          "__hash__",
          [](const ModelFile& file) { return py::hash(py::str(JsonOf(file))); })
      .def("__repr__", &Representation)
      .def(py::pickle(
          [](const ModelFile& file) {
            return py::make_tuple(JsonOf(file),
                                  FormatProcessModel(file.process));
          },
          &UnpickledFile));
  AddChannels(type);
}

}  // namespace mle::python
