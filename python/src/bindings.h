// The parts of the extension module, each of which adds its classes and
// functions to it. The package around it is python/mle.

#ifndef PYTHON_SRC_BINDINGS_H_
#define PYTHON_SRC_BINDINGS_H_

#include "pybind11/pybind11.h"

namespace mle::python {

void AddModels(pybind11::module_& module);
void AddStepResponses(pybind11::module_& module);
void AddStateSpaces(pybind11::module_& module);
void AddRecords(pybind11::module_& module);
void AddCorrection(pybind11::module_& module);
void AddSimulation(pybind11::module_& module);
void AddController(pybind11::module_& module);
void AddStudies(pybind11::module_& module);
void AddPrediction(pybind11::module_& module);
void AddLifecycles(pybind11::module_& module);
void AddTrials(pybind11::module_& module);

}  // namespace mle::python

#endif  // PYTHON_SRC_BINDINGS_H_
