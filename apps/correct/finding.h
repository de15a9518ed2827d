// One thing that a run found out. Console, page and result.json show the same
// list of them.

#ifndef APPS_CORRECT_FINDING_H_
#define APPS_CORRECT_FINDING_H_

#include <limits>
#include <string>
#include <vector>

namespace mle::correct {

struct Finding {
  std::string name;  // "gain", "response_change", "fit_percent"
  std::string place;  // "overhead ← reflux", "overhead"; empty: the whole model
  double value = std::numeric_limits<double>::quiet_NaN();  // NaN: has none
  std::string unit;
  double lower = std::numeric_limits<double>::quiet_NaN();  // its interval
  double upper = std::numeric_limits<double>::quiet_NaN();
  std::string text;  // a whole sentence; empty: part of the one before
};

// The texts that are there.
std::vector<std::string> Sentences(const std::vector<Finding>& findings);

}  // namespace mle::correct

#endif  // APPS_CORRECT_FINDING_H_
