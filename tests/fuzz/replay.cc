// Runs a fuzz target on files and on every file of folders, without libFuzzer.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "mle/base/file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size);

int main(int argc, char** argv) {
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    if (!std::filesystem::is_directory(argv[i])) {
      files.emplace_back(argv[i]);
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      files.push_back(entry.path().string());
    }
  }
  std::sort(files.begin(), files.end());
  for (const std::string& file : files) {
    const auto content = mle::ReadFile(file);
    if (!content.ok()) {
      std::cerr << content.status().message() << "\n";
      return 2;
    }
    std::cout << file << std::endl;  // flushed: the last one is the culprit
    LLVMFuzzerTestOneInput(
        reinterpret_cast<const std::uint8_t*>(content->data()),
        content->size());
  }
  std::cout << files.size() << " inputs\n";
  return files.empty() ? 2 : 0;
}
