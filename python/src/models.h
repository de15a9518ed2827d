// The models that functions take as arguments: mle.ProcessModel,
// mle.StepResponseModel, mle.StateSpaceModel, or the path of a file that holds
// one.

#ifndef PYTHON_SRC_MODELS_H_
#define PYTHON_SRC_MODELS_H_

#include <string>

#include "mle/exchange/model_file.h"
#include "mle/model/process_model.h"
#include "pybind11/pybind11.h"

namespace mle::python {

// The path in a str, bytes or os.PathLike, as Python's own functions take it;
// raises what these raise.
std::string PathOf(const pybind11::handle& argument);

struct ModelArgument {
  ModelFile file;
  std::string path;  // "": not of a file
};

// Throws StatusError, and TypeError for what is none of these.
ModelArgument ModelOf(const pybind11::handle& argument);

// Its transfer functions, or those that describe it.
ProcessModel ProcessOf(const pybind11::handle& argument);

}  // namespace mle::python

#endif  // PYTHON_SRC_MODELS_H_
