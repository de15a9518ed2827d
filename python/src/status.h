// Statuses of the library as exceptions of Python: the one place of the project
// where something is thrown, as Python's callers expect it.
//
//   const ProcessModel model = ValueOrThrow(ReadProcessModel(path));
//
// The exception is mle.Error of the kind that belongs to the code
// (python/mle/errors.py) with the status's text. A caller in Python has no
// flags: "--order=0: …" becomes "order=0: …".

#ifndef PYTHON_SRC_STATUS_H_
#define PYTHON_SRC_STATUS_H_

#include <exception>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "pybind11/pybind11.h"

namespace mle::python {

class StatusError : public std::exception {
 public:
  explicit StatusError(absl::Status status) : status_(std::move(status)) {}

  const absl::Status& status() const { return status_; }
  const char* what() const noexcept override {
    return "a status that Python is told as an exception";
  }

 private:
  absl::Status status_;
};

inline void ThrowUnlessOk(const absl::Status& status) {
  if (!status.ok()) throw StatusError(status);
}

template <typename Value>
Value ValueOrThrow(absl::StatusOr<Value> value) {
  ThrowUnlessOk(value.status());
  return *std::move(value);
}

// "order" for each "--order" in a text.
std::string WithoutDashes(const std::string& text);

// The text as a Python str. Bytes that are not UTF-8, as those of a file may
// be, become U+FFFD.
pybind11::str TextOf(const std::string& text);

// Has pybind11 turn StatusError into exceptions of the package, and what is of
// another type than its place in an argument into TypeError.
void TranslateErrors();

}  // namespace mle::python

#endif  // PYTHON_SRC_STATUS_H_
