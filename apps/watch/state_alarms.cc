// Alarms in the state: how they are read, delivered and acknowledged.

#include <algorithm>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/watch/state.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"

namespace mle::watch {
namespace {

constexpr Channel kChannels[] = {Channel::kCommand, Channel::kMail,
                                 Channel::kWebhook};

}  // namespace

std::string_view NameOf(Channel channel) {
  switch (channel) {
    case Channel::kCommand:
      return "command";
    case Channel::kMail:
      return "mail";
    case Channel::kWebhook:
      return "webhook";
  }
  return "";
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
  MLE_RETURN_IF_ERROR(ForEach(
      "SELECT id, output, element, day, began, text, who, at, note FROM alarm "
      "LEFT JOIN acknowledgement ON acknowledgement.alarm = alarm.id "
      "WHERE watch = ? ORDER BY day, id",
      watch, [&watch](const Statement& row) {
        Alarm& alarm = watch.alarms.emplace_back();
        alarm = {.id = row.Text(0),
                 .output = static_cast<int>(row.Integer(1)),
                 .element = static_cast<int>(row.Integer(2)),
                 .day = static_cast<int>(row.Integer(3)),
                 .began = static_cast<int>(row.Integer(4)),
                 .text = row.Text(5)};
        if (!row.IsNull(6)) {
          alarm.acknowledged = {
              .who = row.Text(6), .at = row.Integer(7), .note = row.Text(8)};
        }
        return absl::OkStatus();
      }));
  return watch.alarms.empty() ? absl::OkStatus() : LoadDeliveries(watch);
}

absl::Status State::ReloadAlarms(Watch& watch) {
  watch.alarms.clear();
  return LoadAlarms(watch);
}

absl::Status State::LoadDeliveries(Watch& watch) {
  return ForEach(
      "SELECT alarm, channel, state, attempts, fault FROM delivery JOIN alarm "
      "ON alarm.id = delivery.alarm WHERE watch = ? ORDER BY alarm, channel",
      watch, [&watch](const Statement& row) {
        const std::string id = row.Text(0);
        const std::string name = row.Text(1);
        const auto alarm =
            std::find_if(watch.alarms.begin(), watch.alarms.end(),
                         [&](const Alarm& raised) { return raised.id == id; });
        const auto* const channel =
            std::find_if(std::begin(kChannels), std::end(kChannels),
                         [&](Channel known) { return NameOf(known) == name; });
        if (alarm != watch.alarms.end() && channel != std::end(kChannels)) {
          alarm->deliveries.push_back(
              {.channel = *channel,
               .state = static_cast<Delivery::State>(row.Integer(2)),
               .attempts = static_cast<int>(row.Integer(3)),
               .fault = row.Text(4)});
        }
        return absl::OkStatus();
      });
}

absl::StatusOr<std::vector<PendingAlarm>> State::Undelivered(Channel channel) {
  MLE_ASSIGN_OR_RETURN(
      Statement select,
      database_.Prepare(
          "SELECT watch.controller, alarm.id, alarm.day, alarm.text, "
          "delivery.state, delivery.attempts, delivery.fault FROM alarm "
          "JOIN watch ON watch.id = alarm.watch "
          "LEFT JOIN delivery ON delivery.alarm = alarm.id AND "
          "delivery.channel = ? "
          "LEFT JOIN acknowledgement ON acknowledgement.alarm = alarm.id "
          "WHERE acknowledgement.alarm IS NULL AND "
          "(delivery.state IS NULL OR delivery.state < ?) "
          "ORDER BY COALESCE(delivery.attempts, 0), alarm.day, alarm.id"));
  select.BindText(1, NameOf(channel))
      .Bind(2, static_cast<std::int64_t>(Delivery::State::kSent));
  std::vector<PendingAlarm> alarms;
  while (true) {
    MLE_ASSIGN_OR_RETURN(const bool row, select.Next());
    if (!row) return alarms;
    // What is null reads as 0 and empty.
    alarms.push_back(
        {.controller = select.Text(0),
         .alarm = {.id = select.Text(1),
                   .day = static_cast<int>(select.Integer(2)),
                   .text = select.Text(3)},
         .delivery = {.channel = channel,
                      .state = static_cast<Delivery::State>(select.Integer(4)),
                      .attempts = static_cast<int>(select.Integer(5)),
                      .fault = select.Text(6)}});
  }
}

absl::Status State::SetDelivery(const std::string& alarm,
                                const Delivery& delivery) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare(
          "INSERT INTO delivery(alarm, channel, state, attempts, fault) VALUES "
          "(?, ?, ?, ?, ?) ON CONFLICT(alarm, channel) DO UPDATE SET "
          "state = excluded.state, attempts = excluded.attempts, "
          "fault = excluded.fault"));
  insert.BindText(1, alarm)
      .BindText(2, NameOf(delivery.channel))
      .Bind(3, static_cast<std::int64_t>(delivery.state))
      .Bind(4, std::int64_t{delivery.attempts})
      .BindText(5, delivery.fault);
  return insert.Run();
}

absl::StatusOr<std::string> State::FindAlarm(const std::string& beginning) {
  MLE_ASSIGN_OR_RETURN(
      Statement select,
      database_.Prepare(
          "SELECT id FROM alarm WHERE substr(id, 1, length(?)) = ? LIMIT 2"));
  select.BindText(1, beginning).BindText(2, beginning);
  MLE_ASSIGN_OR_RETURN(const bool found, select.Next());
  if (!found || beginning.empty()) {
    return absl::NotFoundError(
        absl::StrCat("there is no alarm whose id begins with '", beginning,
                     "'; the pages and watch.json have the ids"));
  }
  std::string id = select.Text(0);
  MLE_ASSIGN_OR_RETURN(const bool another, select.Next());
  if (another) {
    return absl::InvalidArgumentError(
        absl::StrCat("the ids of several alarms begin with '", beginning,
                     "'; give more of it"));
  }
  return id;
}

absl::Status State::Acknowledge(const std::string& alarm,
                                const Acknowledgement& acknowledgement) {
  MLE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database_));
  MLE_ASSIGN_OR_RETURN(
      Statement select,
      database_.Prepare(
          "SELECT who, at FROM alarm LEFT JOIN acknowledgement ON "
          "acknowledgement.alarm = alarm.id WHERE alarm.id = ?"));
  select.BindText(1, alarm);
  MLE_ASSIGN_OR_RETURN(const bool found, select.Next());
  if (!found) {
    return absl::NotFoundError(
        absl::StrCat("there is no alarm with the id ", alarm));
  }
  if (!select.IsNull(0)) {
    return absl::AlreadyExistsError(absl::StrCat(
        "the alarm was acknowledged before, by ", select.Text(0), " at ",
        FormatIsoTime(static_cast<double>(select.Integer(1)))));
  }
  MLE_RETURN_IF_ERROR(select.Run());
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare("INSERT INTO acknowledgement(alarm, who, at, note) "
                        "VALUES (?, ?, ?, ?)"));
  insert.BindText(1, alarm)
      .BindText(2, acknowledgement.who)
      .Bind(3, acknowledgement.at)
      .BindText(4, acknowledgement.note);
  MLE_RETURN_IF_ERROR(insert.Run());
  return transaction.Commit();
}

}  // namespace mle::watch
