#include "apps/watch/state.h"

#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/watch/codec.h"
#include "apps/watch/state_checksum.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

constexpr char kTables[] = R"sql(
CREATE TABLE watch(
  id INTEGER PRIMARY KEY, controller TEXT NOT NULL, basis TEXT NOT NULL,
  begin INTEGER NOT NULL, first INTEGER NOT NULL, sample_time REAL NOT NULL,
  reference TEXT, news TEXT NOT NULL, failed INTEGER NOT NULL);
CREATE INDEX watch_of_controller ON watch(controller, id);
CREATE TABLE file(
  watch INTEGER NOT NULL REFERENCES watch(id), path TEXT NOT NULL,
  bytes INTEGER NOT NULL, changed INTEGER NOT NULL, first REAL NOT NULL,
  last REAL NOT NULL, fault TEXT NOT NULL,
  PRIMARY KEY(watch, path)) WITHOUT ROWID;
CREATE TABLE day(
  watch INTEGER NOT NULL REFERENCES watch(id), number INTEGER NOT NULL,
  checksum BLOB NOT NULL, state INTEGER NOT NULL, reason TEXT NOT NULL,
  PRIMARY KEY(watch, number)) WITHOUT ROWID;
CREATE TABLE score(
  watch INTEGER NOT NULL REFERENCES watch(id), output INTEGER NOT NULL,
  number INTEGER NOT NULL, length INTEGER NOT NULL, data BLOB NOT NULL,
  PRIMARY KEY(watch, output, number)) WITHOUT ROWID;
CREATE TABLE alarm(
  id TEXT PRIMARY KEY, watch INTEGER NOT NULL REFERENCES watch(id),
  output INTEGER NOT NULL, element INTEGER NOT NULL, day INTEGER NOT NULL,
  began INTEGER NOT NULL, text TEXT NOT NULL, delivery INTEGER NOT NULL, acknowledged TEXT NOT NULL);
CREATE INDEX alarm_of_watch ON alarm(watch, day);
CREATE TABLE proposal(
  watch INTEGER NOT NULL REFERENCES watch(id), day INTEGER NOT NULL,
  folder TEXT NOT NULL, decision TEXT NOT NULL, conclusion TEXT NOT NULL,
  PRIMARY KEY(watch, day));
)sql";

constexpr char kDeliveries[] = R"sql(
CREATE TABLE delivery(
  alarm TEXT NOT NULL REFERENCES alarm(id), channel TEXT NOT NULL,
  state INTEGER NOT NULL, attempts INTEGER NOT NULL, fault TEXT NOT NULL,
  PRIMARY KEY(alarm, channel)) WITHOUT ROWID;
CREATE TABLE acknowledgement(
  alarm TEXT NOT NULL PRIMARY KEY REFERENCES alarm(id), who TEXT NOT NULL,
  at INTEGER NOT NULL, note TEXT NOT NULL) WITHOUT ROWID;
INSERT INTO delivery
  SELECT id, 'command', delivery, 1, '' FROM alarm WHERE delivery > 0;
ALTER TABLE alarm DROP COLUMN delivery;
ALTER TABLE alarm DROP COLUMN acknowledged;
)sql";

constexpr char kChecksums[] =
    "ALTER TABLE watch ADD COLUMN checksum TEXT NOT NULL DEFAULT ''";

// Scores are packed (codec.h) from here on, which is what checksums are of.
constexpr char kPackedScores[] = "UPDATE watch SET checksum = ''";

// Step v leads from version v to v + 1.
constexpr const char* kSteps[] = {kTables, kDeliveries, kChecksums,
                                  kPackedScores};
static_assert(std::size(kSteps) == kStateVersion);

// More are damage.
constexpr std::int64_t kMostOutputs = 100'000;

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
  MLE_RETURN_IF_ERROR(state.Migrate());
  return state;
}

absl::Status State::Migrate() {
  MLE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database_));
  MLE_ASSIGN_OR_RETURN(const std::int64_t found, database_.backend().Version());
  if (found < 0 || found > kStateVersion) {
    return absl::FailedPreconditionError(absl::StrCat(
        "state: it has version ", found, "; this program knows version ",
        kStateVersion, " and those before it"));
  }
  for (auto step = static_cast<std::size_t>(found); step < std::size(kSteps);
       ++step) {
    MLE_RETURN_IF_ERROR(database_.Execute(kSteps[step]));
  }
  if (found < kStateVersion) {
    MLE_RETURN_IF_ERROR(database_.backend().SetVersion(kStateVersion));
  }
  return transaction.Commit();
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
  Watch watch;
  watch.controller = controller;
  MLE_ASSIGN_OR_RETURN(
      Statement select,
      database_.Prepare(
          "SELECT id, basis, begin, first, sample_time, reference, news, "
          "failed, checksum FROM watch WHERE controller = ? "
          "ORDER BY id DESC LIMIT 1"));
  select.BindText(1, controller);
  MLE_ASSIGN_OR_RETURN(const bool found, select.Next());
  if (!found) return watch;
  watch.id = select.Integer(0);
  watch.basis = select.Text(1);
  watch.begin = static_cast<int>(select.Integer(2));
  watch.first = static_cast<int>(select.Integer(3));
  watch.sample_time = select.Number(4);
  if (!select.IsNull(5)) {
    absl::StatusOr<WatchReference> reference = DecodeReference(select.Text(5));
    if (!reference.ok()) return Damaged(watch, reference.status().message());
    watch.reference = *std::move(reference);
  }
  watch.news = select.Text(6);
  watch.failed = select.Integer(7) != 0;
  watch.checksum = select.Text(8);
  MLE_RETURN_IF_ERROR(LoadFiles(watch));
  MLE_RETURN_IF_ERROR(LoadDays(watch));
  MLE_RETURN_IF_ERROR(LoadScores(watch));
  MLE_RETURN_IF_ERROR(LoadAlarms(watch));
  MLE_RETURN_IF_ERROR(LoadProposals(watch));
  return watch;
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
  return ForEach(
      "SELECT number, checksum, state, reason FROM day WHERE watch = ?", watch,
      [&watch](const Statement& row) {
        watch.days[static_cast<int>(row.Integer(0))] = {
            .checksum = row.Text(1),
            .state = static_cast<BatchState>(row.Integer(2)),
            .reason = row.Text(3)};
        return absl::OkStatus();
      });
}

absl::Status State::LoadScores(Watch& watch) {
  return ForEach(
      "SELECT output, number, length, data FROM score WHERE watch = ?", watch,
      [&watch](const Statement& row) -> absl::Status {
        const std::int64_t number = row.Integer(0);
        absl::StatusOr<StoredBatch> decoded = DecodeBatch(row.Text(3));
        if (number < 0 || number >= kMostOutputs || !decoded.ok()) {
          return Damaged(watch, decoded.ok() ? "it has scores of no output"
                                             : decoded.status().message());
        }
        StoredBatch stored = *std::move(decoded);
        const auto output = static_cast<std::size_t>(number);
        if (output >= watch.outputs.size()) watch.outputs.resize(output + 1);
        stored.batch.number = static_cast<int>(row.Integer(1));
        stored.batch.length = static_cast<int>(row.Integer(2));
        stored.evidence.number = stored.batch.number + stored.batch.length - 1;
        watch.outputs[output].emplace(stored.batch.number, std::move(stored));
        return absl::OkStatus();
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
