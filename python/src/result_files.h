// Results that are files of a folder: one that the caller names, or one that
// goes away with the call.

#ifndef PYTHON_SRC_RESULT_FILES_H_
#define PYTHON_SRC_RESULT_FILES_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/run_folder.h"
#include "pybind11/pybind11.h"
#include "python/src/long_call.h"

namespace mle::python {

// Names and texts.
using ResultFiles = std::vector<std::pair<std::string, std::string>>;

class ResultFolder {
 public:
  // `path`, or, where that is "", a new one in the system's folder of temporary
  // files.
  static absl::StatusOr<ResultFolder> Make(const std::string& path);
  ~ResultFolder();
  ResultFolder(ResultFolder&& other) noexcept;
  ResultFolder& operator=(ResultFolder&&) = delete;
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

  const std::string& path() const { return path_; }
  absl::StatusOr<ResultFiles> Read(const std::vector<std::string>& names) const;

 private:
  ResultFolder(std::string path, bool passing)
      : path_(std::move(path)), passing_(passing) {}

  std::string path_;
  bool passing_;  // removed in the end
};

// Runs the work in `folder` that is not done yet, and tells `report` which part
// of `what` is. False if `report` stopped it.
absl::StatusOr<bool> RunRemaining(const experiment::Work& work, int threads,
                                  const char* what,
                                  const ProgressCallback& report,
                                  experiment::RunFolder& folder);

// {name: text}.
pybind11::dict TextsOf(const ResultFiles& files);

}  // namespace mle::python

#endif  // PYTHON_SRC_RESULT_FILES_H_
