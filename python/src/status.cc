#include "python/src/status.h"

#include "absl/strings/ascii.h"
#include "mle/base/option_error.h"

namespace mle::python {
namespace {

namespace py = pybind11;

void Raise(const absl::Status& status) {
  const py::object error =
      py::module_::import("mle.errors")
          .attr("_error")(absl::StatusCodeToString(status.code()),
                          TextOf(WithoutDashes(std::string(status.message()))),
                          OptionOf(status));
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())),
                  error.ptr());
}

}  // namespace

py::str TextOf(const std::string& text) {
  PyObject* const decoded = PyUnicode_DecodeUTF8(
      text.data(), static_cast<Py_ssize_t>(text.size()), "replace");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

std::string WithoutDashes(const std::string& text) {
  std::string plain;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const bool begins_word =
        at == 0 || text[at - 1] == ' ' || text[at - 1] == '(';
    const bool is_flag =
        begins_word && text.compare(at, 2, "--") == 0 && at + 2 < text.size() &&
        absl::ascii_islower(static_cast<unsigned char>(text[at + 2]));
    if (is_flag) at += 2;
    plain += text[at];
  }
  return plain;
}

void TranslateErrors() {
  py::register_local_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const StatusError& error) {
      Raise(error.status());
    } catch (const py::cast_error& error) {
      PyErr_SetString(PyExc_TypeError, error.what());
    }
  });
}

}  // namespace mle::python
