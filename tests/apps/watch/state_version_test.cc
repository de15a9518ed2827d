// States of earlier versions.

#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/escaping.h"
#include "apps/watch/database.h"
#include "apps/watch/scores_of_version_4.h"
#include "apps/watch/state.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/monitor/change_evidence.h"
#include "tests/apps/watch/state_databases.h"

namespace mle::watch {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

// As far as alarms need it.
constexpr char kFirstVersion[] = R"sql(
CREATE TABLE watch(
  id INTEGER PRIMARY KEY, controller TEXT NOT NULL, basis TEXT NOT NULL,
  begin INTEGER NOT NULL, first INTEGER NOT NULL, sample_time REAL NOT NULL,
  reference TEXT, news TEXT NOT NULL, failed INTEGER NOT NULL);
CREATE TABLE file(watch, path, bytes, changed, first, last, fault);
CREATE TABLE day(watch, number, checksum, state, reason);
CREATE TABLE score(watch, output, number, length, data);
CREATE TABLE proposal(watch, day, folder, decision, conclusion);
CREATE TABLE alarm(
  id TEXT PRIMARY KEY, watch INTEGER NOT NULL REFERENCES watch(id),
  output INTEGER NOT NULL, element INTEGER NOT NULL, day INTEGER NOT NULL,
  began INTEGER NOT NULL, text TEXT NOT NULL, delivery INTEGER NOT NULL,
  acknowledged TEXT NOT NULL);
INSERT INTO watch VALUES(1, 'column', 'b', 1, 1, 1.0, NULL, '', 0);
INSERT INTO alarm VALUES('a', 1, 0, -1, 5, 4, 'waiting', 0, '');
INSERT INTO alarm VALUES('b', 1, 0, -1, 6, 4, 'sent', 2, '');
PRAGMA user_version = 1;
)sql";

// As version 4 left it: a tank whose gain is 0.6 of the model's from day 5 on,
// set points that move twice a day, three days of reference.
constexpr char kFourthVersion[] = R"sql(
CREATE TABLE watch(
  id INTEGER PRIMARY KEY, controller TEXT NOT NULL, basis TEXT NOT NULL,
  begin INTEGER NOT NULL, first INTEGER NOT NULL, sample_time REAL NOT NULL,
  reference TEXT, news TEXT NOT NULL, failed INTEGER NOT NULL,
  checksum TEXT NOT NULL DEFAULT '');
CREATE TABLE file(
  watch INTEGER NOT NULL REFERENCES watch(id), path TEXT NOT NULL,
  bytes INTEGER NOT NULL, changed INTEGER NOT NULL, first REAL NOT NULL,
  last REAL NOT NULL, fault TEXT NOT NULL, PRIMARY KEY(watch, path));
CREATE TABLE day(
  watch INTEGER NOT NULL REFERENCES watch(id), number INTEGER NOT NULL,
  checksum BLOB NOT NULL, state INTEGER NOT NULL, reason TEXT NOT NULL,
  PRIMARY KEY(watch, number));
CREATE TABLE score(
  watch INTEGER NOT NULL REFERENCES watch(id), output INTEGER NOT NULL,
  number INTEGER NOT NULL, length INTEGER NOT NULL, data BLOB NOT NULL,
  PRIMARY KEY(watch, output, number));
CREATE TABLE alarm(
  id TEXT PRIMARY KEY, watch INTEGER NOT NULL REFERENCES watch(id),
  output INTEGER NOT NULL, element INTEGER NOT NULL, day INTEGER NOT NULL,
  began INTEGER NOT NULL, text TEXT NOT NULL);
CREATE TABLE proposal(
  watch INTEGER NOT NULL REFERENCES watch(id), day INTEGER NOT NULL,
  folder TEXT NOT NULL, decision TEXT NOT NULL, conclusion TEXT NOT NULL,
  PRIMARY KEY(watch, day));
CREATE TABLE delivery(
  alarm TEXT NOT NULL REFERENCES alarm(id), channel TEXT NOT NULL,
  state INTEGER NOT NULL, attempts INTEGER NOT NULL, fault TEXT NOT NULL,
  PRIMARY KEY(alarm, channel));
