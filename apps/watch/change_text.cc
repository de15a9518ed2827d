#include "apps/watch/change_text.h"

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"

namespace mle::watch {

const char* ParameterName(int parameter) {
  constexpr const char* kNames[] = {"gain", "time constant", "dead time"};
  return kNames[parameter];
}

const char* ParameterKey(int parameter) {
  constexpr const char* kKeys[] = {"gain", "time_constant", "dead_time"};
  return kKeys[parameter];
}

std::string Signed(double value, int decimals) {
  return absl::StrCat(value > 0.0 ? "+" : "",
                      report::FormatFixed(value, decimals));
}

}  // namespace mle::watch
