// The flags of mle_study. They are listed by `mle_study --help`.

#ifndef APPS_STUDY_FLAGS_H_
#define APPS_STUDY_FLAGS_H_

#include <string>

#include "absl/status/statusor.h"

namespace mle::study {

struct Request {
  std::string campaign;  // a file
  std::string out;
  bool resume = false;
  bool dry_run = false;
  bool figures = true;
  int threads = 0;  // 0: as many as there are processors for this process
};

absl::StatusOr<Request> RequestFromFlags();

}  // namespace mle::study

#endif  // APPS_STUDY_FLAGS_H_
