#include "python/src/result_files.h"

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle::python {

namespace py = pybind11;

absl::StatusOr<ResultFolder> ResultFolder::Make(const std::string& path) {
  if (!path.empty()) return ResultFolder(path, false);
  std::error_code error;
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path(error);
  std::string made = (folder / "mle-XXXXXX").string();
  if (error || mkdtemp(made.data()) == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("no folder for temporary files can be made in '",
                     folder.string(), "' (TMPDIR)"));
  }
  return ResultFolder(made, true);
}

ResultFolder::ResultFolder(ResultFolder&& other) noexcept
    : path_(std::move(other.path_)),
      passing_(std::exchange(other.passing_, false)) {}

ResultFolder::~ResultFolder() {
  if (!passing_) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

absl::StatusOr<ResultFiles> ResultFolder::Read(
    const std::vector<std::string>& names) const {
  ResultFiles files;
  for (const std::string& name : names) {
    MLE_ASSIGN_OR_RETURN(std::string text,
                         ReadFile(absl::StrCat(path_, "/", name)));
    files.emplace_back(name, std::move(text));
  }
  return files;
}

absl::StatusOr<bool> RunRemaining(const experiment::Work& work, int threads,
                                  const char* what,
                                  const ProgressCallback& report,
                                  experiment::RunFolder& folder) {
  bool stopped = false;
  MLE_RETURN_IF_ERROR(folder.RunRemaining(
      work, experiment::RunThreads(threads), [&] { return stopped; },
      [&](std::int64_t done, std::int64_t total) {
        const double fraction =
            static_cast<double>(done) / static_cast<double>(total);
        if (!report({what, fraction})) stopped = true;
      }));
  return folder.is_done();
}

py::dict TextsOf(const ResultFiles& files) {
  py::dict texts;
  for (const auto& [name, text] : files) texts[py::str(name)] = text;
  return texts;
}

}  // namespace mle::python
