// Shapes of tables: long ones, those reported by exception, with titles and
// units, compressed, and files that are no text.

#include <zlib.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "tests/mle/base/scratch_folder.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// One long table by tag, by time, with decimal commas, by other names.
TEST(LongTableTest, IsTurnedIntoAWideOne) {
  for (const std::string text :
       {"tag,time,value\nlevel,0,1.5\nlevel,1,2.5\nlevel,2,3.5\n"
        "steam,0,7\nsteam,1,8\nsteam,2,9\n",
        "time;tag;value\n0;steam;7\n0;level;1,5\n1;steam;8\n1;level;2,5\n"
        "2;steam;9\n2;level;3,5\n",
        "TagName\tTimestamp\tValue\nLevel\t2\t3.5\nSTEAM\t2\t9\n"
        "Level\t1\t2.5\nSTEAM\t1\t8\nLevel\t0\t1.5\nSTEAM\t0\t7\n"}) {
    SCOPED_TRACE(text);
    const HistorianImport import = ImportOk(text);
    ASSERT_EQ(import.records.size(), 1u);
    EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1.5, 2.5, 3.5));
    EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(7, 8, 9));
    ASSERT_EQ(import.report.notes.size(), 1u);
    EXPECT_THAT(import.report.notes[0].text, HasSubstr("long table"));
  }
}

TEST(LongTableTest, QualityUnitsAndOtherTagsAreThoseOfWideTables) {
  HistorianOptions options;
  options.columns.tags = {{"LI1.PV", "level", 0.1, 1.0}, {"FC2.OP", "steam"}};
  const std::string text =
      "tag,time,value,quality\n"
      "LI1.PV,2024-03-04 06:00,10,Good\nLI1.PV,2024-03-04 06:01,20,Bad\n"
      "LI1.PV,2024-03-04 06:02,30,Good\nFC2.OP,2024-03-04 06:00,1,Good\n"
      "FC2.OP,2024-03-04 06:01,1,Good\nFC2.OP,2024-03-04 06:02,I/O Timeout,"
      "Good\nXY3,2024-03-04 06:02,5,Good\n";
  EXPECT_THAT(Error(text, options), HasSubstr("'XY3' is neither time nor"));
  options.columns.ignore_other_columns = true;
  options.max_gap = 0.0;
  const HistorianImport import = ImportOk(text, options);
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(2, IsNan(), 4));
  EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(1, 1, IsNan()));
  EXPECT_EQ(import.report.channels[0].bad.quality, 1);
}

// Nor held: the limit of samples is one of those that are.
TEST(LongTableTest, SamplesOfOtherTagsAreNotCounted) {
  std::string text =
      "tag,time,value\nlevel,0,1\nlevel,1,2\nlevel,2,4\n"
      "steam,0,1\nsteam,1,1\nsteam,2,2\n";
  for (int k = 0; k < 20; ++k) absl::StrAppend(&text, "XY3,", k, ",5\n");
  HistorianOptions options;
  options.max_samples = 3;
  EXPECT_THAT(Error(text, options),
              HasSubstr("'XY3' is neither time nor an input"));
  options.columns.ignore_other_columns = true;
  EXPECT_THAT(RowOf(ImportOk(text, options).records[0].outputs),
              ElementsAre(1, 2, 4));
  EXPECT_THAT(Error(text + "level,3,1\nlevel,4,1\nlevel,5,1\nlevel,6,1\n"
                           "level,7,1\nlevel,8,1\nlevel,9,1\n",
                    options),
              HasSubstr("a long table of more than 12 samples"));
}

TEST(LongTableTest, MistakesAreNamedByTheirLinesInTheFile) {
  EXPECT_THAT(Error("tag,time,value\nlevel,0,1\nlevel,1,2\nsteam,0,3\n"
                    "steam,1,broken\n"),
              HasSubstr("a.csv: line 5, column 3 ('steam'): 'broken' is not"));
  EXPECT_THAT(Error("tag,time,value\nlevel,0,1\nlevel,1,2\nlevel,1,2\n"
                    "steam,0,3\nsteam,1,3\n"),
              AllOf(HasSubstr("a.csv: line 4, column 2: 'level' has a sample "
                              "at this time in line 3 already"),
                    HasSubstr("skip_repeated_times")));
  EXPECT_THAT(Error("tag,time,value\nlevel,0,1\nlevel,later,2\n"),
              HasSubstr("a.csv: line 3, column 2: 'later' is not"));
  EXPECT_THAT(Error("tag,time,value\nlevel,0,1\nlevel\n"),
              HasSubstr("a.csv: line 3, column 1: the row ends after 1"));
  EXPECT_THAT(Error("tag,time,value\nlevel,0,1\nlevel,1,1\n"),
              HasSubstr("a.csv: line 1: there is no column 'steam'"));
  HistorianOptions options;
  options.max_samples = 2;
  std::string many = "tag,time,value\n";
  for (int k = 0; k < 20; ++k) absl::StrAppend(&many, "level,", k, ",1\n");
  EXPECT_THAT(Error(many, options), HasSubstr("more than 8 samples"));
}

