// How a watch is written back: what differs from what is there.

#include <cstdint>

#include "apps/watch/state.h"
#include "mle/base/status.h"

namespace mle::watch {

absl::Status State::Save(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(*database_));
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
  if (status.ok()) status = SaveTrials(watch, before);
  if (status.ok()) status = SaveChecksum(watch);
  if (status.ok()) status = transaction.Commit();
  if (!status.ok()) watch.id = id;
  return status;
}

absl::Status State::SaveWatch(Watch& watch) {
  const Value reference = watch.reference.has_value()
                              ? Value(EncodeReference(*watch.reference))
                              : Value();
  std::vector<Value> values = {
      watch.controller,  watch.basis, watch.begin, watch.first,
      watch.sample_time, reference,   watch.news,  std::int64_t{watch.failed}};
  if (watch.id != 0) {
    values.emplace_back(watch.id);
    return Write(
        "UPDATE watch SET controller = ?, basis = ?, begin = ?, first = ?, "
        "sample_time = ?, reference = ?, news = ?, failed = ? WHERE id = ?",
        values);
  }
  MLE_ASSIGN_OR_RETURN(
      const Rows rows,
      database_->Run("INSERT INTO watch(controller, basis, begin, first, "
                     "sample_time, reference, news, failed) "
                     "VALUES (?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
                     values));
  watch.id = rows.at(0).Integer(0);
  return absl::OkStatus();
}

absl::Status State::SaveFiles(const Watch& now, const Watch& before) {
  for (const auto& [path, file] : now.files) {
    const auto found = before.files.find(path);
    if (found != before.files.end() && found->second == file) continue;
    MLE_RETURN_IF_ERROR(
        Write("INSERT INTO file VALUES (?, ?, ?, ?, ?, ?, ?) "
              "ON CONFLICT(watch, path) DO UPDATE SET bytes = excluded.bytes, "
              "changed = excluded.changed, first = excluded.first, "
              "last = excluded.last, fault = excluded.fault",
              {now.id, path, file.bytes, file.changed, file.first, file.last,
               file.fault}));
  }
  return absl::OkStatus();
}

absl::Status State::SaveDays(const Watch& now, const Watch& before) {
  for (const auto& [number, day] : now.days) {
    const auto found = before.days.find(number);
    if (found != before.days.end() && found->second == day) continue;
    MLE_RETURN_IF_ERROR(
        Write("INSERT INTO day VALUES (?, ?, ?, ?, ?) ON CONFLICT(watch, "
              "number) DO UPDATE SET checksum = excluded.checksum, "
              "state = excluded.state, reason = excluded.reason",
              {now.id, number, Bytes{day.checksum},
               static_cast<std::int64_t>(day.state), day.reason}));
  }
  return absl::OkStatus();
}

absl::Status State::SaveScores(const Watch& now, const Watch& before) {
  for (std::size_t i = 0; i < now.outputs.size(); ++i) {
    const auto output = static_cast<std::int64_t>(i);
    for (const auto& [number, stored] : before.outputs[i]) {
      if (now.outputs[i].contains(number)) continue;
      MLE_RETURN_IF_ERROR(Write(
          "DELETE FROM score WHERE watch = ? AND output = ? AND number = ?",
          {now.id, output, number}));
    }
    for (const auto& [number, stored] : now.outputs[i]) {
      const std::string data = EncodeBatch(stored);
      const auto found = before.outputs[i].find(number);
      if (found != before.outputs[i].end() &&
          found->second.batch.length == stored.batch.length &&
          EncodeBatch(found->second) == data) {
        continue;
      }
      MLE_RETURN_IF_ERROR(Write(
          "INSERT INTO score VALUES (?, ?, ?, ?, ?) ON CONFLICT(watch, output, "
          "number) DO UPDATE SET length = excluded.length, "
          "data = excluded.data",
          {now.id, output, number, stored.batch.length, Bytes{data}}));
    }
  }
  return absl::OkStatus();
}

// Alarms that are in the state already stay as they are.
absl::Status State::SaveAlarms(const Watch& now) {
  for (const Alarm& alarm : now.alarms) {
    MLE_RETURN_IF_ERROR(Write(
        "INSERT INTO alarm(id, watch, output, element, day, began, text, "
        "kind) VALUES (?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
        {alarm.id, now.id, alarm.output, alarm.element, alarm.day, alarm.began,
         alarm.text, static_cast<std::int64_t>(alarm.kind)}));
  }
  for (const Proposal& made : now.proposals) {
    MLE_RETURN_IF_ERROR(
        Write("INSERT INTO proposal VALUES (?, ?, ?, ?, ?) "
              "ON CONFLICT(watch, day) DO UPDATE SET folder = excluded.folder, "
              "decision = excluded.decision, conclusion = excluded.conclusion",
              {now.id, made.day, made.folder, made.decision, made.conclusion}));
  }
  return absl::OkStatus();
}

absl::Status State::SaveChecksum(const Watch& now) {
  MLE_ASSIGN_OR_RETURN(const Watch saved, Read(now.controller));
  return Write("UPDATE watch SET checksum = ? WHERE id = ?",
               {ChecksumOf(saved), now.id});
}

}  // namespace mle::watch