CREATE TABLE acknowledgement(
  alarm TEXT NOT NULL PRIMARY KEY REFERENCES alarm(id), who TEXT NOT NULL,
  at INTEGER NOT NULL, note TEXT NOT NULL);
INSERT INTO watch VALUES(1, 'tank',
  '18419d5a45ec56a936a5a5f8307279b0d670fa4fe486963926a3ab7433e99a07',
  20454, 20454, 10.0,
  '{"outputs":[{"variance":0.0009300614671289674,"ratio":0.0005707965'
  || '167971364,"offset":true,"colour_ratio":0.0,"colour_pole":0.0,"colo'
  || 'ur_damping":0.0,"deviation":0.9675712155352248,"covariances":[1.00'
  || '35479483359786,0.021284950013150762,0.019613366469570546,0.0660122'
  || '0899622007,0.08008979965142939,-0.01331679793141383,-0.00588451525'
  || '209161,0.013072585000884537,0.011020224513010149,-0.03701498332455'
  || '453,-0.0034089720314051755,-0.019872667383416143,0.016194037363367'
  || '032]}],"low":[-0.0634214358367701,-0.19633727382486393],"high":[1.'
  || '0666780375928746,1.1973102229565669],"operation":[{"changes":2.0,"'
  || 'change_size":1.0,"squared_error":0.0010466824452477642}]}',
  '', 0,
  '034a2b336b1377ab13528193d7b48514f28c64eb3604049b4f61c9e18603bca3');
INSERT INTO file VALUES(1, 'rec/a.csv', 81886, 1795652070961570614, 1767225600.0,
  1768002600.0, '');
INSERT INTO alarm VALUES('3e7a9cc0a20ca03270650d2ad909e682', 1, 0, -1, 20459, 20459,
  'The model of y has aged. Most likely (100 %) it is y ← u: it'
  || 's gain has changed by −39.0 ± 1.1 %, since about 2026-01-06.');
INSERT INTO alarm VALUES('33dedf81e8588bd796a99ba69ee5fbb4', 1, 0, 0, 20459, 20459,
  'The element y ← u has aged, whatever the others did.');
)sql";

constexpr int kFirst4 = 20454;
// From that day on.
constexpr std::string_view kChecksums4[] = {
    "4d10ce825d6fec39a0d7f6b8f94df1e8", "43869aadd325283f7d10da072824701e",
    "e0297cd06ea6d7fe47a613eabf9145d6", "0516146b3f4ff227426f5f53791609cf",
    "ed141f17eb5e596d97ee1fe2e38b2ec1", "8774d5f8c4c7e304e72633d8b33aaae5",
    "800073e6816b6bd4929f8866daf0242a", "710ddc1552bbce2d1c9d83f1d1a5b81b",
    "7d77288dd71d9411014114c61c0c40d9",
};

constexpr std::string_view kScores4[] = {
    "0003000705060a5fdfda8e6f380b9856d9560093bd94ea25ad9a2e2bbb9a2e2b"
    "bb",
    "000300070506635788dee464d40a484e544f01cdd58d0aa58f26722fbb26722f"
    "bb",
    "00030007050624539bddff63fd09dc4d8a4f000e335d81972fa9e138bba9e138"
    "bb",
    "0003000705061660a0d997714d0bee58de570149feb7f2f59020d13cbb20d13c"
    "bb",
    "000300070506d65e53dbf86ddd0a8855fb5502ecba9fee92df93ec4abb93ec4a"
    "bb",
    "000301070505814ca6e5ad4086016f63676705cf847106bcfa070506866bc1da"
    "b05aab007645324906f8aad80189fcf024ab43f024ab43",
    "000301070405dc4561cfa2762200465abd6105a68f12057afc0705067562c8dd"
    "39534b00823f10440634b1df01fdfff5564c44f5564c44",
    "000301070505634eebe3334360008067506d05b08390ff5df9070506cf6ddad9"
    "6c5db30059478c4c066aaa17ffa6fb1377954413779544",
    "0003010604053c7a81d2a46884ffe550a25505b69bbd01cafe0705051a5657e0"
    "d5498eff0a729a7806aaba7f01f6fe5ba4ad445ba4ad44",
};
// ln E after each of them.
constexpr double kEvidence4[] = {-0.00261203, -0.00267709, -0.00282107,
                                 -0.00288112, -0.00309638, 342.289,
                                 817.359,     1195.72,     1389.14};

