#include "mle/data/record_csv.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <random>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"
#include "mle/data/historian.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ProcessModel CsvTank() {
  return ProcessModel("tank", "min", {{"steam", ""}, {"inflow", ""}},
                      {{"level", ""}, {"temperature", ""}});
}

// A text as FormatRecordCsv() makes it; without sample time: the one it has.
absl::StatusOr<Record> ParseCsv(const std::string& text,
                                double sample_time = 0.0,
                                const ProcessModel& model = CsvTank()) {
  HistorianOptions options;
  options.sample_time = sample_time;
  options.max_gap = 0.0;
  auto import =
      ImportHistorianSources({TextSource("run.csv", text)}, model, options);
  if (!import.ok()) return import.status();
  EXPECT_EQ(import->records.size(), 1u);
  return import->records[0];
}

Record ParseOk(const std::string& text, double sample_time = 0.0) {
  absl::StatusOr<Record> record = ParseCsv(text, sample_time);
  EXPECT_TRUE(record.ok()) << record.status();
  return record.ok() ? *std::move(record) : Record();
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

TEST(RecordCsvTest, SpreadsheetsComputeNoNamesAndTheyAreReadBack) {
  const ProcessModel model("odd", "min",
                           {{"=cmd|' /C calc'!A0", ""}, {"-", ""}},
                           {{"@SUM(A1)", ""}, {"+A1", ""}});
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Random(2, 3);
  record.inputs = Eigen::MatrixXd::Random(2, 3);
  record.set_points = record.outputs;
  const auto text = FormatRecordCsv(record, model);
  ASSERT_TRUE(text.ok()) << text.status();
  EXPECT_EQ(text->substr(0, text->find('\n')),
            "time,'@SUM(A1),'@SUM(A1)_setpoint,'+A1,'+A1_setpoint,"
            "'=cmd|' /C calc'!A0,-");
  const auto read = ParseCsv(*text, 0.0, model);
  ASSERT_TRUE(read.ok()) << read.status();
  ExpectSame(read->outputs, record.outputs);
  ExpectSame(read->inputs, record.inputs);
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
  const absl::StatusOr<Record> again = ParseCsv(*text, 0.1, model);
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
      // Any bit pattern: magnitudes that a record may have, subnormals, zeros.
      const std::uint64_t bits = engine();
      std::memcpy(&value, &bits, sizeof(value));
      if (!std::isfinite(value)) value = kNaN;
      if (std::abs(value) > kLargestSample) value = 1.0 / value;
    }
  }
  record.outputs(0, 0) = -0.0;
  record.outputs(0, 1) = std::numeric_limits<double>::denorm_min();
  record.outputs(0, 2) = kLargestSample;
  const absl::StatusOr<std::string> text = FormatRecordCsv(record, CsvTank());
  ASSERT_TRUE(text.ok()) << text.status();
  const Record again = ParseOk(*text, record.sample_time);
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
      const absl::StatusOr<std::string> text =
          FormatRecordCsv(record, CsvTank());
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

TEST(RecordCsvTest, FilesAreWrittenAndRead) {
  const ScratchFolder folder;
  const std::string path = folder / "tank.csv";
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Constant(2, 3, 1.5);
  record.inputs = Eigen::MatrixXd::Constant(2, 3, -0.5);
  ASSERT_TRUE(WriteRecordCsv(path, record, CsvTank()).ok());
  const auto again = ImportHistorian({path}, CsvTank(), HistorianOptions());
  ASSERT_TRUE(again.ok()) << again.status();
  ExpectSame(again->records.at(0).outputs, record.outputs);
}

TEST(RecordCsvTest, RecordsAndNamesAreCheckedBeforeWriting) {
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Zero(1, 3);
  record.inputs = Eigen::MatrixXd::Zero(2, 3);
  EXPECT_THAT(
      std::string(FormatRecordCsv(record, CsvTank()).status().message()),
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
