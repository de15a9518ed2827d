#include "mle/data/record_csv.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ProcessModel Tank() {
  return ProcessModel("tank", "min", {{"steam", ""}, {"inflow", ""}},
                      {{"level", ""}, {"temperature", ""}});
}

absl::StatusOr<Record> Parse(const std::string& text,
                             const RecordCsvOptions& options = {},
                             const ProcessModel& model = Tank()) {
  std::istringstream in(text);
  return ParseRecordCsv(in, "run.csv", model, options);
}

Record ParseOk(const std::string& text, const RecordCsvOptions& options = {}) {
  absl::StatusOr<Record> record = Parse(text, options);
  EXPECT_TRUE(record.ok()) << record.status();
  return record.ok() ? *std::move(record) : Record();
}

std::string Error(const std::string& text) {
  const absl::Status status = Parse(text).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  return std::string(status.message());
}

// The same doubles, or NaN in both.
void ExpectSame(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    if (std::isnan(a.data()[i]) && std::isnan(b.data()[i])) continue;
    ASSERT_EQ(a.data()[i], b.data()[i]) << "at " << i;
  }
}

constexpr char kHeader[] = "time,level,temperature,steam,inflow\n";

TEST(RecordCsvTest, ReadsColumnsInAnyOrderAndPassesOverOthers) {
  const Record record = ParseOk(
      "inflow,tag7,temperature_setpoint,time,level,steam,temperature\n"
      "5,text,70,1.5,1,3,+20\n"
      "6,,71,2.0, 2 ,4,-2.5e1\n");
  EXPECT_EQ(record.start_time, 1.5);
  EXPECT_EQ(record.sample_time, 0.5);
  ExpectSame(record.outputs,
             (Eigen::MatrixXd(2, 2) << 1, 2, 20, -25).finished());
  ExpectSame(record.inputs, (Eigen::MatrixXd(2, 2) << 3, 4, 5, 6).finished());
  ExpectSame(record.set_points,
             (Eigen::MatrixXd(2, 2) << kNaN, kNaN, 70, 71).finished());
}

TEST(RecordCsvTest, WithoutSetPointsThereAreNone) {
  const Record record =
      ParseOk(std::string(kHeader) + "0,1,2,3,4\n1,1,2,3,4\n");
  EXPECT_EQ(record.set_points.size(), 0);
}

TEST(RecordCsvTest, BadSamplesAreNan) {
  const Record record = ParseOk(
      std::string(kHeader) + "0,,NaN,nan,-nan\n1,-9999.0,Bad Input,3, \n",
      {.bad_values = {"-9999", "Bad Input"}});
  EXPECT_EQ(record.outputs.array().isNaN().count(), 4);
  EXPECT_EQ(record.inputs.array().isNaN().count(), 3);
  EXPECT_EQ(record.inputs(0, 1), 3.0);
}

TEST(RecordCsvTest, TakesWhatSpreadsheetsWrite) {
  const Record record = ParseOk(
      "\xEF\xBB\xBF\"time\",level,temperature,steam,inflow\r\n"
      "0,1,2,3,4\r\n\r\n\"1\",1,\"2\",3,4\r\n");
  EXPECT_EQ(record.samples(), 2);
}

TEST(RecordCsvTest, NamesMayHoldCommasQuotesAndLineBreaks) {
  const ProcessModel model("odd", "min", {{"steam, main", ""}},
                           {{"the \"level\"\nof tank 3 ", ""}});
  Record record;
  record.sample_time = 0.1;
  record.outputs = Eigen::RowVector3d(1.0, 2.0, 3.0);
  record.inputs = Eigen::RowVector3d(4.0, kNaN, 6.0);
  record.set_points = Eigen::RowVector3d(0.0, 0.0, 1.0);
  const absl::StatusOr<std::string> text = FormatRecordCsv(record, model);
  ASSERT_TRUE(text.ok()) << text.status();
  const absl::StatusOr<Record> again = Parse(*text, {}, model);
  ASSERT_TRUE(again.ok()) << again.status();
  ExpectSame(again->outputs, record.outputs);
  ExpectSame(again->inputs, record.inputs);
  ExpectSame(again->set_points, record.set_points);
}

