#include "mle/data/tag_file.h"

#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/nearest_names.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

ProcessModel TaggedTank() {
  return ProcessModel("tank", "min", {{"steam", "t/h"}}, {{"level", "%"}});
}

std::vector<TagMapping> ParseTags(const std::string& text) {
  const auto tags = ParseTagFile("tags.csv", text, TaggedTank());
  EXPECT_TRUE(tags.ok()) << tags.status();
  return tags.ok() ? tags->tags : std::vector<TagMapping>();
}

std::string TagError(const std::string& text) {
  const absl::Status status =
      ParseTagFile("tags.csv", text, TaggedTank()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  return std::string(status.message());
}

TEST(TagFileTest, MapsTagsWithTheirUnits) {
  const std::vector<TagMapping> tags = ParseTags(
      "Tag;Channel;Scale;Offset;Unit\nLI1.PV;level;0.01;-5;%\n"
      "FC2.OP;steam;;;t/h\nXI3;;;;\n");
  ASSERT_EQ(tags.size(), 2u);
  EXPECT_EQ(tags[0].tag, "LI1.PV");
  EXPECT_EQ(tags[0].channel, "level");
  EXPECT_EQ(tags[0].scale, 0.01);
  EXPECT_EQ(tags[0].offset, -5.0);
  EXPECT_EQ(tags[1].scale, 1.0);
  EXPECT_EQ(tags[1].offset, 0.0);
  EXPECT_THAT(ParseTags("channel,tag\nsteam,\"A, B\"\n")[0].tag, "A, B");
}

TEST(TagFileTest, DeclaresSampling) {
  const std::vector<TagMapping> tags = ParseTags(
      "tag,channel,period,held,late_by,average,stamp\n"
      "LI1.PV,level,240,yes,15,,\nLI1.SP,level_setpoint,,,,,\n"
      "FC2.OP,steam,,,,5,End\n");
  ASSERT_EQ(tags.size(), 3u);
  EXPECT_EQ(tags[0].sampling,
            (Sampling{.period = 240.0, .held = true, .late_by = 15.0}));
  EXPECT_EQ(tags[1].sampling, std::nullopt);
  EXPECT_EQ(tags[2].sampling,
            (Sampling{.average = 5.0, .stamped_at_end = true}));
  const std::string header = "tag,channel,period,held,late_by,average,stamp\n";
  EXPECT_THAT(TagError(header + "LI1,level,,maybe,,5,\nFC2,steam,5,,,,\n"
                                "LI1.SP,level_setpoint,,,2,,\n"),
              AllOf(HasSubstr("line 2: held is 'maybe'"),
                    HasSubstr("line 2: average, the time that means are over"),
                    HasSubstr("line 3: 'steam' is an input"),
                    HasSubstr("line 4: 'level_setpoint' is a set point")));
}

// A tag without a channel is known not to be needed.
TEST(TagFileTest, ColumnsOfTagsWithoutAChannelAreIgnored) {
  const auto table = ParseTagFile(
      "tags.csv", "tag,channel\nLI1,level\nFC2,steam\nXI3,\n", TaggedTank());
  ASSERT_TRUE(table.ok()) << table.status();
  EXPECT_THAT(table->unused, ElementsAre("XI3"));
  HistorianOptions options;
  options.columns.tags = table->tags;
  options.columns.unused_tags = table->unused;
  const auto read = [&](const std::string& header) {
    return ImportHistorianSources(
        {TextSource("a.csv", header + "\n0,1,2,3\n1,4,5,6\n")}, TaggedTank(),
        options);
  };
  EXPECT_TRUE(read("time,LI1,XI3,FC2").ok());
  EXPECT_THAT(std::string(read("time,LI1,XI4,FC2").status().message()),
              HasSubstr("column 3: 'XI4' is neither"));
}

TEST(TagFileTest, AllFaultsAreListedWithTheirLines) {
  EXPECT_THAT(
      TagError("tag,channel,scale,offset,unit,unit in the file\n"
               "A,levle,1,0,,\n"
               "A,level,x,0,,\n"
               "B,level,0,inf,kg,\n"
               ",steam,1,0,,\n"
               "C,steam,1,0,t/h,kg/h\n"),
      AllOf(HasSubstr("tags.csv: line 2: 'levle' is not an input"),
            HasSubstr("nearest: 'level'"), HasSubstr("line 3: scale is 'x'"),
            HasSubstr("line 3: the tag 'A' stands in line 2"),
            HasSubstr("line 4: offset is 'inf'"),
            HasSubstr("line 4: scale is 0"),
            HasSubstr("line 4: the channel 'level' stands in line 3"),
            HasSubstr("line 4: the unit of 'B' after its conversion is 'kg', "
                      "the model's of 'level' '%'"),
            HasSubstr("line 5: a channel without a tag"),
            HasSubstr("line 6: the channel 'steam' stands in line 5"),
            HasSubstr("line 6: 'C' is in 'kg/h' in the file and wanted in "
                      "'t/h', but scale is 1")));
  EXPECT_THAT(TagError("tag,channel\nA,pressure\n"),
              HasSubstr("the model has 'level', 'level_setpoint', 'steam'"));
  EXPECT_THAT(TagError("tag,scale\nA,1\n"),
              HasSubstr("must name tag and channel"));
  EXPECT_THAT(TagError(""), HasSubstr("the file is empty"));
  EXPECT_FALSE(ReadTagFile("/no/such/tags.csv", TaggedTank()).ok());
}

TEST(NearestNamesTest, CountsWhatMakesOneOfTheOther) {
  EXPECT_EQ(NameDistance("", "abc"), 3);
  EXPECT_EQ(NameDistance("level", "LE vel"), 0);
  EXPECT_EQ(NameDistance("level", "levle"), 1);  // neighbours exchanged
  EXPECT_EQ(NameDistance("level", "lebel"), 1);
  EXPECT_EQ(NameDistance("level", "lvel"), 1);
  EXPECT_EQ(NameDistance("kitten", "sitting"), 3);
  EXPECT_EQ(NameDistance("kitten", "sitting"),
            NameDistance("sitting", "kitten"));
  EXPECT_THAT(NearestNames("TI101", {"FC7.OP", "TI101.PV", "TI102", "XX"}),
              ElementsAre("TI102", "TI101.PV"));
  EXPECT_THAT(NearestNames("pressure", {"level", "steam"}), IsEmpty());
}

class ProposalTest : public ::testing::Test {
 protected:
  std::string Write(const std::string& text) const {
    return folder_.Write("tank.csv", text);
  }
  const ScratchFolder folder_;
};

TEST_F(ProposalTest, NamesTheNearestChannelOfEachColumn) {
  const auto proposals = ProposeTags(
      {FileSource(
          Write("Plant 7\n\nTimestamp,Tank Level.PV,Tank Level.SP,STEAM,XI9,"
                "XI9_quality\n,cm,cm,t/h,,\n2024-03-04 06:00,1,2,3,4,Good\n"))},
      TaggedTank(), HistorianOptions());
  ASSERT_TRUE(proposals.ok()) << proposals.status();
  ASSERT_EQ(proposals->size(), 4u);
  EXPECT_EQ((*proposals)[0].tag, "Tank Level.PV");
  EXPECT_EQ((*proposals)[0].channel, "level");
  EXPECT_EQ((*proposals)[0].found_unit, "cm");
  EXPECT_EQ((*proposals)[1].channel, "level_setpoint");
  EXPECT_EQ((*proposals)[2].channel, "steam");
  EXPECT_EQ((*proposals)[3].channel, "");
  const std::string text = FormatTagFile(*proposals);
  EXPECT_THAT(text, HasSubstr("Tank Level.PV,level,1,0,%,cm\n"));
  EXPECT_THAT(text, HasSubstr("XI9,,,,,\n"));
  // The other unit has to be looked at before the file is taken.
  EXPECT_THAT(
      std::string(ParseTagFile("p.csv", text, TaggedTank()).status().message()),
      AllOf(HasSubstr("line 2"), HasSubstr("'cm'"), Not(HasSubstr("steam"))));
}

TEST_F(ProposalTest, LongTablesHaveTagsToo) {
  const auto proposals = ProposeTags(
      {FileSource(
          Write("tag,time,value\nLEVEL,0,1\nsteam_op,0,2\nLEVEL,1,1\n"))},
      TaggedTank(), HistorianOptions());
  ASSERT_TRUE(proposals.ok()) << proposals.status();
  ASSERT_EQ(proposals->size(), 2u);
  EXPECT_EQ((*proposals)[0].channel, "level");
  EXPECT_EQ((*proposals)[1].channel, "steam");
}

// Names that differ in case and blanks are forgiven, unless two are alike.
TEST(HeaderTest, CaseAndBlanksAreForgivenIfThatIsCertain) {
  const auto import = [](const std::string& header) {
    return ImportHistorianSources(
        {TextSource("a.csv", header + "\n0,1,2,3\n1,4,5,6\n")}, TaggedTank(),
        {});
  };
  const auto good = import("TIME,Level ,Level_SetPoint, S team");
  ASSERT_TRUE(good.ok()) << good.status();
  EXPECT_EQ(good->records[0].set_points(0, 1), 5.0);
  EXPECT_EQ(good->report.channels[0].column, "Level");
  EXPECT_THAT(std::string(import("time,Level,LEVEL,steam").status().message()),
              HasSubstr("there is no column 'level' (nearest: 'Level', "
                        "'LEVEL')"));
}

TEST(HeaderTest, AllFaultsAreListedAtOnce) {
  const std::string message(
      ImportHistorianSources(
          {TextSource("a.csv",
                      "Time_stamp,levle,levle,steam.OP,x_setpoint,foo\n")},
          TaggedTank(), {})
          .status()
          .message());
  EXPECT_THAT(
      message,
      AllOf(HasSubstr("a.csv: line 1, column 3: 'levle' is duplicated"),
            HasSubstr("there is no column 'level' (nearest: 'levle'"),
            HasSubstr("'steam' (nearest: 'steam.OP')"),
            HasSubstr("'time' (nearest: 'Time_stamp')"),
            HasSubstr("and has 'Time_stamp', 'levle'"),
            HasSubstr("column 5: 'x_setpoint' is a set point of an output"),
            HasSubstr("'foo'"), HasSubstr("ignore_other_columns = true")));
}

// The header is told from titles also where none of its names is known.
TEST(HeaderTest, NamesBelowTitlesAreThoseOfTheHeader) {
  EXPECT_THAT(
      std::string(ImportHistorianSources(
                      {TextSource("a.csv",
                                  "Export, unit 7\n\nTimestamp,TI101,FC7\n"
                                  "04-Mar-24 06:00:00,1,2\n")},
                      TaggedTank(), {})
                      .status()
                      .message()),
      AllOf(HasSubstr("a.csv: line 3: there is no column"),
            HasSubstr("and has 'Timestamp', 'TI101', 'FC7'")));
}

TEST(HeaderTest, ATagThatTheFileDoesNotHaveIsNamed) {
  HistorianOptions options;
  options.columns.tags = {{"TIC101.SP", "level_setpoint"}};
  EXPECT_THAT(
      std::string(ImportHistorianSources(
                      {TextSource("a.csv", "time,level,steam,TIC110.SP\n")},
                      TaggedTank(), options)
                      .status()
                      .message()),
      HasSubstr("there is no column 'TIC101.SP' (nearest: 'TIC110.SP')"));
}

// Where the tag is written, not only where it was looked for; the name that is
// near is not another fault.
TEST(HeaderTest, ATagOfAFileIsNamedWithItsLine) {
  const auto table = ParseTagFile(
      "tags.csv", "tag,channel\nLI1.PV,level\nFC20.OP,steam\n", TaggedTank());
  ASSERT_TRUE(table.ok()) << table.status();
  HistorianOptions options;
  options.columns.tags = table->tags;
  const std::string message(
      ImportHistorianSources({TextSource("a.csv", "time,LI1.PV,FC2.OP\n")},
                             TaggedTank(), options)
          .status()
          .message());
  EXPECT_THAT(message, HasSubstr("no column 'FC20.OP' (tags.csv, line 3, for "
                                 "steam; nearest: 'FC2.OP')"));
  EXPECT_THAT(message, Not(HasSubstr("is neither time")));
}

TEST(HeaderTest, WithoutSetPointsItSaysWhatHelps) {
  const auto error = [](const std::string& header) {
    return std::string(
        ImportHistorianSources({TextSource("a.csv", header)}, TaggedTank(), {})
            .status()
            .message());
  };
  EXPECT_THAT(error("time,LI1,LIC1.SP,steam\n"),
              HasSubstr("map those there are (perhaps 'LIC1.SP'), or give "
                        "change_times"));
  EXPECT_THAT(error("time,LI1,steam\n"),
              HasSubstr("map one, or give change_times"));
  EXPECT_THAT(error("time,LI1,level_setpoint,steam\n"),
              Not(HasSubstr("change_times")));
}

// Not by the columns that are missing in it.
TEST(HeaderTest, ATextThatIsNotATableIsAnsweredByItsFirstLine) {
  const auto error = [](const std::string& text) {
    return std::string(
        ImportHistorianSources({TextSource("a.txt", text)}, TaggedTank(), {})
            .status()
            .message());
  };
  for (const char* const text :
       {"\nDear colleague,\nplease find the record\nattached, as agreed.\n",
        "hello\nworld\n", "1\n2\n3\n"}) {
    EXPECT_THAT(error(text), HasSubstr("this is not a table of records"));
  }
  EXPECT_THAT(error("\nDear colleague,\nhello\n"),
              AllOf(HasSubstr("a.txt: line 2: "),
                    HasSubstr("begins with 'Dear colleague,'")));
  EXPECT_THAT(error("{\n  \"name\": 1}\n"), HasSubstr("the file is JSON"));
  for (const char* const text :
       {"a,b\n", "a;b\nkg;m\n0;1\n", "Title\n\na,b,c\n1,2,3\n"}) {
    EXPECT_THAT(error(text), HasSubstr("there is no column")) << text;
  }
  EXPECT_THAT(error("a,b\n0,1\n"), HasSubstr("may not be a table"));
}

// Words are counted, and forgiven on request.
TEST(BadWordsTest, UnknownWordsAreCounted) {
  std::string text = "time,level,steam\n0,1,2\n1,bude,3\n";
  for (int k = 2; k < 40; ++k) {
    absl::StrAppend(&text, k, k % 2 == 0 ? ",Stoerung," : ",Bad,",
                    k % 5 == 0 ? "aus" : "3", "\n");
  }
  const auto import = [&](const HistorianOptions& options) {
    return ImportHistorianSources({TextSource("a.csv", text)}, TaggedTank(),
                                  options);
  };
  EXPECT_THAT(
      std::string(import({}).status().message()),
      AllOf(HasSubstr("a.csv: line 3, column 2 ('level'): 'bude' is not a "
                      "finite number"),
            HasSubstr("27 samples are like this, 'Stoerung' (19), 'aus' (7), "
                      "'bude' (1)"),
            HasSubstr("any_word_is_bad = true")));
  HistorianOptions options;
  options.any_word_is_bad = true;
  const auto all = import(options);
  ASSERT_TRUE(all.ok()) << all.status();
  EXPECT_EQ(all->report.channels[0].bad.declared, 39);
  options.any_word_is_bad = false;
  options.bad_values = {"bude", "Stoerung", "aus"};
  EXPECT_TRUE(import(options).ok());
}

// Of PI, IP.21, Honeywell and DeltaV, in any case.
TEST(BadWordsTest, WordsOfHistoriansAreKnown) {
  std::string text = "time,level,steam\n0,1,2\n";
  int row = 0;
  for (const char* const word :
       {"Pt Created", "I/O Timeout", "Intf Shut", "Arc Off-line", "Set to Bad",
        "Calc Failed", "SCAN OFF", "[-11059] No Good Data For Calculation",
        "BadNoComm", "Bad - Out of Service", "BADPV", "No Status", "????",
        "#REF!", "Comm Fail", "Not Available", "bad, not connected"}) {
    absl::StrAppend(&text, ++row, ",\"", word, "\",2\n");
  }
  absl::StrAppend(&text, ++row, ",1,2\n");
  const auto import =
      ImportHistorianSources({TextSource("a.csv", text)}, TaggedTank(), {});
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_EQ(import->report.channels[0].bad.declared, row - 1);
}

}  // namespace
}  // namespace mle
