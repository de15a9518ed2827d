// The cost of ageing in words.

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/report/text.h"
#include "apps/watch/health.h"
#include "apps/watch/source.h"

namespace mle::watch {
namespace {

using report::FormatMoney;
using CostState = AgeingCost::State;

std::string WithCurrency(const AgeingCost& cost, double amount) {
  return absl::StrCat(FormatMoney(amount), cost.currency.empty() ? "" : " ",
                      cost.currency);
}

}  // namespace

std::string_view NameOf(AgeingCost::State state) {
  constexpr std::string_view kNames[] = {"not_asked", "cannot_tell",
                                         "nothing_aged", "told"};
  return kNames[static_cast<int>(state)];
}

std::string CostInterval(const CourseEstimate& cost) {
  return std::isfinite(cost.high)
             ? absl::StrCat(FormatMoney(cost.low), " to ",
                            FormatMoney(cost.high))
             : absl::StrCat(FormatMoney(cost.low), " and more");
}

std::string ShortCost(const AgeingCost& cost) {
  switch (cost.state) {
    case CostState::kNotAsked:
      return "–";
    case CostState::kCannotTell:
      return "cannot tell";
    case CostState::kNothingAged:
      return "0";
    case CostState::kTold:
      return FormatMoney(cost.points.front().cost.mean);
  }
  return "";
}

std::string ShortDate(const AgeingCost& cost) {
  if (cost.state == CostState::kCannotTell) return "cannot tell";
  if (cost.state != CostState::kTold) return "–";
  if (cost.pays_now()) return "now";
  if (cost.pays.has_value()) return NameOfDay(*cost.pays);
  return cost.earliest.has_value() ? "cannot tell" : "not foreseen";
}

std::string CostText(const ProcessModel& model, const AgeingCost& cost) {
  if (cost.state == CostState::kNotAsked ||
      cost.state == CostState::kCannotTell) {
    return cost.reason;
  }
  if (cost.state == CostState::kNothingAged) {
    return "No output is known to have aged, so that no costs of ageing are "
           "known.";
  }
  std::string text = absl::StrCat(
      "Ageing costs ", WithCurrency(cost, cost.points.front().cost.mean),
      " a month (", CostInterval(cost.points.front().cost),
      "): what operation costs with the model as it is, more than with a "
      "corrected one.");
  if (cost.not_counted.empty()) return text;
  std::vector<std::string> names;
  for (const int output : cost.not_counted) {
    names.push_back(model.outputs()[output].name);
  }
  return absl::StrCat(text, " Not counted: ", absl::StrJoin(names, ", "),
                      ", which may have aged, too.");
}

std::string UpdateText(const AgeingCost& cost) {
  if (cost.state != CostState::kTold) return "";
  const std::string update =
      absl::StrCat("An update costs ", WithCurrency(cost, cost.update),
                   " and serves for ", cost.days_between_updates, " days. ");
  const std::string until = NameOfDay(cost.points.back().day);
  const auto from = [&cost](int day) {
    return day == cost.points.front().day
               ? std::string("now")
               : absl::StrCat("from ", NameOfDay(day), " on");
  };
  if (cost.pays_now()) return absl::StrCat(update, "It pays now.");
  if (!cost.earliest.has_value()) {
    return absl::StrCat(update, "It does not pay until ", until,
                        ", as far as can be seen.");
  }
  return absl::StrCat(
      update,
      cost.pays.has_value()
          ? absl::StrCat("It is expected to pay ", from(*cost.pays))
          : absl::StrCat("It is not expected to pay until ", until),
      "; ", from(*cost.earliest), " at the earliest, ",
      cost.latest.has_value()
          ? absl::StrCat(from(*cost.latest), " at the latest.")
          : absl::StrCat("and perhaps not until ", until, "."));
}

}  // namespace mle::watch
