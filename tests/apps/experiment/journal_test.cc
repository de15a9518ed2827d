#include <fstream>
#include <memory>
#include <string>

#include "apps/experiment/campaign_json.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/run_folder.h"
#include "apps/experiment/study.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"
#include "tests/apps/experiment/small_campaign.h"

namespace mle::experiment {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class JournalTest : public ::testing::Test {
 protected:
  std::string LineOf(std::int64_t run) const {
    Row row;
    row.run = run;
    row[Metric::kE] = 0.1 * static_cast<double>(run);
    row.seconds = 0.5;
    return RowText(campaign_, grid_, row);
  }

  absl::StatusOr<std::unique_ptr<Journal>> Open(const JournalHead& head,
                                                bool resume) const {
    return Journal::Open(path_, head, resume);
  }

  // A journal with runs 4 and 1 done.
  void WriteTwo() const {
    const auto journal = Open(head_, false);
    ASSERT_TRUE(journal.ok()) << journal.status();
    ASSERT_TRUE((*journal)->Append(4, LineOf(4)).ok());
    ASSERT_TRUE((*journal)->Append(1, LineOf(1)).ok());
  }

  void Spoil(const std::string& content) const {
    scratch_.Write("journal.csv", content);
  }

  const ScratchFolder scratch_;
  const std::string path_ = scratch_ / "journal.csv";
  const Study study_ = *ReadStudy(SmallCampaign(3).dump(), "c.json", "");
  const Campaign& campaign_ = study_.campaign;
  const Grid grid_{campaign_};
  const JournalHead head_ = WorkOf(study_).head;
};

TEST_F(JournalTest, KeepsWhatWasDone) {
  WriteTwo();
  const auto journal = Open(head_, true);
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_EQ((*journal)->num_done(), 2);
  EXPECT_EQ((*journal)->dropped_bytes(), 0);
  EXPECT_TRUE((*journal)->IsDone(1));
  EXPECT_FALSE((*journal)->IsDone(0));
  EXPECT_EQ(*(*journal)->Line(4), LineOf(4));
  EXPECT_EQ(*(*journal)->Line(1), LineOf(1));
}

// Wherever the file breaks off, what is whole stays, and nothing else. (Not at
// every byte: each look flushes files to the disk.)
TEST_F(JournalTest, DropsALineThatBrokeOff) {
  WriteTwo();
  const std::string whole = Content(path_);
  const std::size_t second = whole.rfind("\n1,") + 1;
  for (std::size_t size = 0; size < whole.size(); size += 23) {
    Spoil(whole.substr(0, size));
    auto journal = Open(head_, true);
    ASSERT_TRUE(journal.ok()) << size << ": " << journal.status();
    const int left = size >= second ? 1 : 0;
    EXPECT_EQ((*journal)->num_done(), left) << size;
    ASSERT_TRUE((*journal)->Append(1, LineOf(1)).ok());
    if (left == 0) {
      ASSERT_TRUE((*journal)->Append(4, LineOf(4)).ok());
    }
    journal = absl::CancelledError("closed");
    const auto again = Open(head_, true);
    ASSERT_TRUE(again.ok()) << size << ": " << again.status();
    EXPECT_EQ((*again)->num_done(), 2) << size;
  }
}

TEST_F(JournalTest, LeavesOutRubbish) {
  WriteTwo();
  Spoil(Content(path_) + std::string(100, '\0') + "\n");
  const auto journal = Open(head_, true);
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_EQ((*journal)->num_done(), 2);
  EXPECT_THAT((*journal)->damaged_lines(), ElementsAre(5));
}

// Whichever byte of a line changes, its run is not done, the other is, and
// what is done again is found when the journal is opened next.
TEST_F(JournalTest, ALineWithAChangedByteIsDoneAgain) {
  WriteTwo();
  const std::string whole = Content(path_);
  const std::size_t begin = whole.find("\n4,") + 1;
  const std::size_t end = whole.find('\n', begin);
  for (std::size_t at = begin; at < end; at += 7) {
    std::string changed = whole;
    changed[at] = changed[at] == '7' ? '8' : '7';
    Spoil(changed);
    auto journal = Open(head_, true);
    ASSERT_TRUE(journal.ok()) << at << ": " << journal.status();
    EXPECT_FALSE((*journal)->IsDone(4)) << at;
    EXPECT_TRUE((*journal)->IsDone(1)) << at;
    EXPECT_THAT((*journal)->damaged_lines(), ElementsAre(3));
    ASSERT_TRUE((*journal)->Append(4, LineOf(4)).ok());
    journal = absl::CancelledError("closed");
    const auto again = Open(head_, true);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ((*again)->num_done(), 2);
    EXPECT_EQ(*(*again)->Line(4), LineOf(4));
  }
}

// A line with a right checksum under the number of another run.
TEST_F(JournalTest, CoordinatesAreThoseOfTheRun) {
  {
    const auto journal = Open(head_, false);
    ASSERT_TRUE(journal.ok()) << journal.status();
    std::string other = LineOf(4);
    other[0] = '3';
    ASSERT_TRUE((*journal)->Append(3, other).ok());
    ASSERT_TRUE((*journal)->Append(1, LineOf(1)).ok());
  }
  const auto journal = Open(head_, true);
  ASSERT_TRUE(journal.ok()) << journal.status();
  EXPECT_THAT((*journal)->damaged_lines(), ElementsAre(3));
  EXPECT_FALSE((*journal)->IsDone(3));
  EXPECT_FALSE((*journal)->IsDone(4));
  EXPECT_TRUE((*journal)->IsDone(1));
}

TEST_F(JournalTest, ALineThatChangesWhileTheJournalIsOpenIsNotUsed) {
  WriteTwo();
  const auto journal = Open(head_, true);
  ASSERT_TRUE(journal.ok()) << journal.status();
  std::string changed = Content(path_);
  changed[changed.find(",ok,") + 4] = '9';
  // In place: the file that is open.
  std::ofstream(path_, std::ios::binary | std::ios::in) << changed;
  const auto line = (*journal)->Line(4);
  ASSERT_FALSE(line.ok());
  EXPECT_THAT(std::string(line.status().message()),
              HasSubstr("the line of run 4 has changed"));
}

TEST_F(JournalTest, RefusesARunThatStandsTwice) {
  WriteTwo();
  const std::string whole = Content(path_);
  const std::size_t begin = whole.find("\n4,") + 1;
  Spoil(whole + whole.substr(begin, whole.find("\n1,") + 1 - begin));
  const auto journal = Open(head_, true);
  ASSERT_FALSE(journal.ok());
  EXPECT_THAT(std::string(journal.status().message()),
              HasSubstr("run 4 is duplicated"));
}

TEST_F(JournalTest, RefusesAnotherCampaignOrVersion) {
  WriteTwo();
  for (const bool columns : {false, true}) {
    JournalHead other = head_;
    (columns ? other.columns : other.first_line) += "2";
    const auto journal = Open(other, true);
    ASSERT_FALSE(journal.ok());
    EXPECT_THAT(std::string(journal.status().message()),
                HasSubstr("another campaign"));
  }
  const auto journal = Open(head_, false);
  ASSERT_FALSE(journal.ok());
  EXPECT_THAT(std::string(journal.status().message()), HasSubstr("--resume"));
}

TEST(RowTest, ReadsWhatItWrites) {
  const Campaign campaign = *ParseCampaign(SmallCampaign(3).dump(), "c.json");
  const Grid grid(campaign);
  Row row;
  row.run = 5;
  row[Metric::kE] = 1.0 / 3.0;
  row[Metric::kRatio] = std::numeric_limits<double>::infinity();
  row[Metric::kLambdaMin] = 5e-324;
  row.status = "failed: a \"quote\", a comma\nand a line";
  row.seconds = 0.25;
  const std::string text = RowText(campaign, grid, row);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const absl::StatusOr<Row> read = ParseRow(text);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->run, 5);
  EXPECT_EQ((*read)[Metric::kE], 1.0 / 3.0);
  EXPECT_EQ((*read)[Metric::kRatio], row[Metric::kRatio]);
  EXPECT_EQ((*read)[Metric::kLambdaMin], 5e-324);
  EXPECT_TRUE(std::isnan((*read)[Metric::kPValue]));
  EXPECT_EQ(read->status, "failed: a \"quote\", a comma and a line");
  EXPECT_EQ(read->seconds, 0.25);
  EXPECT_FALSE(ParseRow(text.substr(0, text.rfind(','))).ok());
}

}  // namespace
}  // namespace mle::experiment
