// Alarms in the state: how they are read, delivered and acknowledged.

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/common/sha256.h"
#include "apps/report/text.h"
#include "apps/watch/state.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"

namespace mle::watch {
namespace {

constexpr std::size_t kMostName = 200;   // bytes
constexpr std::size_t kMostNote = 1000;  // bytes
constexpr std::size_t kIdLength = 32;

std::string CleanPart(const std::string& text) {
  const std::string clean = report::CleanText(text);
  return std::string(absl::StripAsciiWhitespace(clean));
}

}  // namespace

absl::StatusOr<Acknowledgement> MakeAcknowledgement(const std::string& who,
                                                    const std::string& note) {
  Acknowledgement made = {.who = CleanPart(who),
                          .at = absl::ToUnixSeconds(absl::Now()),
                          .note = CleanPart(note)};
  if (made.who.empty() || made.who.size() > kMostName) {
    return InvalidArgument("who acknowledges must be given, in at most ",
                           kMostName, " bytes");
  }
  if (made.note.size() > kMostNote) {
    return InvalidArgument("the note has at most ", kMostNote, " bytes");
  }
  return made;
}

std::string_view NameOf(Channel channel) {
  constexpr std::string_view kNames[] = {"command", "mail", "webhook"};
  return kNames[static_cast<int>(channel)];
}

std::string_view NameOf(AlarmKind kind) {
  constexpr std::string_view kNames[] = {"aged", "adopt", "drop", "roll_back"};
  return kNames[static_cast<int>(kind)];
}

std::string AlarmId(const std::string& what) {
  return Sha256Of(what).substr(0, kIdLength);
}

std::vector<Alarm> AlarmsOfAgeing(const std::vector<Alarm>& alarms) {
  std::vector<Alarm> of_ageing;
  std::copy_if(
      alarms.begin(), alarms.end(), std::back_inserter(of_ageing),
      [](const Alarm& alarm) { return alarm.kind == AlarmKind::kAged; });
  return of_ageing;
}

int CountOpen(const std::vector<Alarm>& alarms) {
  return static_cast<int>(std::count_if(
      alarms.begin(), alarms.end(),
      [](const Alarm& alarm) { return !alarm.acknowledged.has_value(); }));
}

bool IsUndelivered(const Alarm& alarm, Channel channel) {
  return !alarm.acknowledged.has_value() &&
         std::any_of(alarm.deliveries.begin(), alarm.deliveries.end(),
                     [&](const Delivery& delivery) {
                       return delivery.channel == channel &&
                              delivery.state != Delivery::State::kSent;
                     });
}

absl::Status State::LoadAlarms(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(
      const Rows alarms,
      database_->Run("SELECT id, output, element, day, began, text, who, at, "
                     "note, kind FROM alarm WHERE watch = ? ORDER BY day, id",
                     {watch.id}));
  for (const Row& row : alarms) {
    Alarm& alarm = watch.alarms.emplace_back();
    const std::int64_t kind = row.Integer(9);
    if (kind < 0 || kind > static_cast<std::int64_t>(AlarmKind::kRollBack)) {
      return absl::DataLossError("it has an alarm of no kind");
    }
    alarm = {.id = row.Text(0),
             .kind = static_cast<AlarmKind>(kind),
             .output = static_cast<int>(row.Integer(1)),
             .element = static_cast<int>(row.Integer(2)),
             .day = static_cast<int>(row.Integer(3)),
             .began = static_cast<int>(row.Integer(4)),
             .text = row.Text(5)};
    if (!row.IsNull(6)) {
      alarm.acknowledged = {
          .who = row.Text(6), .at = row.Integer(7), .note = row.Text(8)};
    }
  }
  if (watch.alarms.empty()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(
      const Rows deliveries,
      database_->Run("SELECT alarm, channel, state, attempts, fault FROM "
                     "delivery JOIN alarm ON alarm.id = delivery.alarm "
                     "WHERE watch = ? ORDER BY alarm, channel",
                     {watch.id}));
  for (const Row& row : deliveries) {
    const std::string id = row.Text(0);
    const std::string name = row.Text(1);
    const auto alarm =
        std::find_if(watch.alarms.begin(), watch.alarms.end(),
                     [&](const Alarm& raised) { return raised.id == id; });
    const auto* const channel =
        std::find_if(std::begin(kChannels), std::end(kChannels),
                     [&](Channel known) { return NameOf(known) == name; });
    if (alarm == watch.alarms.end() || channel == std::end(kChannels)) continue;
    alarm->deliveries.push_back(
        {.channel = *channel,
         .state = static_cast<Delivery::State>(row.Integer(2)),
         .attempts = static_cast<int>(row.Integer(3)),
         .fault = row.Text(4)});
  }
  return absl::OkStatus();
}

absl::Status State::ReloadAlarms(Watch& watch) {
  watch.alarms.clear();
  return LoadAlarms(watch);
}

absl::StatusOr<std::vector<PendingAlarm>> State::Undelivered(Channel channel) {
  MLE_ASSIGN_OR_RETURN(
      const Rows rows,
      database_->Run(
          "SELECT watch.controller, alarm.id, alarm.day, alarm.text, "
          "delivery.state, delivery.attempts, delivery.fault FROM alarm "
          "JOIN watch ON watch.id = alarm.watch "
          "LEFT JOIN delivery ON delivery.alarm = alarm.id AND "
          "delivery.channel = ? "
          "WHERE alarm.who IS NULL AND "
          "(delivery.state IS NULL OR delivery.state < ?) "
          "ORDER BY COALESCE(delivery.attempts, 0), alarm.day, alarm.id",
          {std::string(NameOf(channel)),
           static_cast<std::int64_t>(Delivery::State::kSent)}));
  std::vector<PendingAlarm> alarms;
  for (const Row& row : rows) {
    // A null reads as 0 or empty.
    alarms.push_back(
        {.controller = row.Text(0),
         .alarm = {.id = row.Text(1),
                   .day = static_cast<int>(row.Integer(2)),
                   .text = row.Text(3)},
         .delivery = {.channel = channel,
                      .state = static_cast<Delivery::State>(row.Integer(4)),
                      .attempts = static_cast<int>(row.Integer(5)),
                      .fault = row.Text(6)}});
  }
  return alarms;
}

absl::Status State::SetDelivery(const std::string& alarm,
                                const Delivery& delivery) {
  return Write(
      "INSERT INTO delivery(alarm, channel, state, attempts, fault) VALUES "
      "(?, ?, ?, ?, ?) ON CONFLICT(alarm, channel) DO UPDATE SET "
      "state = excluded.state, attempts = excluded.attempts, "
      "fault = excluded.fault",
      {alarm, std::string(NameOf(delivery.channel)),
       static_cast<std::int64_t>(delivery.state), delivery.attempts,
       delivery.fault});
}

absl::StatusOr<std::string> State::FindAlarm(const std::string& beginning) {
  MLE_ASSIGN_OR_RETURN(
      const Rows found,
      database_->Run(
          "SELECT id FROM alarm WHERE substr(id, 1, length(?)) = ? LIMIT 2",
          {beginning, beginning}));
  if (found.empty() || beginning.empty()) {
    return absl::NotFoundError(
        absl::StrCat("there is no alarm whose id begins with '", beginning,
                     "'; the pages and watch.json have the ids"));
  }
  if (found.size() > 1) {
    return InvalidArgument("the ids of several alarms begin with '", beginning,
                           "'; give more of it");
  }
  return found.front().Text(0);
}

absl::Status State::Acknowledge(const std::string& alarm,
                                const Acknowledgement& acknowledgement) {
  // The second of two acknowledgements at the same time changes no row: the
  // first has set `who`.
  MLE_ASSIGN_OR_RETURN(
      const Rows changed,
      database_->Run("UPDATE alarm SET who = ?, at = ?, note = ? WHERE id = ? "
                     "AND who IS NULL RETURNING id",
                     {acknowledgement.who, acknowledgement.at,
                      acknowledgement.note, alarm}));
  if (!changed.empty()) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(
      const Rows before,
      database_->Run("SELECT who, at FROM alarm WHERE id = ?", {alarm}));
  if (before.empty()) {
    return absl::NotFoundError(
        absl::StrCat("there is no alarm with the id ", alarm));
  }
  return absl::AlreadyExistsError(absl::StrCat(
      "the alarm was acknowledged before, by ", before.front().Text(0), " at ",
      FormatIsoTime(static_cast<double>(before.front().Integer(1)))));
}

}  // namespace mle::watch
