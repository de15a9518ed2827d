// mle.ProcessModel, and what else is taken as a model.

#include "python/src/models.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/data/sampling.h"
#include "mle/exchange/state_space_responses.h"
#include "mle/model/state_space_json.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

// More than anybody wants to have in memory.
constexpr double kMostSamples = 1e8;

template <typename Channel>
std::vector<std::string> UnitsOf(const std::vector<Channel>& channels) {
  std::vector<std::string> units;
  for (const Channel& channel : channels) units.push_back(channel.unit);
  return units;
}

std::vector<std::string> RolesOf(const ProcessModel& model) {
  std::vector<std::string> roles;
  for (const InputChannel& input : model.inputs()) {
    roles.emplace_back(input.role == InputRole::kDisturbance ? "disturbance"
                                                             : "manipulated");
  }
  return roles;
}

py::array StepResponseOf(const ProcessModel& model, double sample_time,
                         int samples) {
  ThrowUnlessOk(ValidateSampling(sample_time, sample_time * samples));
  const double values =
      static_cast<double>(samples) * model.num_outputs() * model.num_inputs();
  if (samples < 1 || values > kMostSamples) {
    throw py::value_error(
        absl::StrCat("samples = ", samples,
                     ": it must be at least 1, and all responses together at "
                     "most 1e8 values"));
  }
  auto* const response =
      new StepResponse(model.ComputeStepResponse(sample_time, samples));
  const py::capsule owner(response, [](void* pointer) {
    delete static_cast<StepResponse*>(pointer);
  });
  return ViewOf(*response, owner);
}

py::tuple ElementOf(const ProcessModel& model, int output, int input) {
  if (output < 0 || output >= model.num_outputs() || input < 0 ||
      input >= model.num_inputs()) {
    throw py::index_error(absl::StrCat(
        "element (", output, ", ", input, ") of a model of ",
        model.num_outputs(), " outputs and ", model.num_inputs(), " inputs"));
  }
  const TransferFunction& element = model.element(output, input);
  return py::make_tuple(element.numerator(), element.denominator(),
                        element.delay());
}

ProcessModel ParseModel(const std::string& json, const std::string& source) {
  return ValueOrThrow(ParseProcessModel(json, source));
}

std::string ModelRepresentation(const ProcessModel& model) {
  return absl::StrCat("<mle.ProcessModel '", model.name(),
                      "': ", model.num_outputs(), " outputs, ",
                      model.num_inputs(), " inputs, time in ",
                      model.time_unit(), ">");
}

py::dict TransformsOf(const ProcessModel& model) {
  const py::object json =
      py::module_::import("json").attr("loads")(FormatProcessModel(model));
  py::dict transforms;
  for (const char* const kind : {"inputs", "outputs"}) {
    for (const py::handle channel : json[kind]) {
      if (channel.contains("transform")) {
        transforms[channel["name"]] = channel["transform"];
      }
    }
  }
  return transforms;
}

ProcessModel LinearModelAt(const ProcessModel& model,
                           const std::map<std::string, double>& values) {
  return ValueOrThrow(LinearAt(model, values));
}

}  // namespace

std::string PathOf(const py::handle& argument) {
  auto path =
      py::module_::import("os").attr("fsencode")(argument).cast<std::string>();
  if (path.find('\0') != std::string::npos) {
    throw py::value_error("the path of a file has a NUL byte in it");
  }
  return path;
}

ModelArgument ModelOf(const py::handle& argument) {
  if (py::isinstance<ProcessModel>(argument)) {
    ModelFile file;
    file.process = argument.cast<const ProcessModel&>();
    return {std::move(file), ""};
  }
  if (py::isinstance<ModelFile>(argument)) {
    return {argument.cast<const ModelFile&>(), ""};
  }
  if (py::isinstance<NamedStateSpace>(argument)) {
    const auto& named = argument.cast<const NamedStateSpace&>();
    return {ValueOrThrow(OfStateSpace(named, named.name)), ""};
  }
  if (!py::isinstance<py::str>(argument) &&
      !py::hasattr(argument, "__fspath__")) {
    throw py::type_error(absl::StrCat(
        "a model must be mle.ProcessModel, mle.StepResponseModel, "
        "mle.StateSpaceModel or the path of a file; this is ",
        py::str(py::type::of(argument).attr("__name__")).cast<std::string>(),
        " (mle.from_systems takes models of other packages)"));
  }
  const std::string path = PathOf(argument);
  return {ValueOrThrow(ReadModelFile(path)), path};
}

