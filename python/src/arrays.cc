#include "python/src/arrays.h"

#include <limits>
#include <string>

#include "absl/strings/str_cat.h"

namespace mle::python {
namespace {

namespace py = pybind11;

constexpr auto kDouble = static_cast<py::ssize_t>(sizeof(double));

std::string ShapeOf(const Array& array) {
  std::string shape = "(";
  for (py::ssize_t d = 0; d < array.ndim(); ++d) {
    absl::StrAppend(&shape, d > 0 ? ", " : "", array.shape(d));
  }
  return shape + (array.ndim() == 1 ? ",)" : ")");
}

py::array ReadOnly(py::array array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

}  // namespace

Array SamplesOf(const py::object& values, const char* name) {
  const py::module_ numpy = py::module_::import("numpy");
  if (numpy.attr("iscomplexobj")(values).cast<bool>()) {
    throw py::value_error(
        absl::StrCat(name, " has complex samples; they must be real"));
  }
  const py::object masked = numpy.attr("ma");
  if (!masked.attr("isMaskedArray")(values).cast<bool>()) {
    return values.cast<Array>();
  }
  return masked
      .attr("filled")(values.attr("astype")("float64"),
                      std::numeric_limits<double>::quiet_NaN())
      .cast<Array>();
}

Eigen::MatrixXd MatrixOf(const Array& array, const char* name) {
  if (array.ndim() != 2) {
    throw py::value_error(absl::StrCat(name, " has the shape ", ShapeOf(array),
                                       "; it must be (samples, channels)"));
  }
  return Eigen::Map<const Eigen::MatrixXd>(array.data(), array.shape(1),
                                           array.shape(0));
}

Eigen::MatrixXd RowsAndColumnsOf(const Array& array, const char* name) {
  if (array.ndim() != 2) {
    throw py::value_error(absl::StrCat(name, " has the shape ", ShapeOf(array),
                                       "; it must be a matrix"));
  }
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic,
                                        Eigen::RowMajor>>(
      array.data(), array.shape(0), array.shape(1));
}

Eigen::VectorXd VectorOf(const Array& array, Eigen::Index size,
                         const char* name) {
  if (array.ndim() != 1 || array.shape(0) != size) {
    throw py::value_error(absl::StrCat(name, " has the shape ", ShapeOf(array),
                                       "; it must be (", size, ",)"));
  }
  return Eigen::Map<const Eigen::VectorXd>(array.data(), size);
}

py::array ViewOf(const Eigen::MatrixXd& matrix, const py::handle& owner) {
  const auto rows = static_cast<py::ssize_t>(matrix.rows());
  return ReadOnly(
      py::array_t<double>({static_cast<py::ssize_t>(matrix.cols()), rows},
                          {rows * kDouble, kDouble}, matrix.data(), owner));
}

py::array ViewOf(const StepResponse& response, const py::handle& owner) {
  const py::ssize_t samples = response.samples();
  const py::ssize_t p = response.num_outputs;
  const py::ssize_t m = response.num_inputs;
  return ReadOnly(py::array_t<double>(
      {samples, p, m}, {kDouble, m * samples * kDouble, samples * kDouble},
      response.values.data(), owner));
}

py::array CopyOf(const Eigen::MatrixXd& matrix) {
  const auto rows = static_cast<py::ssize_t>(matrix.rows());
  return py::array_t<double>({rows, static_cast<py::ssize_t>(matrix.cols())},
                             {kDouble, rows * kDouble}, matrix.data());
}

py::array CopyOf(const Eigen::VectorXd& vector) {
  return py::array_t<double>(static_cast<py::ssize_t>(vector.size()),
                             vector.data());
}

}  // namespace mle::python
