#include "apps/watch/state.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "apps/watch/database.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/base/random.h"
#include "tests/mle/base/scratch_folder.h"
#include "tests/mle/database/postgresql_server.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

StoredBatch BatchOfState(int number) {
  StoredBatch stored;
  stored.batch.number = number;
  stored.batch.score = Eigen::VectorXd{{1.0, 2.0, 3.0}};
  stored.batch.information = Eigen::MatrixXd::Identity(3, 3);
  stored.evidence.log_elements = {0.5};
  return stored;
}

// In SQLite, and in PostgreSQL.
class StateTest : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!GetParam()) {
      name_ = folder_ / "state.sqlite";
      return;
    }
    if (!PostgresqlServer::IsInstalled()) GTEST_SKIP() << "no PostgreSQL";
    server_.emplace();
    ASSERT_TRUE(server_->is_running());
    name_ = server_->name("postgres");
  }

  State Open() const {
    absl::StatusOr<State> state = State::Open(name_);
    EXPECT_TRUE(state.ok()) << state.status();
    return *std::move(state);
  }

  Watch Load(State& state, const std::string& name = "column") const {
    absl::StatusOr<Watch> watch = state.Load(name, 2);
    EXPECT_TRUE(watch.ok()) << watch.status();
    return *std::move(watch);
  }
  static std::vector<PendingAlarm> Pending(State& state, Channel channel) {
    absl::StatusOr<std::vector<PendingAlarm>> pending =
        state.Undelivered(channel);
    EXPECT_TRUE(pending.ok()) << pending.status();
    return *std::move(pending);
  }
  static Watch FullWatch() {
    Watch watch;
    watch.controller = "column";
    watch.basis = "abc";
    watch.begin = watch.first = 20000;
    watch.sample_time = 1.5;
    watch.reference = WatchReference{};
    watch.reference->low = watch.reference->high = Eigen::VectorXd::Zero(1);
    watch.news = "none";
    watch.files["a.csv"] = {.bytes = 7, .changed = 8, .first = 9, .last = 10};
    watch.days[20001] = {std::string("\0\1", 2), BatchState::kUsed, ""};
    watch.days[20002] = {"x", BatchState::kCannotTell, "It is disturbed."};
    watch.outputs.resize(2);
    watch.outputs[1][1] = BatchOfState(1);
    watch.alarms.push_back(
        {.id = "id", .output = 1, .day = 20002, .text = "aged"});
    watch.proposals.push_back({.day = 20002,
                               .folder = "f",
                               .decision = "corrected",
                               .conclusion = "better"});
    return watch;
  }
  std::unique_ptr<Database> OpenDatabase() const {
    absl::StatusOr<std::unique_ptr<Database>> database = Database::Open(name_);
    EXPECT_TRUE(database.ok()) << database.status();
    return *std::move(database);
  }

  const ScratchFolder folder_;
  std::optional<PostgresqlServer> server_;
  std::string name_;
};

TEST_P(StateTest, AWatchIsReadBackAsItWasSaved) {
  State state = Open();
  EXPECT_EQ(Load(state).id, 0);
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  EXPECT_NE(watch.id, 0);
  State again = Open();
  const Watch read = Load(again);
  EXPECT_EQ(read.id, watch.id);
  EXPECT_EQ(read.basis, "abc");
  EXPECT_EQ(read.begin, 20000);
  EXPECT_EQ(read.sample_time, 1.5);
  EXPECT_TRUE(read.reference.has_value());
  EXPECT_EQ(read.files, watch.files);
  EXPECT_EQ(read.days, watch.days);
  EXPECT_EQ(read.last_day(), 20002);
  ASSERT_THAT(read.outputs, SizeIs(2));
  EXPECT_THAT(read.outputs[0], SizeIs(0));
  EXPECT_EQ(read.outputs[1].at(1).batch.score, BatchOfState(1).batch.score);
  ASSERT_THAT(read.alarms, SizeIs(1));
  EXPECT_EQ(read.alarms[0].text, "aged");
  EXPECT_THAT(read.alarms[0].deliveries, SizeIs(0));
  EXPECT_FALSE(read.alarms[0].acknowledged.has_value());
  ASSERT_THAT(read.proposals, SizeIs(1));
  EXPECT_EQ(read.proposals[0].decision, "corrected");
  EXPECT_EQ(Load(again, "another").id, 0);
}

