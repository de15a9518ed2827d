#include "apps/lifecycle/money.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"

namespace mle::lifecycle {

std::string Money(const MeanOfSeeds& amount) {
  const std::string mean = report::FormatMoney(amount.mean);
  if (!std::isfinite(amount.half_width)) return mean;
  return absl::StrCat(mean, " ± ", report::FormatMoney(amount.half_width));
}

std::string Money(const MeanOfSeeds& amount, const std::string& currency) {
  return absl::StrCat(Money(amount), currency.empty() ? "" : " ", currency);
}

std::string InCurrency(const std::string& currency) {
  return currency.empty() ? "" : absl::StrCat(", ", currency);
}

}  // namespace mle::lifecycle
