#include "apps/lifecycle/money.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"

namespace mle::lifecycle {
namespace {

// Amounts from here on are shown in scientific form.
constexpr double kMostWhole = 1e12;

}  // namespace

std::string Money(double amount) {
  const double size = std::abs(amount);
  return size >= 100.0 && size < kMostWhole ? report::FormatFixed(amount, 0)
                                            : report::FormatSignificant(amount);
}

std::string Money(const MeanOfSeeds& amount) {
  if (!std::isfinite(amount.half_width)) return Money(amount.mean);
  return absl::StrCat(Money(amount.mean), " ± ", Money(amount.half_width));
}

std::string Money(const MeanOfSeeds& amount, const std::string& currency) {
  return absl::StrCat(Money(amount), currency.empty() ? "" : " ", currency);
}

std::string InCurrency(const std::string& currency) {
  return currency.empty() ? "" : absl::StrCat(", ", currency);
}

}  // namespace mle::lifecycle