class StateVersionTest : public StateDatabases {
 protected:
  // The state of version 4, by other hands.
  absl::StatusOr<Database> MakeVersion4() const {
    absl::StatusOr<Database> database = Database::Open(name_);
    EXPECT_TRUE(database.ok()) << database.status();
    EXPECT_TRUE(database->Execute(kFourthVersion).ok());
    absl::StatusOr<Statement> day =
        database->Prepare("INSERT INTO day VALUES (1, ?, ?, 0, '')");
    EXPECT_TRUE(day.ok()) << day.status();
    std::int64_t number = kFirst4;
    for (const std::string_view checksum : kChecksums4) {
      day->Bind(1, number++).BindBytes(2, Bytes(checksum));
      EXPECT_TRUE(day->Run().ok());
    }
    absl::StatusOr<Statement> score =
        database->Prepare("INSERT INTO score VALUES (1, 0, ?, 1, ?)");
    EXPECT_TRUE(score.ok()) << score.status();
    number = 0;
    for (const std::string_view data : kScores4) {
      score->Bind(1, number++).BindBytes(2, Bytes(data));
      EXPECT_TRUE(score->Run().ok());
    }
    EXPECT_TRUE(database->backend().SetVersion(4).ok());
    return database;
  }
  static std::string Bytes(std::string_view hex) {
    return absl::HexStringToBytes(std::string(hex));
  }
};

TEST_P(StateVersionTest, AStateOfTheFirstVersionIsBroughtUpToDate) {
  if (GetParam()) GTEST_SKIP() << "the first version was SQLite's alone";
  {
    absl::StatusOr<Database> database = Database::Open(name_);
    ASSERT_TRUE(database.ok());
    ASSERT_TRUE(database->Execute(kFirstVersion).ok());
  }
  State state = Open();
  const Watch watch = *state.Load("column", 2);
  ASSERT_THAT(watch.alarms, SizeIs(2));
  EXPECT_EQ(watch.alarms[1].text, "sent");
  ASSERT_THAT(watch.alarms[1].deliveries, SizeIs(1));
  EXPECT_EQ(watch.alarms[1].deliveries[0].state, Delivery::State::kSent);
  const auto pending = *state.Undelivered(Channel::kCommand);
  ASSERT_THAT(pending, SizeIs(1));
  EXPECT_EQ(pending[0].alarm.text, "waiting");
}

TEST_P(StateVersionTest, AStateOfVersion4IsConvertedWhole) {
  ASSERT_TRUE(MakeVersion4().ok());
  State state = Open();
  absl::StatusOr<Watch> watch = state.Load("tank", 1);
  ASSERT_TRUE(watch.ok()) << watch.status();
  EXPECT_THAT(watch->checksum, SizeIs(64));
  ASSERT_THAT(watch->days, SizeIs(9));
  EXPECT_EQ(watch->days.at(kFirst4 + 8).checksum, Bytes(kChecksums4[8]));
  ASSERT_THAT(watch->alarms, SizeIs(2));
  EXPECT_EQ(watch->alarms[0].day, kFirst4 + 5);
  ASSERT_THAT(watch->outputs[0], SizeIs(9));
  EXPECT_TRUE(watch->outputs[0].at(8).batch.largest.has_value() ==
              watch->outputs[0].at(7).batch.largest.has_value());
  // The version is reached once; what is there is what was saved.
  ASSERT_TRUE(Open().Save(*watch).ok());
  EXPECT_TRUE(Open().Load("tank", 1).ok());
}

