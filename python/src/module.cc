// The extension module mle._mle.

#include <cstddef>
#include <string>

#include "mle/base/version.h"
#include "pybind11/pybind11.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

// pybind11 allocates what an object without __init__() stands for when it is
// used first, and leaves that memory as it is. Nothing else allocates so:
// constructors and unpickling make the value themselves.
void RefuseObjectsWithoutInit(const py::module_& module) {
  for (const auto& [name, value] : module.attr("__dict__").cast<py::dict>()) {
    if (!py::isinstance<py::type>(value)) continue;
    py::detail::type_info* const type =
        py::detail::get_type_info(reinterpret_cast<PyTypeObject*>(value.ptr()));
    if (type == nullptr) continue;
    type->operator_new = [](std::size_t /*bytes*/) -> void* {
      throw py::type_error("the object was made without __init__()");
    };
  }
}

}  // namespace
}  // namespace mle::python

PYBIND11_MODULE(_mle, module) {
  module.doc() = "What of the package mle is compiled; use mle itself.";
  module.attr("__version__") = std::string(mle::LibraryVersion());
  mle::python::TranslateErrors();
  mle::python::AddModels(module);
  mle::python::AddStepResponses(module);
  mle::python::AddStateSpaces(module);
  mle::python::AddRecords(module);
  mle::python::AddCorrection(module);
  mle::python::AddSimulation(module);
  mle::python::AddController(module);
  mle::python::AddStudies(module);
  mle::python::AddLifecycles(module);
  mle::python::AddPrediction(module);
  mle::python::AddTrials(module);
  module.def("_join_left_behind", &mle::python::JoinLeftBehind);
  mle::python::RefuseObjectsWithoutInit(module);
}
