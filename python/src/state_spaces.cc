// mle.StateSpaceModel.

#include <optional>
#include <string>
#include <vector>

#include "mle/model/state_space_json.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/models.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

// Names are str alone: bytes need not be UTF-8.
using Names = std::optional<std::vector<py::str>>;

// Those given, or numbers behind `prefix`.
std::vector<std::string> NamesOrNumbers(const Names& given, const char* prefix,
                                        Eigen::Index count) {
  std::vector<std::string> names;
  if (given.has_value()) {
    for (const py::str& name : *given) names.push_back(name);
    return names;
  }
  for (Eigen::Index k = 1; k <= count; ++k) {
    names.push_back(prefix + std::to_string(k));
  }
  return names;
}

NamedStateSpace Make(const Array& a, const Array& b, const Array& c,
                     const py::object& d, double dt, const Names& inputs,
                     const Names& outputs,
                     std::optional<std::vector<int>> input_delays,
                     std::optional<std::vector<int>> output_delays,
                     const py::str& time_unit, const py::str& name) {
  NamedStateSpace named;
  DiscreteStateSpace& system = named.system;
  system.sample_time = dt;
  system.A = RowsAndColumnsOf(a, "A");
  system.B = RowsAndColumnsOf(b, "B");
  system.C = RowsAndColumnsOf(c, "C");
  system.D = d.is_none()
                 ? Eigen::MatrixXd::Zero(system.C.rows(), system.B.cols())
                 : RowsAndColumnsOf(d.cast<Array>(), "D");
  const Eigen::Index m = system.B.cols();
  const Eigen::Index p = system.C.rows();
  named.inputs = NamesOrNumbers(inputs, "u", m);
  named.outputs = NamesOrNumbers(outputs, "y", p);
  system.input_delays = input_delays.value_or(std::vector<int>(m));
  system.output_delays = output_delays.value_or(std::vector<int>(p));
  named.time_unit = time_unit;
  named.name = name;
  ThrowUnlessOk(named.Validate());
  return named;
}

// mle.DisturbanceModel, or None.
py::object DisturbanceModelOf(const NamedStateSpace& model) {
  if (!model.disturbance_model.has_value()) return py::none();
  const DisturbanceForm& form = *model.disturbance_model;
  return py::module_::import("mle.model")
      .attr("DisturbanceModel")(CopyOf(form.A), CopyOf(form.C), CopyOf(form.K),
                                CopyOf(form.Q), CopyOf(form.R));
}

}  // namespace

void AddStateSpaces(py::module_& module) {
  py::class_<NamedStateSpace>(
      module, "StateSpaceModel",
      "A discrete state-space model with dead times in samples:\n\n"
      "    x[k+1] = A x[k] + B v[k],  v_j[k] = u_j[k - input_delays[j]],\n"
      "    w[k] = C x[k] + D v[k],    y_i[k] = w_i[k - output_delays[i]].\n\n"
      "Inputs are held from sample to sample; outputs are measured just before "
      "the inputs change, so that D is zero in models of processes. Stable; "
      "models do not change.")
      .def(py::init(&Make), py::arg("A"), py::arg("B"), py::arg("C"),
           py::arg("D") = py::none(), py::kw_only(), py::arg("dt"),
           py::arg("inputs") = py::none(), py::arg("outputs") = py::none(),
           py::arg("input_delays") = py::none(),
           py::arg("output_delays") = py::none(), py::arg("time_unit") = "min",
           py::arg("name") = "model",
           "Of A (n, n), B (n, m), C (p, n), D (p, m) or None for zeros, and "
           "the sample time dt > 0 in `time_unit`; dead times in samples, "
           "input_delays (m,) and output_delays (p,), or None for none. Names "
           "are u1, u2, ... and y1, y2, ... unless given. Raises ValueError.")
      .def_readonly("name", &NamedStateSpace::name)
      .def_readonly("time_unit", &NamedStateSpace::time_unit,
                    "Of `dt`: ms, s, min, h or d.")
      .def_readonly("outputs", &NamedStateSpace::outputs,
                    "Names of the p outputs.")
      .def_readonly("inputs", &NamedStateSpace::inputs,
                    "Names of the m inputs.")
      .def_property_readonly(
          "dt", [](const NamedStateSpace& m) { return m.system.sample_time; },
          "The sample time, in `time_unit`.")
      .def_property_readonly(
          "A", [](const NamedStateSpace& m) { return CopyOf(m.system.A); },
          "(n, n).")
      .def_property_readonly(
          "B", [](const NamedStateSpace& m) { return CopyOf(m.system.B); },
          "(n, m).")
      .def_property_readonly(
          "C", [](const NamedStateSpace& m) { return CopyOf(m.system.C); },
          "(p, n).")
      .def_property_readonly(
          "D", [](const NamedStateSpace& m) { return CopyOf(m.system.D); },
          "(p, m).")
      .def_property_readonly(
          "input_delays",
          [](const NamedStateSpace& m) { return m.system.input_delays; },
          "Dead times of the m inputs, in samples.")
      .def_property_readonly(
          "output_delays",
          [](const NamedStateSpace& m) { return m.system.output_delays; },
          "Dead times of the p outputs, in samples.")
      .def_property_readonly(
          "disturbance_model", &DisturbanceModelOf,
          "The DisturbanceModel of the outputs; None where there is none.")
      .def_property_readonly(
          "process", [](const py::object& self) { return ProcessOf(self); },
          "The ProcessModel whose transfer functions describe its step "
          "responses, as they describe those of a StepResponseModel. Raises "
          "InvalidInputError where D is not zero, and where none of low order "
          "is within 5 % of the range of a response.")
      .def("to_json", &FormatStateSpace,
           "The text of state_space.json (docs/formats.md).")
      .def_static(
          "from_json",
          [](const std::string& json) {
            return ValueOrThrow(ParseStateSpace(json, "json"));
          },
          py::arg("json"),
          "A model of the text of state_space.json. Raises InvalidInputError.")
      .def("__eq__",
           [](const NamedStateSpace& a, const py::object& b) {
             return py::isinstance<NamedStateSpace>(b) &&
                    FormatStateSpace(a) ==
                        FormatStateSpace(b.cast<const NamedStateSpace&>());
           })
      .def("__hash__",
           [](const NamedStateSpace& m) {
             return py::hash(py::str(FormatStateSpace(m)));
           })
      .def("__repr__",
           [](const NamedStateSpace& m) {
             return "<mle.StateSpaceModel '" + m.name +
                    "': " + std::to_string(m.system.num_outputs()) +
                    " outputs, " + std::to_string(m.system.num_inputs()) +
                    " inputs, " + std::to_string(m.system.order()) +
                    " states, time in " + m.time_unit + ">";
           })
      .def(py::pickle(
          [](const NamedStateSpace& m) { return FormatStateSpace(m); },
          [](const std::string& json) {
            return ValueOrThrow(ParseStateSpace(json, "pickle"));
          }));
}

}  // namespace mle::python
