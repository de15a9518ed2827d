#include <algorithm>
#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/option_values.h"
#include "apps/simulate/request.h"
#include "mle/base/status.h"

namespace mle::simulate {
namespace {

absl::Status Wrong(std::string_view flag, const std::string& message) {
  return InvalidArgument("--", std::string(flag), ": ", message);
}

bool ReadFinite(const std::string& text, double& number) {
  return absl::SimpleAtod(text, &number) && std::isfinite(number);
}

}  // namespace

absl::StatusOr<std::vector<NamedStep>> ParseNamedSteps(
    std::string_view flag, std::string_view value,
    const std::vector<std::string>& names) {
  std::vector<NamedStep> steps;
  for (const std::string& part : ParseList(value)) {
    const std::size_t second = part.rfind(':');
    const std::size_t first = second == std::string::npos || second == 0
                                  ? std::string::npos
                                  : part.rfind(':', second - 1);
    if (first == std::string::npos) {
      return Wrong(flag, absl::StrCat("'", part,
                                      "' is not of the form NAME:TIME:VALUE"));
    }
    const std::string name = part.substr(0, first);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      return Wrong(flag,
                   absl::StrCat("'", part, "': there is no '", name, "'; ",
                                DidYouMean(name, names), "choose from ",
                                absl::StrJoin(names, ", ")));
    }
    NamedStep step{static_cast<int>(found - names.begin())};
    const std::string time = part.substr(first + 1, second - first - 1);
    if (!ReadFinite(time, step.time) ||
        !ReadFinite(part.substr(second + 1), step.value)) {
      return Wrong(
          flag, absl::StrCat("'", part, "': TIME and VALUE must be numbers"));
    }
    steps.push_back(step);
  }
  return steps;
}

}  // namespace mle::simulate