ProcessModel ProcessOf(const py::handle& argument) {
  return ModelOf(argument).file.process;
}

void AddModels(py::module_& module) {
  py::class_<ProcessModel>(
      module, "ProcessModel",
      "A p x m matrix of transfer functions with dead times, with named inputs "
      "and outputs:\n\n    y_i(s) = sum_j g_ij(s) u_j(s),\n"
      "    g_ij(s) = e^(-L s) (b_0 s^q + ... + b_q) / (a_0 s^r + ... + "
      "a_r).\n\n"
      "Every element is proper, and stable or integrates once; times are in "
      "`time_unit`. Models do not change.")
      .def_static("from_json", &ParseModel, py::arg("json"),
                  py::arg("source") = "json",
                  "A model of the text of a process model file "
                  "(docs/formats.md). Raises InvalidInputError naming key and "
                  "element; `source` opens the message.")
      .def_static(
          "read",
          [](const py::object& path) {
            return ValueOrThrow(ReadModelFile(PathOf(path))).process;
          },
          py::arg("path"),
          "The transfer functions of a model file of any form; step responses "
          "and state spaces are described by such.")
      .def("to_json", &FormatProcessModel,
           "The text of the process model file.")
      .def_property_readonly("name", &ProcessModel::name)
      .def_property_readonly("time_unit", &ProcessModel::time_unit)
      .def_property_readonly(
          "inputs", [](const ProcessModel& m) { return NamesOf(m.inputs()); },
          "Names of the m inputs.")
      .def_property_readonly(
          "outputs", [](const ProcessModel& m) { return NamesOf(m.outputs()); },
          "Names of the p outputs.")
      .def_property_readonly(
          "input_units",
          [](const ProcessModel& m) { return UnitsOf(m.inputs()); })
      .def_property_readonly(
          "output_units",
          [](const ProcessModel& m) { return UnitsOf(m.outputs()); })
      .def_property_readonly("input_roles", &RolesOf,
                             "\"manipulated\" or \"disturbance\", m of them.")
      .def_property_readonly(
          "static_gains",
          [](const ProcessModel& m) { return CopyOf(StaticGains(m)); },
          "g_ij(0): (p, m).")
      .def_property_readonly(
          "settling_time",
          [](const ProcessModel& m) { return SettlingTime(m); },
          "Dead time plus five times the slowest time constant of the slowest "
          "element.")
      .def("element", &ElementOf, py::arg("output"), py::arg("input"),
           "(numerator, denominator, delay) of an element by its numbers from "
           "0: coefficients in s, highest power first.")
      .def("step_response", &StepResponseOf, py::arg("sample_time"),
           py::arg("samples"),
           "Responses to unit steps at 0: (samples, p, m), at 0, dt, ..., "
           "exact to rounding.")
      .def_property_readonly(
          "transforms", &TransformsOf,
          "Of the channels that have one: the transform between its value and "
          "the variable in which the elements are linear, as the model file "
          "has it.")
      .def("linear_at", &LinearModelAt, py::arg("values"),
           "The linear model at an operating point: values of channels with a "
           "transform by name; those that are not named are where it has the "
           "slope 1.")
      .def("__eq__",
           [](const ProcessModel& a, const py::object& b) {
             return py::isinstance<ProcessModel>(b) &&
                    FormatProcessModel(a) ==
                        FormatProcessModel(b.cast<const ProcessModel&>());
           })
      .def("__hash__",
           [](const ProcessModel& m) {
             return py::hash(py::str(FormatProcessModel(m)));
           })
      .def("__repr__", &ModelRepresentation)
      .def(py::pickle(
          [](const ProcessModel& m) { return FormatProcessModel(m); },
          [](const std::string& json) { return ParseModel(json, "pickle"); }));
  module.def("_process", &ProcessOf, py::arg("model"));
}

}  // namespace mle::python
