// The extension module mle._mle.

#include <string>

#include "mle/base/version.h"
#include "pybind11/pybind11.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/status.h"

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
  module.def("_join_left_behind", &mle::python::JoinLeftBehind);
}
