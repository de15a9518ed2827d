// How a watch is written back: what differs from what is there.

#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "apps/watch/codec.h"
#include "apps/watch/state.h"
#include "apps/watch/state_checksum.h"
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
  if (status.ok()) status = SaveChecksum(watch);
  if (status.ok()) status = transaction.Commit();
  if (!status.ok()) watch.id = id;
  return status;
}

absl::Status State::SaveWatch(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(
      Statement write,
      database_.Prepare(
          watch.id == 0
              ? "INSERT INTO watch(controller, basis, begin, first, "
                "sample_time, reference, news, failed) "
                "VALUES (?, ?, ?, ?, ?, ?, ?, ?) RETURNING id"
              : "UPDATE watch SET controller = ?, basis = ?, begin = ?, "
                "first = ?, sample_time = ?, reference = ?, news = ?, "
                "failed = ? WHERE id = ?"));
  write.BindText(1, watch.controller)
      .BindText(2, watch.basis)
      .Bind(3, std::int64_t{watch.begin})
      .Bind(4, std::int64_t{watch.first})
      .Bind(5, watch.sample_time)
      .BindText(7, watch.news)
      .Bind(8, std::int64_t{watch.failed});
  if (watch.reference.has_value()) {
    write.BindText(6, EncodeReference(*watch.reference));
  }
  if (watch.id != 0) {
    write.Bind(9, watch.id);
    return write.Run();
  }
  MLE_RETURN_IF_ERROR(write.Next().status());
  watch.id = write.Integer(0);
  return write.Run();
}

absl::Status State::SaveFiles(const Watch& now, const Watch& before) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare(
          "INSERT INTO file VALUES (?, ?, ?, ?, ?, ?, ?) "
          "ON CONFLICT(watch, path) DO UPDATE SET bytes = excluded.bytes, "
          "changed = excluded.changed, first = excluded.first, "
          "last = excluded.last, fault = excluded.fault"));
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
      database_.Prepare("INSERT INTO days VALUES (?, ?, ?) ON CONFLICT(watch, "
                        "block) DO UPDATE SET data = excluded.data"));
  std::set<int> blocks;
  for (const auto& [day, seen] : now.days) blocks.insert(BlockOf(day));
  for (const int block : blocks) {
    const std::string data = EncodeDays(now, block);
    if (data == EncodeDays(before, block)) continue;
    insert.Bind(1, now.id).Bind(2, std::int64_t{block}).BindBytes(3, data);
    MLE_RETURN_IF_ERROR(insert.Run());
  }
  return absl::OkStatus();
}

absl::Status State::SaveScores(const Watch& now, const Watch& before) {
  MLE_ASSIGN_OR_RETURN(
      Statement insert,
      database_.Prepare(
          "INSERT INTO scores VALUES (?, ?, ?) ON CONFLICT(watch, "
          "number) DO UPDATE SET data = excluded.data"));
  MLE_ASSIGN_OR_RETURN(
      Statement remove,
      database_.Prepare("DELETE FROM scores WHERE watch = ? AND number = ?"));
  std::set<int> numbers;
  for (const Watch* watch : {&now, &before}) {
    for (const std::map<int, StoredBatch>& output : watch->outputs) {
      for (const auto& [number, stored] : output) numbers.insert(number);
    }
  }
  for (const int number : numbers) {
    const std::string data = EncodeScores(now, number);
    if (data == EncodeScores(before, number)) continue;
    Statement& write = data.empty() ? remove : insert;
    write.Bind(1, now.id).Bind(2, std::int64_t{number});
    if (!data.empty()) write.BindBytes(3, data);
    MLE_RETURN_IF_ERROR(write.Run());
  }
  return absl::OkStatus();
}

// What is known of alarms stays.
absl::Status State::SaveAlarms(const Watch& now) {
  MLE_ASSIGN_OR_RETURN(
      Statement alarm,
      database_.Prepare(
          "INSERT INTO alarm(id, watch, output, element, day, began, text) "
          "VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING"));
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
      database_.Prepare(
          "INSERT INTO proposal VALUES (?, ?, ?, ?, ?) "
          "ON CONFLICT(watch, day) DO UPDATE SET folder = excluded.folder, "
          "decision = excluded.decision, conclusion = excluded.conclusion"));
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

absl::Status State::SaveChecksum(const Watch& now) {
  MLE_ASSIGN_OR_RETURN(const Watch saved, Read(now.controller));
  MLE_ASSIGN_OR_RETURN(
      Statement write,
      database_.Prepare("UPDATE watch SET checksum = ? WHERE id = ?"));
  write.BindText(1, ChecksumOf(saved)).Bind(2, now.id);
  return write.Run();
}

}  // namespace mle::watch
