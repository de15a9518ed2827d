// A folder of its own for a test, gone afterwards. Tests run side by side: a
// file that two of them name alike would be changed by one under the other.

#ifndef TESTS_MLE_BASE_SCRATCH_FOLDER_H_
#define TESTS_MLE_BASE_SCRATCH_FOLDER_H_

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "gtest/gtest.h"

namespace mle {

class ScratchFolder {
 public:
  ScratchFolder() {
    path_ = (std::filesystem::temp_directory_path() / "mle_XXXXXX").string();
    EXPECT_NE(mkdtemp(path_.data()), nullptr) << path_;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string operator/(std::string_view name) const {
    return path_ + "/" + std::string(name);
  }
  // Writes a file and gives its path.
  std::string Write(std::string_view name, std::string_view content) const {
    std::ofstream file(*this / name, std::ios::binary);
    file << content << std::flush;
    EXPECT_TRUE(file.good()) << *this / name;
    return *this / name;
  }

 private:
  std::string path_;
};

}  // namespace mle

#endif  // TESTS_MLE_BASE_SCRATCH_FOLDER_H_