TEST_P(StateTest, TextsThatAreNotUtf8AreKeptToo) {
  State state = Open();
  Watch watch = FullWatch();
  watch.files["t\xe4g\n.csv"] = {.bytes = 1, .fault = "\xff is not read"};
  watch.days[20002].reason = std::string("a\0b", 3);
  watch.alarms[0].text = "\xe4 has aged";
  const absl::Status saved = state.Save(watch);
  ASSERT_TRUE(saved.ok()) << saved;
  EXPECT_THAT(Load(state).files, SizeIs(2));
  EXPECT_THAT(Load(state).alarms[0].text, HasSubstr(" has aged"));
  ASSERT_TRUE(state.Save(watch).ok());
}

TEST_P(StateTest, WhatIsGoneIsRemovedAndWhatHasChangedReplaced) {
  State state = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  watch.outputs[1].clear();
  watch.outputs[1][8] = BatchOfState(8);
  watch.outputs[1][8].batch.length = 8;
  watch.days[20002].state = BatchState::kUsed;
  ASSERT_TRUE(state.Save(watch).ok());
  const Watch read = Load(state);
  ASSERT_THAT(read.outputs[1], SizeIs(1));
  EXPECT_EQ(read.outputs[1].at(8).batch.length, 8);
  EXPECT_EQ(read.days, watch.days);
}

TEST_P(StateTest, AnAlarmThatWasSentStaysSent) {
  State state = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  ASSERT_TRUE(
      state.SetDelivery("id", {.state = Delivery::State::kSent, .attempts = 2})
          .ok());
  // From memory, where it has not been sent.
  ASSERT_TRUE(state.Save(watch).ok());
  const std::vector<Delivery> deliveries = Load(state).alarms[0].deliveries;
  ASSERT_THAT(deliveries, SizeIs(1));
  EXPECT_EQ(deliveries[0].channel, Channel::kCommand);
  EXPECT_EQ(deliveries[0].state, Delivery::State::kSent);
  EXPECT_EQ(deliveries[0].attempts, 2);
  EXPECT_THAT(Pending(state, Channel::kCommand), SizeIs(0));
  // Another channel knows nothing of it.
  EXPECT_THAT(Pending(state, Channel::kMail), SizeIs(1));
}

TEST_P(StateTest, ADeliveryThatFailedIsKeptAndPending) {
  State state = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  ASSERT_TRUE(state
                  .SetDelivery("id", {.channel = Channel::kWebhook,
                                      .attempts = 1,
                                      .fault = "no answer"})
                  .ok());
  const auto pending = Pending(state, Channel::kWebhook);
  ASSERT_THAT(pending, SizeIs(1));
  EXPECT_EQ(pending[0].controller, "column");
  EXPECT_EQ(pending[0].alarm.text, "aged");
  EXPECT_EQ(pending[0].delivery.attempts, 1);
  EXPECT_EQ(pending[0].delivery.fault, "no answer");
  EXPECT_FALSE(state.SetDelivery("unknown", {}).ok());
}

TEST_P(StateTest, AnAlarmIsFoundByTheBeginningOfItsId) {
  State state = Open();
  Watch watch = FullWatch();
  watch.alarms[0].id = "abc1";
  watch.alarms.push_back({.id = "abd1", .day = 20002, .text = "aged"});
  ASSERT_TRUE(state.Save(watch).ok());
  EXPECT_EQ(state.FindAlarm("abc").value(), "abc1");
  EXPECT_EQ(state.FindAlarm("abd1").value(), "abd1");
  EXPECT_EQ(state.FindAlarm("ab").status().code(),
            absl::StatusCode::kInvalidArgument);
  for (const char* none : {"", "b", "%", "abc12"}) {
    EXPECT_EQ(state.FindAlarm(none).status().code(),
              absl::StatusCode::kNotFound)
        << none;
  }
}

