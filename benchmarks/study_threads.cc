#include "benchmarks/study_threads.h"

#include "absl/strings/numbers.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"

namespace mle::benchmarks {

int TakeThreads(int& argc, char** argv) {
  int threads = 0;
  int kept = 0;
  for (int i = 0; i < argc; ++i) {
    absl::string_view argument = argv[i];
    if (!absl::ConsumePrefix(&argument, "--threads=")) {
      argv[kept++] = argv[i];
    } else if (!absl::SimpleAtoi(argument, &threads) || threads < 1) {
      threads = -1;
    }
  }
  argc = kept;
  return threads;
}

}  // namespace mle::benchmarks
