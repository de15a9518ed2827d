// What mle_study is asked to do.

#ifndef APPS_STUDY_REQUEST_H_
#define APPS_STUDY_REQUEST_H_

#include <string>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "apps/common/part.h"

namespace mle::study {

struct Request {
  std::string campaign;  // a file
  std::string out = "study";
  Part part;
  bool resume = false;
  bool dry_run = false;
  bool figures = true;
  int threads = 0;  // 0: as many as there are processors for this process

  absl::Status Validate() const;
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

}  // namespace mle::study

#endif  // APPS_STUDY_REQUEST_H_
