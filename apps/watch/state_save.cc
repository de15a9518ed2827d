// How a watch is written back: what differs from what is there.

#include <cstdint>
#include <utility>

#include "apps/watch/codec.h"
#include "apps/watch/state.h"
#include "mle/base/status.h"

namespace mle::watch {

absl::Status State::Save(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database_));
  Watch before;
  if (watch.id != 0) {
    MLE_ASSIGN_OR_RETURN(
        before, Load(watch.controller, static_cast<int>(watch.outputs.size())));
  }
  before.outputs.resize(watch.outputs.size());
  const std::int64_t id = watch.id;
  absl::Status status = SaveWatch(watch);
  if (status.ok()) status = SaveFiles(watch, before);
  if (status.ok()) status = SaveDays(watch, before);
  if (status.ok()) status = SaveScores(watch, before);
  if (status.ok()) status = SaveAlarms(watch);
  if (status.ok()) status = transaction.Commit();
  if (!status.ok()) watch.id = id;
  return status;
}

absl::Status State::SaveWatch(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare(
          "INSERT OR REPLACE INTO watch(id, controller, basis, begin, first, "
          "sample_time, reference, news, failed) VALUES (?, ?, ?, ?, ?, ?, ?, "
          "?, ?)"));
  // An id that is not bound is made.
  if (watch.id != 0) insert.Bind(1, watch.id);
  insert.BindText(2, watch.controller)
      .BindText(3, watch.basis)
      .Bind(4, std::int64_t{watch.begin})
      .Bind(5, std::int64_t{watch.first})
      .Bind(6, watch.sample_time)
      .BindText(8, watch.news)
      .Bind(9, std::int64_t{watch.failed});
  if (watch.reference.has_value()) {
    insert.BindText(7, EncodeReference(*watch.reference));
  }
  MLE_RETURN_IF_ERROR(insert.Run());
  if (watch.id == 0) watch.id = database_.last_row();
  return absl::OkStatus();
}

absl::Status State::SaveFiles(const Watch& now, const Watch& before) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare("INSERT OR REPLACE INTO file VALUES (?, ?, ?, ?, ?, ?, "
                        "?)"));
  for (const auto& [path, file] : now.files) {
    const auto found = before.files.find(path);
    if (found != before.files.end() && found->second == file) continue;
    insert.Bind(1, now.id)
        .BindText(2, path)
        .Bind(3, file.bytes)
        .Bind(4, file.changed)
        .Bind(5, file.first)
        .Bind(6, file.last)
        .BindText(7, file.fault);
    MLE_RETURN_IF_ERROR(insert.Run());
  }
  return absl::OkStatus();
}

absl::Status State::SaveDays(const Watch& now, const Watch& before) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare("INSERT OR REPLACE INTO day VALUES (?, ?, ?, ?, ?)"));
  for (const auto& [number, day] : now.days) {
    const auto found = before.days.find(number);
    if (found != before.days.end() && found->second == day) continue;
    insert.Bind(1, now.id)
        .Bind(2, std::int64_t{number})
        .BindBytes(3, day.checksum)
        .Bind(4, static_cast<std::int64_t>(day.state))
        .BindText(5, day.reason);
    MLE_RETURN_IF_ERROR(insert.Run());
  }
  return absl::OkStatus();
}

absl::Status State::SaveScores(const Watch& now, const Watch& before) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare("INSERT OR REPLACE INTO score VALUES (?, ?, ?, ?, ?)"));
  MLE_ASSIGN_OR_RETURN(
      Statement remove,
      database_.Prepare(
          "DELETE FROM score WHERE watch = ? AND output = ? AND number = ?"));
  for (std::size_t i = 0; i < now.outputs.size(); ++i) {
    const auto output = static_cast<std::int64_t>(i);
    for (const auto& [number, stored] : before.outputs[i]) {
      if (now.outputs[i].contains(number)) continue;
      remove.Bind(1, now.id).Bind(2, output).Bind(3, std::int64_t{number});
      MLE_RETURN_IF_ERROR(remove.Run());
    }
    for (const auto& [number, stored] : now.outputs[i]) {
      const std::string data = EncodeBatch(stored);
      const auto found = before.outputs[i].find(number);
      if (found != before.outputs[i].end() &&
          found->second.batch.length == stored.batch.length &&
          EncodeBatch(found->second) == data) {
        continue;
      }
      insert.Bind(1, now.id)
          .Bind(2, output)
          .Bind(3, std::int64_t{number})
          .Bind(4, std::int64_t{stored.batch.length})
          .BindBytes(5, data);
      MLE_RETURN_IF_ERROR(insert.Run());
    }
  }
  return absl::OkStatus();
}

// What is known of alarms stays.
absl::Status State::SaveAlarms(const Watch& now) {
  MLE_ASSIGN_OR_RETURN(
      Statement alarm,
      database_.Prepare(
          "INSERT OR IGNORE INTO alarm(id, watch, output, element, day, began, "
          "text) VALUES (?, ?, ?, ?, ?, ?, ?)"));
  for (const Alarm& raised : now.alarms) {
    alarm.BindText(1, raised.id)
        .Bind(2, now.id)
        .Bind(3, std::int64_t{raised.output})
        .Bind(4, std::int64_t{raised.element})
        .Bind(5, std::int64_t{raised.day})
        .Bind(6, std::int64_t{raised.began})
        .BindText(7, raised.text);
    MLE_RETURN_IF_ERROR(alarm.Run());
  }
  MLE_ASSIGN_OR_RETURN(
      Statement proposal,
      database_.Prepare("INSERT OR REPLACE INTO proposal VALUES (?, ?, ?, ?, "
                        "?)"));
  for (const Proposal& made : now.proposals) {
    proposal.Bind(1, now.id)
        .Bind(2, std::int64_t{made.day})
        .BindText(3, made.folder)
        .BindText(4, made.decision)
        .BindText(5, made.conclusion);
    MLE_RETURN_IF_ERROR(proposal.Run());
  }
  return absl::OkStatus();
}

}  // namespace mle::watch