TEST(RecordCsvTest, DoublesComeBackAsTheyWere) {
  std::mt19937_64 engine(3);
  Record record;
  record.start_time = 0.0;
  record.sample_time = 1.0 / 3.0;
  record.outputs.resize(2, 500);
  record.inputs.resize(2, 500);
  for (Eigen::MatrixXd* values : {&record.outputs, &record.inputs}) {
    for (double& value : values->reshaped()) {
      // Any bit pattern: all magnitudes, subnormals, both zeros.
      const std::uint64_t bits = engine();
      std::memcpy(&value, &bits, sizeof(value));
      if (!std::isfinite(value)) value = kNaN;
    }
  }
  record.outputs(0, 0) = -0.0;
  record.outputs(0, 1) = std::numeric_limits<double>::denorm_min();
  record.outputs(0, 2) = std::numeric_limits<double>::max();
  const absl::StatusOr<std::string> text = FormatRecordCsv(record, Tank());
  ASSERT_TRUE(text.ok()) << text.status();
  const Record again = ParseOk(*text);
  EXPECT_EQ(again.sample_time, record.sample_time);
  EXPECT_EQ(again.start_time, record.start_time);
  ExpectSame(again.outputs, record.outputs);
  ExpectSame(again.inputs, record.inputs);
  EXPECT_TRUE(std::signbit(again.outputs(0, 0)));
}

TEST(RecordCsvTest, DecimalTimesAreWrittenShortAndComeBackExactly) {
  for (const double start : {0.0, 1234.5, -7.25, 525600.0}) {
    for (const double sample_time : {0.2, 0.1, 0.05, 1.0, 0.003}) {
      Record record;
      record.start_time = start;
      record.sample_time = sample_time;
      record.outputs = Eigen::MatrixXd::Zero(2, 1001);
      record.inputs = Eigen::MatrixXd::Zero(2, 1001);
      const absl::StatusOr<std::string> text = FormatRecordCsv(record, Tank());
      ASSERT_TRUE(text.ok()) << text.status();
      const Record again = ParseOk(*text);
      EXPECT_EQ(again.start_time, start);
      EXPECT_EQ(again.sample_time, sample_time);
      if (start == 0.0 && sample_time == 0.2) {
        EXPECT_THAT(*text, HasSubstr("\n0.6,0,0,0,0\n"));
      }
    }
  }
}

TEST(RecordCsvTest, MalformedFilesAreNamedByLineAndColumn) {
  const std::string header = kHeader;
  const std::string row = "0,1,2,3,4\n";
  EXPECT_THAT(Error(""),
              HasSubstr("run.csv: line 1, column 1: the file is empty"));
  EXPECT_THAT(Error("time,level,steam,inflow\n"),
              HasSubstr("line 1: there is no column 'temperature'"));
  EXPECT_THAT(Error("time,level,level,steam,inflow\n"),
              HasSubstr("line 1, column 3: 'level' stands twice"));
  EXPECT_THAT(
      Error("time,level,temperature,steam,inflow,levle_setpoint\n"),
      HasSubstr("column 6: 'levle_setpoint' is the set point of no output"));
  EXPECT_THAT(Error(header + row + "1,1,2,3\n"),
              HasSubstr("line 3, column 4: the row ends after 4 fields, the "
                        "header has 5"));
  EXPECT_THAT(Error(header + row + "1,1,2,3,4,5\n"),
              HasSubstr("line 3, column 6: the row ends after 6 fields"));
  EXPECT_THAT(Error(header + row + "1,1,2,3 kg,4\n"),
              HasSubstr("line 3, column 4 ('steam'): '3 kg' is not a finite"));
  EXPECT_THAT(Error(header + row + "1,1,2,inf,4\n"), HasSubstr("'inf' is not"));
  EXPECT_THAT(Error(header + row + "1,1,2,1e999,4\n"), HasSubstr("'1e999'"));
  EXPECT_THAT(Error(header + row + "1,1,2,0x10,4\n"), HasSubstr("'0x10'"));
  EXPECT_THAT(
      Error(header + ",1,2,3,4\n"),
      HasSubstr("line 2, column 1 ('time'): '' is not a finite number"));
  EXPECT_THAT(Error(header + row + "1,1,\"2,3,4\n"),
              HasSubstr("line 3, column 3: the quote that opens here"));
  EXPECT_THAT(Error(header + row + "1,1,\"2\"x,3,4\n"),
              HasSubstr("line 3, column 3: text after the closing quote"));
  EXPECT_THAT(Error(header + row + "1,1,2\",3,4\n"),
              HasSubstr("line 3, column 3: a quote inside"));
  EXPECT_THAT(Error(header + row), HasSubstr("ends after 1 samples"));
}