// Columns of other names are declared.
TEST(LongTableTest, ColumnsMayBeDeclared) {
  HistorianOptions options;
  options.columns.time_column = "Zeit";
  options.columns.tag_column = "Messstelle";
  options.columns.value_column = "Wert";
  const HistorianImport import = ImportOk(
      "Messstelle;Zeit;Wert\nlevel;0;1\nsteam;0;2\nlevel;1;3\nsteam;1;4\n",
      options);
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 3));
}

// Samples of each tag at times of their own are held until the next.
TEST(LongTableTest, ArchivedSamplesAreHeld) {
  const std::string text =
      "tag,time,value\nlevel,0,1\nlevel,2.5,2\nlevel,9,3\nsteam,0,5\n"
      "steam,4,6\nsteam,10,7\n";
  EXPECT_THAT(Error(text), AllOf(HasSubstr("rows come when something changes"),
                                 HasSubstr("declare the sample time"),
                                 HasSubstr("sample_time = ")));
  HistorianOptions options;
  options.sample_time = 1.0;
  const HistorianImport import = ImportOk(text, options);
  ASSERT_EQ(import.records.size(), 1u);
  EXPECT_THAT(RowOf(import.records[0].outputs),
              ElementsAre(1, 1, 1, 2, 2, 2, 2, 2, 2, 3, 3));
  EXPECT_THAT(RowOf(import.records[0].inputs),
              ElementsAre(5, 5, 5, 5, 6, 6, 6, 6, 6, 6, 7));
  EXPECT_EQ(import.report.num_gaps, 0);
  EXPECT_EQ(import.report.channels[0].bad.total(), 0);
  EXPECT_GT(import.report.channels[0].unchanged, 0);
}

TEST(ExceptionTableTest, IsRecognisedWithANote) {
  std::string table = "time,level,level_setpoint,steam\n";
  std::vector<double> level;
  double last = 0.0;
  for (int k = 0; k < 60; ++k) {
    const bool level_changes = k == 0 || k % 3 == 1 || k % 8 == 5;
    const bool steam_changes = !level_changes || k == 0;
    if (level_changes) last = k;
    level.push_back(last);
    absl::StrAppend(&table, k, ",", level_changes ? absl::StrCat(k) : "", ",",
                    k == 0 ? "1" : "", ",",
                    steam_changes && k % 4 != 3 ? absl::StrCat(2 * k) : "0",
                    "\n");
  }
  // Steam has a value in every row: two of three channels are sparse.
  HistorianOptions options;
  const HistorianImport declared = [&] {
    options.empty_fields = EmptyFields::kUnchanged;
    return ImportOk(table, options);
  }();
  EXPECT_EQ(RowOf(declared.records[0].outputs), level);
  EXPECT_EQ(declared.records[0].set_points(0, 59), 1.0);
  EXPECT_THAT(declared.report.notes, IsEmpty());

  const HistorianImport recognised = ImportOk(table);
  EXPECT_EQ(RowOf(recognised.records[0].outputs), level);
  ASSERT_EQ(recognised.report.notes.size(), 1u);
  EXPECT_THAT(recognised.report.notes[0].text, HasSubstr("taken as unchanged"));
  EXPECT_EQ(recognised.report.notes[0].option, "empty_fields");

  options.empty_fields = EmptyFields::kBad;
  EXPECT_TRUE(std::isnan(ImportOk(table, options).records[0].outputs(0, 2)));
}

// Newest first: what is above in time is below in the file.
TEST(ExceptionTableTest, IsFilledInOrderOfTime) {
  HistorianOptions options;
  options.empty_fields = EmptyFields::kUnchanged;
  const HistorianImport import =
      ImportOk("time,level,steam\n3,,7\n2,5,\n1,,\n0,4,6\n", options);
  EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(4, 4, 5, 5));
  EXPECT_THAT(RowOf(import.records[0].inputs), ElementsAre(6, 6, 6, 7));
}

// A bad sample is bad until the next value, and a long silence a gap.
TEST(ExceptionTableTest, BadSamplesStayBadAndSilenceIsAGap) {
  HistorianOptions options;
  options.empty_fields = EmptyFields::kUnchanged;
  options.max_gap = 0.0;
  const HistorianImport import = ImportOk(
      "time,level,steam\n0,4,6\n1,Bad,6\n2,,6\n3,5,6\n2003,5,6\n2004,6,6\n",
      options);
  ASSERT_EQ(import.records.size(), 2u);
  EXPECT_THAT(RowOf(import.records[0].outputs),
              ElementsAre(4, IsNan(), IsNan(), 5));
  EXPECT_EQ(import.report.num_gaps, 1);
}

