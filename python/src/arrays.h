// Matrices as arrays of NumPy. Arrays have time first: N × p where the library
// has p × N, which is the same memory.

#ifndef PYTHON_SRC_ARRAYS_H_
#define PYTHON_SRC_ARRAYS_H_

#include "Eigen/Core"
#include "mle/model/step_response.h"
#include "pybind11/numpy.h"
#include "pybind11/pybind11.h"

namespace mle::python {

// An array of numbers in C order, converted and copied only where it is none.
using Array = pybind11::array_t<double, pybind11::array::c_style |
                                            pybind11::array::forcecast>;

// Samples of any numbers; masked ones become NaN. Throws ValueError naming
// `name` for complex ones.
Array SamplesOf(const pybind11::object& values, const char* name);

// channels × N of an N × channels array, copied once. Throws ValueError naming
// `name` for another number of dimensions.
Eigen::MatrixXd MatrixOf(const Array& array, const char* name);

// The same rows and columns. Throws ValueError naming `name` for another number
// of dimensions.
Eigen::MatrixXd RowsAndColumnsOf(const Array& array, const char* name);

// Throws ValueError unless it has `size` entries in one dimension.
Eigen::VectorXd VectorOf(const Array& array, Eigen::Index size,
                         const char* name);

// N × channels, a read-only view of memory that `owner` keeps.
pybind11::array ViewOf(const Eigen::MatrixXd& matrix,
                       const pybind11::handle& owner);

// (N, p, m), a read-only view.
pybind11::array ViewOf(const StepResponse& response,
                       const pybind11::handle& owner);

// The rows and columns as they are, copied.
pybind11::array CopyOf(const Eigen::MatrixXd& matrix);
pybind11::array CopyOf(const Eigen::VectorXd& vector);

}  // namespace mle::python

#endif  // PYTHON_SRC_ARRAYS_H_