// From the scores as they are now follows what version 4 found from its own:
// the alarm of the same day.
TEST_P(StateVersionTest, TheScoresOfVersion4SayTheSame) {
  ASSERT_TRUE(MakeVersion4().ok());
  State state = Open();
  const absl::StatusOr<Watch> watch = state.Load("tank", 1);
  ASSERT_TRUE(watch.ok()) << watch.status();
  const Eigen::VectorXd least{{0.005, 0.005, 0.1}};
  std::vector<ScoredBatch> batches;
  for (const auto& [number, stored] : watch->outputs[0]) {
    batches.push_back(stored.batch);
    const double evidence =
        ConfirmedEvidenceOf(batches, least, WatchOptions()).log_output;
    EXPECT_NEAR(evidence, kEvidence4[number], 0.01 + 1e-3 * evidence) << number;
    EXPECT_NEAR(stored.evidence.log_output, kEvidence4[number], 0.011);
    EXPECT_EQ(stored.evidence.number, number);
  }
}

// What was damaged is not made whole by another version.
TEST_P(StateVersionTest, ADamagedWatchOfVersion4StaysDamaged) {
  for (const char* const damage :
       {"UPDATE day SET state = 1 WHERE number = 20455",
        "DELETE FROM day WHERE number = 20455",
        "UPDATE score SET length = 8 WHERE number = 1",
        "UPDATE score SET output = 1 WHERE number = 1",
        "UPDATE score SET output = -1 WHERE number = 1",
        "UPDATE score SET data = substr(data, 1, 20) WHERE number = 1",
        "UPDATE watch SET reference = 'x'", "UPDATE alarm SET day = 1"}) {
    const absl::StatusOr<Database> database = MakeVersion4();
    ASSERT_TRUE(database.ok());
    absl::StatusOr<Database> other = Database::Open(name_);
    ASSERT_TRUE(other->Execute(damage).ok()) << damage;
    {
      State state = Open();
      const absl::Status status = state.Load("tank", 1).status();
      EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << damage;
      EXPECT_THAT(std::string(status.message()), HasSubstr("\"tank\""));
    }
    ASSERT_TRUE(other
                    ->Execute("DROP TABLE proposal; DROP TABLE delivery; "
                              "DROP TABLE acknowledgement; DROP TABLE alarm; "
                              "DROP TABLE days; DROP TABLE scores; "
                              "DROP TABLE file; DROP TABLE watch")
                    .ok());
    ASSERT_TRUE(other->backend().SetVersion(0).ok());
  }
}

// n, and all in single precision; version 4 wrote them with a header.
TEST(ScoresOfVersion4Test, ThoseOfVersion3AreRead) {
  std::string bytes(1, 3);
  for (const float value :
       {1.5F, -2.0F, 0.1F, 4.0F, 1.0F, 3.0F, 0.5F, 0.2F, 2.0F, 1.25F, -0.5F}) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  for (const std::string& given : {bytes, AsVersion4Wrote(bytes)}) {
    const auto read = DecodeBatchOfVersion4(given);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->batch.score(1), -2.0);
    EXPECT_EQ(read->batch.information(2, 1), 0.2F);
    EXPECT_EQ(read->batch.information(1, 2), 0.2F);
    EXPECT_EQ(read->evidence.log_output, 1.25);
    EXPECT_EQ(read->evidence.log_elements, (std::vector<double>{-0.5}));
  }
  EXPECT_EQ(AsVersion4Wrote(bytes), std::string("\1\3\0", 3) + bytes.substr(1));
  EXPECT_FALSE(DecodeBatchOfVersion4(bytes + "x").ok());
  EXPECT_FALSE(DecodeBatchOfVersion4("").ok());
}

// A damaged number is none: what is made of it could not be kept.
TEST(ScoresOfVersion4Test, WhatIsNoNumberIsDamage) {
  for (std::size_t damaged = 0; damaged < 11; ++damaged) {
    std::string bytes(1, 3);
    for (std::size_t i = 0; i < 11; ++i) {
      const float value =
          i == damaged ? std::numeric_limits<float>::quiet_NaN() : 1.0F;
      bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
    }
    EXPECT_FALSE(DecodeBatchOfVersion4(bytes).ok()) << damaged;
  }
}

INSTANTIATE_TEST_SUITE_P(Databases, StateVersionTest, ::testing::Bool(),
                         [](const auto& kind) {
                           return kind.param ? "Postgresql" : "Sqlite";
                         });

}  // namespace
}  // namespace mle::watch
