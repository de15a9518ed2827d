// Words that the pages of the watch share.

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "apps/report/text.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"

namespace mle::watch {

const char* const kMeaning =
    "Health is the probability that nothing has changed, on a scale on which "
    "an alarm is raised at one half; it is near 1 without evidence. The "
    "probability of ever raising a false alarm on a model that does not change "
    "is at most the level of its controller (5 % unless the list of "
    "controllers says otherwise), however often it is looked at.";

std::string LastDayOf(const Report& report) {
  return report.last_day == 0 ? "–" : NameOfDay(report.last_day);
}

std::string HealthText(const Report& report) {
  return report.status == Status::kFailed || report.status == Status::kLearning
             ? "–"
             : report::FormatFixed(report.health, 3);
}

std::string Counted(int count, std::string_view what) {
  return absl::StrCat(count, " ", std::string(what), count == 1 ? "" : "s");
}

std::string ShortId(const Alarm& alarm) { return alarm.id.substr(0, 8); }

std::string TimeText(std::int64_t seconds) {
  return absl::FormatTime("%Y-%m-%d %H:%M UTC", absl::FromUnixSeconds(seconds),
                          absl::UTCTimeZone());
}

std::string AcknowledgementText(const Alarm& alarm) {
  if (!alarm.acknowledged.has_value()) return "not yet";
  const Acknowledgement& made = *alarm.acknowledged;
  return absl::StrCat("by ", made.who, " at ", TimeText(made.at),
                      made.note.empty() ? "" : ": ", made.note);
}

std::string DeliveryText(const Alarm& alarm) {
  std::vector<std::string> parts;
  for (const Delivery& delivery : alarm.deliveries) {
    std::string part(NameOf(delivery.channel));
    if (delivery.state != Delivery::State::kSent) {
      absl::StrAppend(&part, " not yet (",
                      Counted(delivery.attempts, "attempt"), ")",
                      delivery.fault.empty() ? "" : ": ", delivery.fault);
    }
    parts.push_back(std::move(part));
  }
  return parts.empty() ? "–" : absl::StrJoin(parts, ", ");
}

}  // namespace mle::watch
