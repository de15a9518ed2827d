// A file for what is only read from files: in memory where the system has such
// a folder.

#ifndef TESTS_FUZZ_SCRATCH_FILE_H_
#define TESTS_FUZZ_SCRATCH_FILE_H_

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace mle::fuzz {

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name =
        std::filesystem::exists("/dev/shm") ? "/dev/shm" : "/tmp";
    name += "/mle_fuzz_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string Write(const std::string& name, std::string_view bytes) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << bytes;
    return folder_ + "/" + name;
  }
  const std::string& path() const { return folder_; }

 private:
  std::string folder_;
};

}  // namespace mle::fuzz

#endif  // TESTS_FUZZ_SCRATCH_FILE_H_
