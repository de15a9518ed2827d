#include "apps/watch/state.h"

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

constexpr char kStateTables[] = R"sql(
CREATE TABLE watch(
  id INTEGER PRIMARY KEY, controller TEXT NOT NULL, basis TEXT NOT NULL,
  begin INTEGER NOT NULL, first INTEGER NOT NULL, sample_time REAL NOT NULL,
  reference TEXT, news TEXT NOT NULL, failed INTEGER NOT NULL,
  checksum TEXT NOT NULL DEFAULT '');
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
  began INTEGER NOT NULL, text TEXT NOT NULL, who TEXT, at INTEGER , note TEXT,
  kind INTEGER NOT NULL DEFAULT 0);
CREATE INDEX alarm_of_watch ON alarm(watch, day);
CREATE TABLE delivery(
  alarm TEXT NOT NULL REFERENCES alarm(id), channel TEXT NOT NULL,
  state INTEGER NOT NULL, attempts INTEGER NOT NULL, fault TEXT NOT NULL,
  PRIMARY KEY(alarm, channel)) WITHOUT ROWID;
CREATE TABLE proposal(
  watch INTEGER NOT NULL REFERENCES watch(id), day INTEGER NOT NULL,
  folder TEXT NOT NULL, decision TEXT NOT NULL, conclusion TEXT NOT NULL,
  PRIMARY KEY(watch, day));
CREATE TABLE trial(
  watch INTEGER NOT NULL REFERENCES watch(id), day INTEGER NOT NULL,
  last_day INTEGER NOT NULL, sample_time REAL NOT NULL, in_use TEXT NOT NULL,
  proposed TEXT NOT NULL, ended TEXT NOT NULL, fault TEXT NOT NULL,
  who TEXT, at INTEGER , note TEXT, adopted_day INTEGER NOT NULL,
  data BLOB NOT NULL, PRIMARY KEY(watch, day));
)sql";

// More are damage.
constexpr std::int64_t kMostOutputs = 100'000;

absl::Status Damaged(const std::string& controller, absl::string_view what) {
  return absl::DataLossError(absl::StrCat(
      "state: what it has of \"", controller, "\" is damaged: ", what,
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
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<Database> database,
                       Database::Open(path));
  State state(std::move(database));
  MLE_RETURN_IF_ERROR(state.MakeTables());
  return state;
}

absl::Status State::MakeTables() {
  MLE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(*database_));
  MLE_ASSIGN_OR_RETURN(const std::int64_t found, database_->Version());
  if (found == kStateVersion) return transaction.Commit();
  if (found != 0) {
    return absl::FailedPreconditionError(absl::StrCat(
        "state: it has version ", found, ", this program keeps version ",
        kStateVersion,
        " and converts none: name another --state; the watch then begins anew "
        "with the records that are there"));
  }
  MLE_RETURN_IF_ERROR(database_->Execute(kStateTables));
  MLE_RETURN_IF_ERROR(database_->SetVersion(kStateVersion));
  return transaction.Commit();
}

absl::StatusOr<Watch> State::Load(const std::string& controller, int outputs) {
  absl::StatusOr<Watch> watch = Read(controller);
  if (absl::IsDataLoss(watch.status())) {
    return Damaged(controller, watch.status().message());
  }
  MLE_RETURN_IF_ERROR(watch.status());
  if (watch->id != 0 && watch->checksum != ChecksumOf(*watch)) {
    return Damaged(controller, "it is not what was saved");
  }
  // The model had more outputs: another watch begins.
  watch->outputs.resize(static_cast<std::size_t>(outputs));
  return watch;
}

absl::StatusOr<Watch> State::Read(const std::string& controller) {
  MLE_ASSIGN_OR_RETURN(
      const Rows rows,
      database_->Run("SELECT id, basis, begin, first, sample_time, reference, "
                     "news, failed, checksum FROM watch WHERE controller = ? "
                     "ORDER BY id DESC LIMIT 1",
                     {controller}));
  Watch watch;
  watch.controller = controller;
  if (rows.empty()) return watch;
  const Row& row = rows.front();
  watch.id = row.Integer(0);
  watch.basis = row.Text(1);
  watch.begin = static_cast<int>(row.Integer(2));
  watch.first = static_cast<int>(row.Integer(3));
  watch.sample_time = row.Number(4);
  if (!row.IsNull(5)) {
    MLE_ASSIGN_OR_RETURN(watch.reference, DecodeReference(row.Text(5)));
  }
  watch.news = row.Text(6);
  watch.failed = row.Integer(7) != 0;
  watch.checksum = row.Text(8);
  MLE_RETURN_IF_ERROR(ReadRows(watch));
  MLE_RETURN_IF_ERROR(LoadAlarms(watch));
  MLE_RETURN_IF_ERROR(LoadTrials(watch));
  return watch;
}

absl::Status State::ReadRows(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(
      const Rows files,
      database_->Run("SELECT path, bytes, changed, first, last, fault FROM "
                     "file WHERE watch = ?",
                     {watch.id}));
  for (const Row& row : files) {
    watch.files[row.Text(0)] = {.bytes = row.Integer(1),
                                .changed = row.Integer(2),
                                .first = row.Number(3),
                                .last = row.Number(4),
                                .fault = row.Text(5)};
  }
  MLE_ASSIGN_OR_RETURN(
      const Rows days,
      database_->Run(
          "SELECT number, checksum, state, reason FROM day WHERE watch = ?",
          {watch.id}));
  for (const Row& row : days) {
    watch.days[static_cast<int>(row.Integer(0))] = {
        .checksum = row.Text(1),
        .state = static_cast<BatchState>(row.Integer(2)),
        .reason = row.Text(3)};
  }
  MLE_ASSIGN_OR_RETURN(
      const Rows scores,
      database_->Run(
          "SELECT output, number, length, data FROM score WHERE watch = ?",
          {watch.id}));
  for (const Row& row : scores) {
    const std::int64_t output = row.Integer(0);
    if (output < 0 || output >= kMostOutputs) {
      return absl::DataLossError("it has scores of no output");
    }
    MLE_ASSIGN_OR_RETURN(
        StoredBatch stored,
        DecodeBatch(row.Text(3), static_cast<int>(row.Integer(1)),
                    static_cast<int>(row.Integer(2))));
    const auto i = static_cast<std::size_t>(output);
    if (i >= watch.outputs.size()) watch.outputs.resize(i + 1);
    watch.outputs[i][stored.batch.number] = std::move(stored);
  }
  MLE_ASSIGN_OR_RETURN(
      const Rows proposals,
      database_->Run("SELECT day, folder, decision, conclusion FROM proposal "
                     "WHERE watch = ? ORDER BY day",
                     {watch.id}));
  for (const Row& row : proposals) {
    watch.proposals.push_back({.day = static_cast<int>(row.Integer(0)),
                               .folder = row.Text(1),
                               .decision = row.Text(2),
                               .conclusion = row.Text(3)});
  }
  return absl::OkStatus();
}

absl::StatusOr<std::int64_t> State::Revision() {
  MLE_ASSIGN_OR_RETURN(const Rows rows,
                       database_->Run(database_->Revision(), {}));
  return rows.at(0).Integer(0);
}

}  // namespace mle::watch