// A slow tag among fast ones, lost samples, and rows that are lost whole are
// not tables reported by exception.
TEST(ExceptionTableTest, OtherEmptyFieldsAreBadSamples) {
  std::string slow = "time,level,steam\n";
  std::string lost = "time,level,steam\n";
  std::string rows = "time,level,steam\n";
  for (int k = 0; k < 200; ++k) {
    absl::StrAppend(&slow, k, ",", k % 10 == 0 ? "1" : "", ",",
                    k % 5 == 0 ? "2" : "", "\n");
    absl::StrAppend(&lost, k, ",", k * k % 13 < 5 ? "" : "1", ",2\n");
    absl::StrAppend(&rows, k, k * k % 11 < 8 && k > 0 ? ",,\n" : ",1,2\n");
  }
  for (const std::string& text : {slow, lost, rows}) {
    const HistorianImport import = ImportOk(text);
    for (const ImportNote& note : import.report.notes) {
      EXPECT_NE(note.option, "empty_fields") << note.text;
    }
    EXPECT_GT(import.report.channels[0].bad.empty, 0);
  }
}

TEST(TitlesTest, TitlesAndUnitsAreRecognised) {
  const std::string rows = "0,1,2\n1,3,4\n";
  const std::string header = "time,level,steam\n";
  for (const std::string& text :
       {"Export of unit 7\nfrom 4 March, level 2\n\n" + header + rows,
        header + "min,%,t/h\n" + rows,
        header + ",level of tank,steam flow\n,%,t/h\n" + rows,
        "Titel;\n\"a \"\"b\"\n" + header + "min,%,t/h\n" + rows,
        "sep=,\n\n" + header + rows}) {
    SCOPED_TRACE(text);
    const HistorianImport import = ImportOk(text);
    EXPECT_THAT(RowOf(import.records[0].outputs), ElementsAre(1, 3));
  }
  const HistorianImport import =
      ImportOk("Title\n" + header + "min,%,t/h\n" + rows);
  ASSERT_EQ(import.report.notes.size(), 2u);
  EXPECT_THAT(import.report.notes[0].text, HasSubstr("1 line above"));
  EXPECT_EQ(import.report.notes[0].option, "lines_above_header");
  EXPECT_THAT(import.report.notes[1].text, HasSubstr("1 row below"));
  // A row with a number or a time in it is none of units.
  EXPECT_THAT(Error(header + "min,1,t/h\n" + rows), HasSubstr("line 2"));
  EXPECT_THAT(Error(header + "4. Tag,x,y\n" + rows), HasSubstr("line 2"));
  // Lines are counted from the top of the file.
  EXPECT_THAT(Error("Title\n\n" + header + "min,%,t/h\n0,1,2\n1,x,2\n"),
              HasSubstr("a.csv: line 6, column 2 ('level'): 'x'"));
}

TEST(FileKindTest, FilesThatAreNoTextAreNamed) {
  const auto zip = [](const std::string& name) {
    return std::string("PK\x03\x04\x14\0\0\0", 8) + name;
  };
  for (const auto& [start, message] :
       std::vector<std::pair<std::string, std::string>>{
           {zip("[Content_Types].xml"), "an Excel workbook (xlsx); save its"},
           {zip("records.csv"), "a ZIP archive; unpack it"},
           {"PAR1\x15\x04", "a Parquet file; write it as CSV"},
           {"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", "of the old kind (xls)"},
           {"%PDF-1.7", "a PDF"},
           {"BZh91AY", "bzip2"},
           {"<!DOCTYPE html>", "a page of HTML"}}) {
    EXPECT_THAT(Error(start + std::string(100, 'x')),
                AllOf(HasSubstr("a.csv: line 1, column 1: the file is "),
                      HasSubstr(message)));
  }
}

std::string Gzip(const std::string& text) {
  const ScratchFolder folder;
  const std::string path = folder / "shapes.gz";
  gzFile file = gzopen(path.c_str(), "wb");
  EXPECT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())),
            static_cast<int>(text.size()));
  gzclose(file);
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

absl::StatusOr<HistorianImport> ImportFile(const std::string& content) {
  const ScratchFolder folder;
  return ImportHistorian({folder.Write("shapes.csv.gz", content)}, Tank(),
                         HistorianOptions());
}

TEST(GzipTest, IsUnpackedWhileItIsRead) {
  std::string text = "time,level,steam\n";
  for (int k = 0; k < 100000; ++k) {
    absl::StrAppend(&text, k, ",", k % 97, ",", k % 89, "\n");
  }
  const std::size_t half = text.find('\n', text.size() / 2) + 1;
  // Whole, in two parts that were joined, as gzip allows, and with the zeros
  // that tapes end with.
  for (const std::string& packed :
       {Gzip(text), Gzip(text.substr(0, half)) + Gzip(text.substr(half)),
        Gzip(text) + std::string(100'000, '\0')}) {
    const auto import = ImportFile(packed);
    ASSERT_TRUE(import.ok()) << import.status();
    ASSERT_EQ(import->records[0].samples(), 100000);
    EXPECT_EQ(import->records[0].outputs(0, 99999), 99999 % 97);
  }
  // Cut, and damaged.
  std::string packed = Gzip(text);
  for (const std::string& broken :
       {packed.substr(0, packed.size() / 2), packed.substr(0, 15),
        packed.replace(packed.size() / 2, 8, "damaged!")}) {
    const absl::Status status = ImportFile(broken).status();
    EXPECT_FALSE(status.ok());
    EXPECT_THAT(std::string(status.message()), HasSubstr("shapes.csv.gz"));
  }
}

}  // namespace
}  // namespace mle
