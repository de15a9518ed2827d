// How a state of an earlier version is brought up to date.

#include <cstdint>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/watch/codec.h"
#include "apps/watch/scores_of_version_4.h"
#include "apps/watch/state.h"
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

// Scores of all outputs in one row, days in blocks: State::ConvertScores() then
// fills them.
constexpr char kScoresTogether[] = R"sql(
CREATE TABLE days(
  watch INT NOT NULL REFERENCES watch(id), block INT NOT NULL,
  data BLOB NOT NULL, PRIMARY KEY(watch, block));
CREATE TABLE scores(
  watch INT NOT NULL REFERENCES watch(id), number INT NOT NULL,
  data BLOB NOT NULL, PRIMARY KEY(watch, number));
)sql";

// Step v leads from version v to v + 1.
constexpr const char* kSteps[] = {kTables, kDeliveries, kChecksums,
                                  kPackedScores, kScoresTogether};
static_assert(std::size(kSteps) == kStateVersion);

// A watch that was damaged before has it: the checksum of none.
constexpr char kDamagedBefore[] = "damaged in version 4";

// More are damage.
constexpr std::int64_t kMostOutputs = 100'000;

}  // namespace

absl::Status State::BringUpToDate() {
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
    MLE_RETURN_IF_ERROR(ConvertScores());
    MLE_RETURN_IF_ERROR(database_.backend().SetVersion(kStateVersion));
  }
  return transaction.Commit();
}

absl::Status State::ConvertScores() {
  std::vector<std::int64_t> ids;
  {
    MLE_ASSIGN_OR_RETURN(Statement select,
                         database_.Prepare("SELECT id FROM watch ORDER BY id"));
    while (true) {
      MLE_ASSIGN_OR_RETURN(const bool row, select.Next());
      if (!row) break;
      ids.push_back(select.Integer(0));
    }
  }
  for (const std::int64_t id : ids) {
    Watch watch;
    watch.id = id;
    absl::Status status = LoadHead(watch);
    if (status.ok()) status = LoadVersion4(watch);
    if (!status.ok() && !absl::IsDataLoss(status)) return status;
    if (status.ok()) {
      for (std::map<int, StoredBatch>& output : watch.outputs) {
        for (auto& [number, stored] : output) {
          RoundAsKept(stored.batch);
          stored.evidence = AsKept(std::move(stored.evidence));
        }
      }
      Watch none;
      none.outputs.resize(watch.outputs.size());
      MLE_RETURN_IF_ERROR(SaveDays(watch, none));
      MLE_RETURN_IF_ERROR(SaveScores(watch, none));
    }
    if (status.ok() && watch.checksum.empty()) continue;
    MLE_ASSIGN_OR_RETURN(
        Statement write,
        database_.Prepare("UPDATE watch SET checksum = ? WHERE id = ?"));
    write.BindText(1, status.ok() ? ChecksumOf(watch) : kDamagedBefore)
        .Bind(2, id);
    MLE_RETURN_IF_ERROR(write.Run());
  }
  return database_.Execute("DROP TABLE day; DROP TABLE score");
}

// Days and scores of the watch. DataLoss where they are not what was saved.
absl::Status State::LoadVersion4(Watch& watch) {
  MLE_RETURN_IF_ERROR(
      ForEach("SELECT number, checksum, state, reason FROM day WHERE watch = ?",
              watch, [&watch](const Statement& row) {
                watch.days[static_cast<int>(row.Integer(0))] = {
                    .checksum = row.Text(1),
                    .state = static_cast<BatchState>(row.Integer(2)),
                    .reason = row.Text(3)};
                return absl::OkStatus();
              }));
  std::map<std::pair<std::size_t, int>, std::string> kept;
  MLE_RETURN_IF_ERROR(ForEach(
      "SELECT output, number, length, data FROM score WHERE watch = ?", watch,
      [&watch, &kept](const Statement& row) -> absl::Status {
        const std::int64_t of = row.Integer(0);
        if (of < 0 || of >= kMostOutputs) {
          return absl::DataLossError("it has scores of no output");
        }
        const std::string bytes = row.Text(3);
        MLE_ASSIGN_OR_RETURN(StoredBatch stored, DecodeBatchOfVersion4(bytes));
        const auto output = static_cast<std::size_t>(of);
        const auto number = static_cast<int>(row.Integer(1));
        if (output >= watch.outputs.size()) watch.outputs.resize(output + 1);
        stored.batch.number = number;
        stored.batch.length = static_cast<int>(row.Integer(2));
        kept[{output, number}] = AsVersion4Wrote(bytes);
        watch.outputs[output].emplace(number, std::move(stored));
        return absl::OkStatus();
      }));
  if (watch.checksum.empty()) return absl::OkStatus();
  const std::string checksum =
      ChecksumOf(watch, [&kept](std::size_t output, const StoredBatch& stored) {
        return kept.at({output, stored.batch.number});
      });
  return checksum == watch.checksum
             ? absl::OkStatus()
             : absl::DataLossError("it is not what was saved");
}

}  // namespace mle::watch
