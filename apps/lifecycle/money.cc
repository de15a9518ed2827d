#include "apps/lifecycle/money.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"

namespace mle::lifecycle {

using report::FormatMoney;
std::string Money(const MeanOfSeeds& amount) {
  if (!std::isfinite(amount.half_width)) return FormatMoney(amount.mean);
  return absl::StrCat(FormatMoney(amount.mean), " ± ",
                      FormatMoney(amount.half_width));
}

std::string Money(const MeanOfSeeds& amount, const std::string& currency) {
  return absl::StrCat(Money(amount), currency.empty() ? "" : " ", currency);
}

std::string InCurrency(const std::string& currency) {
  return currency.empty() ? "" : absl::StrCat(", ", currency);
}

}  // namespace mle::lifecycle