TEST_P(StateTest, AnAcknowledgementStaysAsItWasFirstMade) {
  State state = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  ASSERT_TRUE(
      state.Acknowledge("id", {.who = "Ann", .at = 86400, .note = "seen"})
          .ok());
  const absl::Status again = state.Acknowledge("id", {.who = "Bob", .at = 1});
  EXPECT_EQ(again.code(), absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(std::string(again.message()), HasSubstr("Ann"));
  EXPECT_EQ(state.Acknowledge("other", {.who = "Bob"}).code(),
            absl::StatusCode::kNotFound);
  // From memory, where it is not acknowledged.
  ASSERT_TRUE(state.Save(watch).ok());
  const Watch read = Load(state);
  ASSERT_TRUE(read.alarms[0].acknowledged.has_value());
  EXPECT_EQ(read.alarms[0].acknowledged->who, "Ann");
  EXPECT_EQ(read.alarms[0].acknowledged->at, 86400);
  EXPECT_EQ(read.alarms[0].acknowledged->note, "seen");
  // Who has acknowledged an alarm need not be told of it.
  EXPECT_THAT(Pending(state, Channel::kCommand), SizeIs(0));
}

TEST_P(StateTest, ARevisionChangesWithAnothersWriting) {
  State state = Open();
  const auto before = state.Revision();
  ASSERT_TRUE(before.ok());
  EXPECT_EQ(*state.Revision(), *before);
  State other = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(other.Save(watch).ok());
  EXPECT_NE(*state.Revision(), *before);
}

TEST_P(StateTest, ANewWatchFollowsTheOldOne) {
  State state = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  Watch next;
  next.controller = "column";
  next.basis = "def";
  next.outputs.resize(2);
  ASSERT_TRUE(state.Save(next).ok());
  EXPECT_EQ(Load(state).basis, "def");
  EXPECT_THAT(Load(state).alarms, SizeIs(0));
  // The old one's alarm is still to be sent.
  const auto pending = Pending(state, Channel::kCommand);
  ASSERT_THAT(pending, SizeIs(1));
  EXPECT_EQ(pending.front().controller, "column");
}

// What docs/watch.md promises of a controller with 4 outputs and 16 elements
// whose set points move every day, after its first year: 64 days, and blocks of
// 8 of those before.
TEST_P(StateTest, AYearOfALargeControllerTakes500KilobytesAtMost) {
  constexpr int kControllers = 20;
  GaussianNoise noise(3, kRunStream);
  State state = Open();
  for (int c = 0; c < kControllers; ++c) {
    Watch watch = FullWatch();
    watch.controller = absl::StrCat("unit ", c);
    watch.alarms.clear();
    watch.proposals.clear();
    watch.outputs.assign(4, {});
    watch.reference->outputs.resize(4);
    for (OutputReference& output : watch.reference->outputs) {
      const Eigen::MatrixXd drawn = noise.DrawMatrix(120, 1, 0.01);
      output.covariances.assign(drawn.data(), drawn.data() + drawn.size());
    }
    for (int day = 0; day < 365; ++day) {
      const Eigen::MatrixXd drawn = noise.DrawMatrix(2, 1, 1.0);
      watch.days[20000 + day] = {
          std::string(reinterpret_cast<const char*>(drawn.data()), 16),
          BatchState::kUsed, ""};
      const bool old = day < 365 - 64;
      if (old && day % 8 != 0) continue;
      for (std::map<int, StoredBatch>& output : watch.outputs) {
        const Eigen::MatrixXd sensitivities = noise.DrawMatrix(12, 30, 1.0);
        StoredBatch& stored = output[day];
        stored.batch = {
            .number = day,
            .length = old ? 8 : 1,
            .score = sensitivities * noise.DrawMatrix(30, 1, 1.0),
            .information = sensitivities * sensitivities.transpose()};
        stored.evidence.log_elements.assign(4, -1.0);
      }
    }
    ASSERT_TRUE(state.Save(watch).ok());
  }
  const std::unique_ptr<Database> database = OpenDatabase();
  const absl::StatusOr<Rows> size = database->Run(
      // There the other tables have pages of their own.
      GetParam() ? "SELECT CAST(SUM(pg_total_relation_size(oid)) AS BIGINT) "
                   "FROM pg_class WHERE relname IN ('watch', 'day', 'score')"
                 : "SELECT page_count * page_size FROM pragma_page_count(), "
                   "pragma_page_size()",
      {});
  ASSERT_TRUE(size.ok()) << size.status();
  EXPECT_LT(size->at(0).Integer(0), 500'000 * kControllers);
  // Nor is it that nothing is there.
  EXPECT_GT(size->at(0).Integer(0), 250'000 * kControllers);
}

TEST_P(StateTest, ATransactionThatIsNotCommittedLeavesNothing) {
  const std::unique_ptr<Database> database = OpenDatabase();
  ASSERT_TRUE(database->Execute("CREATE TABLE t(x INTEGER)").ok());
  {
    const absl::StatusOr<Transaction> transaction =
        Transaction::Begin(*database);
    ASSERT_TRUE(transaction.ok());
    ASSERT_TRUE(database->Execute("INSERT INTO t VALUES (1)").ok());
  }
  const absl::StatusOr<Rows> count =
      database->Run("SELECT COUNT(*) FROM t", {});
  ASSERT_TRUE(count.ok());
  EXPECT_EQ(count->at(0).Integer(0), 0);
}

TEST_P(StateTest, AStateOfAnotherVersionIsRefused) {
  Open();
  for (const int version : {99, 5, 1, -1}) {
    ASSERT_TRUE(OpenDatabase()->SetVersion(version).ok());
    const absl::Status status = State::Open(name_).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
    EXPECT_THAT(std::string(status.message()),
                AllOf(HasSubstr(absl::StrCat("version ", version)),
                      HasSubstr("--state")));
  }
}

TEST_P(StateTest, WhatWasDamagedIsNotTaken) {
  State state = Open();
  Watch watch = FullWatch();
  for (const char* const damage :
       {"UPDATE watch SET basis = 'abd'",
        "UPDATE watch SET first = 20002",
        "UPDATE watch SET sample_time = 1.5000000000000002",
        "UPDATE watch SET reference = '{\"outputs\":[],\"low\":[1.0],"
        "\"high\":[0.0]}'",
        "UPDATE watch SET reference = 'x'",
        "UPDATE file SET bytes = 9",
        "UPDATE file SET path = 'b.csv'",
        "UPDATE day SET number = number + 2",
        "UPDATE day SET checksum = ''",
        "UPDATE day SET state = 1",
        "UPDATE day SET reason = 'x'",
        "DELETE FROM day",
        "UPDATE score SET output = 0",
        "UPDATE score SET output = -1",
        "UPDATE score SET output = 2000000000",
        "UPDATE score SET number = 2",
        "UPDATE score SET number = -1",
        "UPDATE score SET length = 8",
        "UPDATE score SET data = ''",
        "UPDATE score SET data = substr(data, 1, 9)",
        "UPDATE score SET data = substr(data, 9)",
        "UPDATE alarm SET output = 7",
        "UPDATE alarm SET day = 1",
        "UPDATE proposal SET folder = '/'"}) {
    ASSERT_TRUE(state.Save(watch).ok()) << damage;
    const std::unique_ptr<Database> database = OpenDatabase();
    ASSERT_TRUE(database->Execute(damage).ok()) << damage;
    const absl::Status status = state.Load("column", 2).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << damage;
    EXPECT_THAT(std::string(status.message()), HasSubstr("\"column\""));
    // Nor is it saved over.
    EXPECT_FALSE(state.Save(watch).ok()) << damage;
    // The next begins anew.
    ASSERT_TRUE(database
                    ->Execute("DELETE FROM proposal; DELETE FROM alarm; "
                              "DELETE FROM score; DELETE FROM day; "
                              "DELETE FROM file; DELETE FROM watch")
                    .ok());
    watch = FullWatch();
  }
}

TEST_P(StateTest, WhatOthersChangeIsNotDamage) {
  State state = Open();
  Watch watch = FullWatch();
  ASSERT_TRUE(state.Save(watch).ok());
  ASSERT_TRUE(state.SetDelivery("id", {.attempts = 1, .fault = "busy"}).ok());
  ASSERT_TRUE(state.Acknowledge("id", {.who = "Ann", .at = 1}).ok());
  EXPECT_TRUE(state.Load("column", 2).ok());
  // Of a model with fewer outputs.
  EXPECT_TRUE(state.Load("column", 1).ok());
}

TEST_P(StateTest, BytesAndNumbersComeBackToTheBit) {
  const std::unique_ptr<Database> database = OpenDatabase();
  ASSERT_TRUE(
      database->Execute("CREATE TABLE t(x BLOB , y REAL , z INTEGER )").ok());
  const std::string bytes("\0\xff'\\x", 5);
  ASSERT_TRUE(database
                  ->Run("INSERT INTO t VALUES (?, ?, ?)",
                        {Bytes{bytes}, 0.1 + 0.2, std::int64_t{1} << 62})
                  .ok());
  ASSERT_TRUE(
      database->Run("INSERT INTO t VALUES (?, ?, ?)", {{}, {}, {}}).ok());
  const absl::StatusOr<Rows> rows =
      database->Run("SELECT x, y, z FROM t ORDER BY z IS NULL", {});
  ASSERT_TRUE(rows.ok()) << rows.status();
  ASSERT_THAT(*rows, SizeIs(2));
  EXPECT_EQ(rows->at(0).Text(0), bytes);
  EXPECT_EQ(rows->at(0).Number(1), 0.1 + 0.2);
  EXPECT_EQ(rows->at(0).Integer(2), std::int64_t{1} << 62);
  EXPECT_TRUE(rows->at(1).IsNull(0));
  EXPECT_EQ(rows->at(1).Integer(2), 0);
}

TEST_P(StateTest, RunsOfPostgresqlExcludeEachOther) {
  if (!GetParam()) GTEST_SKIP() << "the folder has a lock";
  State first = Open();
  State second = Open();
  ASSERT_TRUE(first.Claim("").ok());
  EXPECT_EQ(second.Claim("").code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(second.Claim("1/2").code(), absl::StatusCode::kUnavailable);
  { const State ended = std::move(first); }
  State third = Open();
  // The server notices a little later that a connection has ended.
  const absl::Time patience = absl::Now() + absl::Seconds(30);
  absl::Status claimed = second.Claim("1/2");
  while (!claimed.ok() && absl::Now() < patience) {
    absl::SleepFor(absl::Milliseconds(20));
    claimed = second.Claim("1/2");
  }
  ASSERT_TRUE(claimed.ok()) << claimed;
  EXPECT_TRUE(third.Claim("2/2").ok());
  State fourth = Open();
  EXPECT_EQ(fourth.Claim("1/2").code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(fourth.Claim("").code(), absl::StatusCode::kUnavailable);
}

TEST_P(StateTest, AServerThatHasGoneIsUnavailable) {
  if (!GetParam()) GTEST_SKIP() << "there is no server";
  State state = Open();
  Watch watch = FullWatch();
  server_->Kill();
  const absl::Status saved = state.Save(watch);
  EXPECT_EQ(saved.code(), absl::StatusCode::kUnavailable) << saved;
  EXPECT_EQ(watch.id, 0);
  EXPECT_EQ(State::Open(name_).status().code(), absl::StatusCode::kUnavailable);
}

INSTANTIATE_TEST_SUITE_P(Databases, StateTest, ::testing::Bool(),
                         [](const auto& kind) {
                           return kind.param ? "Postgresql" : "Sqlite";
                         });

TEST(StateNameTest, AFileOfAnotherProgramIsLeftAlone) {
  const ScratchFolder folder;
  const std::string file = folder / "history.sqlite";
  {
    const auto other = Database::Open(file);
    ASSERT_TRUE(other.ok());
    ASSERT_TRUE((*other)->Execute("CREATE TABLE history(time, level)").ok());
  }
  const absl::StatusOr<std::string> before = ReadFile(file);
  const absl::Status status = State::Open(file).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("another program"));
  EXPECT_TRUE(*ReadFile(file) == *before);
}

TEST(StateNameTest, WhatIsNotADatabaseIsRefused) {
  const ScratchFolder folder;
  EXPECT_THAT(std::string(State::Open(folder.path()).status().message()),
              HasSubstr(folder.path()));
  EXPECT_THAT(std::string(State::Open("odbc:site").status().message()),
              HasSubstr("postgresql://"));
  const std::string password(
      State::Open("postgresql://a:geheim@h/n").status().message());
  EXPECT_THAT(password, HasSubstr("PGPASSWORD"));
  EXPECT_THAT(password, Not(HasSubstr("geheim")));
}

}  // namespace
}  // namespace mle::watch
