#include "apps/watch/state.h"

#include <cstdint>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/watch/codec.h"
#include "apps/watch/state_checksum.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

// Beyond these a number is damage.
constexpr std::int64_t kLastNumber = 10'000'000;

absl::Status Damaged(const Watch& watch, absl::string_view what) {
  return absl::DataLossError(absl::StrCat(
      "state: what it has of \"", watch.controller, "\" is damaged: ", what,
      "; put a copy of the state in its place, or move it away: a new watch "
      "then begins with the records that are there"));
}

}  // namespace

Watch EmptyWatch(const std::string& controller, int outputs) {
  Watch watch;
  watch.controller = controller;
  watch.outputs.resize(static_cast<std::size_t>(outputs));
  return watch;
}

absl::StatusOr<State> State::Open(const std::string& path) {
  MLE_ASSIGN_OR_RETURN(Database database, Database::Open(path));
  State state(std::move(database));
  MLE_RETURN_IF_ERROR(state.BringUpToDate());
  return state;
}

absl::StatusOr<Watch> State::Load(const std::string& controller, int outputs) {
  MLE_ASSIGN_OR_RETURN(Watch watch, Read(controller));
  if (!watch.checksum.empty() && watch.checksum != ChecksumOf(watch)) {
    return Damaged(watch, "it is not what was saved");
  }
  // The model had more outputs: another watch begins.
  watch.outputs.resize(static_cast<std::size_t>(outputs));
  return watch;
}

absl::StatusOr<Watch> State::Read(const std::string& controller) {
  MLE_ASSIGN_OR_RETURN(
      Statement select,
      database_.Prepare("SELECT id FROM watch WHERE controller = ? ORDER BY id "
                        "DESC LIMIT 1"));
  select.BindText(1, controller);
  MLE_ASSIGN_OR_RETURN(const bool found, select.Next());
  Watch watch;
  watch.controller = controller;
  if (!found) return watch;
  watch.id = select.Integer(0);
  MLE_RETURN_IF_ERROR(LoadHead(watch));
  MLE_RETURN_IF_ERROR(LoadDays(watch));
  MLE_RETURN_IF_ERROR(LoadScores(watch));
  return watch;
}

absl::Status State::LoadHead(Watch& watch) {
  MLE_RETURN_IF_ERROR(ForEach(
      "SELECT basis, begin, first, sample_time, reference, news, failed, "
      "checksum, controller FROM watch WHERE id = ?",
      watch, [&watch](const Statement& row) -> absl::Status {
        watch.basis = row.Text(0);
        watch.begin = static_cast<int>(row.Integer(1));
        watch.first = static_cast<int>(row.Integer(2));
        watch.sample_time = row.Number(3);
        watch.news = row.Text(5);
        watch.failed = row.Integer(6) != 0;
        watch.checksum = row.Text(7);
        watch.controller = row.Text(8);
        if (row.IsNull(4)) return absl::OkStatus();
        absl::StatusOr<WatchReference> reference = DecodeReference(row.Text(4));
        if (!reference.ok()) {
          return Damaged(watch, reference.status().message());
        }
        watch.reference = *std::move(reference);
        return absl::OkStatus();
      }));
  MLE_RETURN_IF_ERROR(LoadFiles(watch));
  MLE_RETURN_IF_ERROR(LoadAlarms(watch));
  return LoadProposals(watch);
}

absl::Status State::ForEach(
    std::string_view query, const Watch& watch,
    const std::function<absl::Status(const Statement&)>& take) {
  MLE_ASSIGN_OR_RETURN(Statement select, database_.Prepare(query));
  select.Bind(1, watch.id);
  while (true) {
    MLE_ASSIGN_OR_RETURN(const bool row, select.Next());
    if (!row) return absl::OkStatus();
    MLE_RETURN_IF_ERROR(take(select));
  }
}

absl::Status State::LoadFiles(Watch& watch) {
  return ForEach(
      "SELECT path, bytes, changed, first, last, fault FROM file WHERE watch = "
      "?",
      watch, [&watch](const Statement& row) {
        watch.files[row.Text(0)] = {.bytes = row.Integer(1),
                                    .changed = row.Integer(2),
                                    .first = row.Number(3),
                                    .last = row.Number(4),
                                    .fault = row.Text(5)};
        return absl::OkStatus();
      });
}

absl::Status State::LoadDays(Watch& watch) {
  return ForEach("SELECT block, data FROM days WHERE watch = ?", watch,
                 [&watch](const Statement& row) -> absl::Status {
                   const std::int64_t block = row.Integer(0);
                   if (std::abs(block) > kLastNumber) {
                     return Damaged(watch, "it has days of no date");
                   }
                   const absl::Status status =
                       DecodeDays(row.Text(1), static_cast<int>(block), watch);
                   return status.ok() ? status
                                      : Damaged(watch, status.message());
                 });
}

absl::Status State::LoadScores(Watch& watch) {
  return ForEach(
      "SELECT number, data FROM scores WHERE watch = ?", watch,
      [&watch](const Statement& row) -> absl::Status {
        const std::int64_t number = row.Integer(0);
        if (number < 0 || number > kLastNumber) {
          return Damaged(watch, "it has scores of no day");
        }
        const absl::Status status =
            DecodeScores(row.Text(1), static_cast<int>(number), watch);
        return status.ok() ? status : Damaged(watch, status.message());
      });
}

absl::Status State::LoadProposals(Watch& watch) {
  return ForEach(
      "SELECT day, folder, decision, conclusion FROM proposal WHERE watch = ? "
      "ORDER BY day",
      watch, [&watch](const Statement& row) {
        watch.proposals.push_back({.day = static_cast<int>(row.Integer(0)),
                                   .folder = row.Text(1),
                                   .decision = row.Text(2),
                                   .conclusion = row.Text(3)});
        return absl::OkStatus();
      });
}

absl::StatusOr<std::int64_t> State::Revision() {
  MLE_ASSIGN_OR_RETURN(Statement select,
                       database_.Prepare(database_.backend().Revision()));
  MLE_RETURN_IF_ERROR(select.Next().status());
  return select.Integer(0);
}

}  // namespace mle::watch