TEST(RecordCsvTest, TimesMustIncreaseInEqualSteps) {
  const std::string rows =
      std::string(kHeader) + "0,1,2,3,4\n0.2,1,2,3,4\n0.4,1,2,3,4\n";
  EXPECT_THAT(Error(rows + "1.0,1,2,3,4\n"),
              HasSubstr("line 5, column 1 ('time'): a step of 0.6 from 0.4 to "
                        "1, but the first step is 0.2"));
  EXPECT_THAT(Error(rows + "0.4,1,2,3,4\n"),
              HasSubstr("0.4 follows 0.4; times must increase"));
}

TEST(RecordCsvTest, TimesMayBeDates) {
  const std::string header = kHeader;
  const Record record = ParseOk(header +
                                "2024-02-28 23:59:48,1,2,3,4\n"
                                "2024-02-29T00:00:00Z,1,2,3,4\n"
                                "2024-02-29T01:00:12.0+01:00,1,2,3,4\n");
  EXPECT_EQ(record.start_time, 0.0);
  EXPECT_EQ(record.sample_time, 0.2);  // of a minute
  EXPECT_THAT(Error(header + "2024-02-28 23:59:48,1,2,3,4\n0.2,1,2,3,4\n"),
              HasSubstr("'0.2' is not a date and time as the first one is"));
  EXPECT_THAT(Error(header + "0.0,1,2,3,4\n2024-02-29T00:00:00Z,1,2,3,4\n"),
              HasSubstr("is not a finite number"));
  EXPECT_THAT(Error(header + "2023-02-29 00:00:00,1,2,3,4\n"),
              HasSubstr("'2023-02-29 00:00:00' is not"));
  const ProcessModel odd("odd", "shift", {{"u", ""}}, {{"y", ""}});
  EXPECT_THAT(std::string(Parse("time,y,u\n2024-02-28 23:59:48,1,2\n", {}, odd)
                              .status()
                              .message()),
              HasSubstr("dates need a time_unit of s, min, h or d"));
}

// Times rounded to three digits by a historian.
TEST(RecordCsvTest, RoundedTimesGiveTheMeanStep) {
  std::string text = kHeader;
  for (int k = 0; k <= 300; ++k) {
    char row[64];
    std::snprintf(row, sizeof(row), "%.3f,1,2,3,4\n", k / 3.0);
    text += row;
  }
  EXPECT_NEAR(ParseOk(text).sample_time, 1.0 / 3.0, 1e-12);
}

TEST(RecordCsvTest, FilesAreWrittenAndRead) {
  const std::string path = ::testing::TempDir() + "/record_csv_test.csv";
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Constant(2, 3, 1.5);
  record.inputs = Eigen::MatrixXd::Constant(2, 3, -0.5);
  ASSERT_TRUE(WriteRecordCsv(path, record, Tank()).ok());
  const absl::StatusOr<Record> again = ReadRecordCsv(path, Tank());
  ASSERT_TRUE(again.ok()) << again.status();
  ExpectSame(again->outputs, record.outputs);
  std::filesystem::remove(path);
  EXPECT_EQ(ReadRecordCsv(path, Tank()).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_FALSE(ReadRecordCsv(::testing::TempDir(), Tank()).ok());
}

TEST(RecordCsvTest, RecordsAndNamesAreCheckedBeforeWriting) {
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Zero(1, 3);
  record.inputs = Eigen::MatrixXd::Zero(2, 3);
  EXPECT_THAT(std::string(FormatRecordCsv(record, Tank()).status().message()),
              HasSubstr("the record has 1 outputs and 2 inputs"));
  const ProcessModel clash("clash", "min", {{"y_setpoint", ""}, {"u", ""}},
                           {{"y", ""}});
  EXPECT_THAT(std::string(FormatRecordCsv(record, clash).status().message()),
              HasSubstr("'y_setpoint'"));
  const ProcessModel time("time", "min", {{"time", ""}, {"u", ""}},
                          {{"y", ""}});
  EXPECT_THAT(std::string(FormatRecordCsv(record, time).status().message()),
              HasSubstr("'time'"));
}

}  // namespace
}  // namespace mle
