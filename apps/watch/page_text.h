// Words that the pages of the watch share.

#ifndef APPS_WATCH_PAGE_TEXT_H_
#define APPS_WATCH_PAGE_TEXT_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "apps/watch/health.h"
#include "apps/watch/state.h"

namespace mle::watch {

// What a health value means.
extern const char* const kMeaning;

std::string LastDayOf(const Report& report);
std::string HealthText(const Report& report);

// "2026-02-10 09:30 UTC", of seconds since 1970.
std::string TimeText(std::int64_t seconds);

// "by Ann at 2026-02-10 09:30 UTC: valve ordered", or "not yet".
std::string AcknowledgementText(const Alarm& alarm);
// "command, webhook not yet (3 attempts): it answered with status 500".
std::string DeliveryText(const Alarm& alarm);
// Enough for mle_watch --acknowledge.
std::string ShortId(const Alarm& alarm);

// "1 alarm", "2 alarms".
std::string Counted(int count, std::string_view what);

}  // namespace mle::watch

#endif  // APPS_WATCH_PAGE_TEXT_H_
