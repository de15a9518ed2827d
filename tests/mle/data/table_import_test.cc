#include "mle/data/table_import.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ProcessModel TableTank() {
  ProcessModel model("tank", "min", {{"valve", ""}}, {{"level", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 1.0);
  return model;
}

// Values of a sine and a square wave, with bad samples.
struct Samples {
  std::vector<double> times, level, set_point, valve;

  explicit Samples(int rows) {
    for (int k = 0; k < rows; ++k) {
      times.push_back(k);
      level.push_back(k == 7 ? kNaN : std::sin(0.1 * k));
      set_point.push_back(k < rows / 2 ? 0.0 : 1.0);
      valve.push_back(k == 9 || k == 10 ? kNaN : k / 5 % 2 - 0.25);
    }
  }

  // Refers to these samples.
  Table AsTable() const& {
    return {.name = "table",
            .times = times,
            .columns = {{"level", level.data()},
                        {"level_setpoint", set_point.data()},
                        {"valve", valve.data()}}};
  }

  Table AsTable() && = delete;

  std::string AsText() const {
    std::string text = "time,level,level_setpoint,valve\n";
    for (std::size_t k = 0; k < times.size(); ++k) {
      absl::StrAppendFormat(&text, "%.17g,%.17g,%.17g,%.17g\n", times[k],
                            level[k], set_point[k], valve[k]);
    }
    return text;
  }
};

bool SameBits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.array() == b.array() || (a.array().isNaN() && b.array().isNaN()))
             .all();
}

// A table and the file with the same samples give the same records.
void ExpectSameAsFile(const Samples& samples, const HistorianOptions& options) {
  const auto of_file = ImportHistorianSources(
      {TextSource("file", samples.AsText())}, TableTank(), options);
  const auto of_table = ImportTables({samples.AsTable()}, TableTank(), options);
  ASSERT_TRUE(of_file.ok()) << of_file.status();
  ASSERT_TRUE(of_table.ok()) << of_table.status();
  ASSERT_EQ(of_table->records.size(), of_file->records.size());
  for (std::size_t r = 0; r < of_file->records.size(); ++r) {
    const Record& a = of_table->records[r];
    const Record& b = of_file->records[r];
    EXPECT_EQ(a.start_time, b.start_time);
    EXPECT_EQ(a.sample_time, b.sample_time);
    EXPECT_TRUE(SameBits(a.outputs, b.outputs));
    EXPECT_TRUE(SameBits(a.set_points, b.set_points));
    EXPECT_TRUE(SameBits(a.inputs, b.inputs));
  }
  for (std::size_t c = 0; c < of_file->report.channels.size(); ++c) {
    EXPECT_EQ(of_table->report.channels[c].bridged,
              of_file->report.channels[c].bridged);
    EXPECT_EQ(of_table->report.channels[c].missing,
              of_file->report.channels[c].missing);
  }
}

TEST(TableImport, EvenRowsAreThoseOfAFile) {
  ExpectSameAsFile(Samples(60), {});
}

TEST(TableImport, OtherSampleTimesAreThoseOfAFile) {
  ExpectSameAsFile(Samples(60), {.sample_time = 3.0});
  ExpectSameAsFile(Samples(60), {.sample_time = 0.4});
}

TEST(TableImport, UnevenRowsAreThoseOfAFile) {
  Samples samples(80);
  for (std::size_t k = 40; k < 80; ++k) samples.times[k] += 30.0;
  samples.times[20] += 0.3;
  ExpectSameAsFile(samples, {});
}

TEST(TableImport, ARowWithoutAnyGoodSampleIsAGap) {
  Samples samples(60);
  for (std::size_t k = 20; k < 30; ++k) {
    samples.level[k] = samples.set_point[k] = samples.valve[k] = kNaN;
  }
  ExpectSameAsFile(samples, {});
}

TEST(TableImport, ColumnsAreConvertedAndStrided) {
  const std::vector<double> pairs = {1.0, 0.0, 2.0, 0.0, 3.0, 1.0, 4.0, 1.0};
  const std::vector<double> times = {0.0, 1.0, 2.0, 3.0};
  const Table table = {
      .name = "table",
      .times = times,
      .columns = {{"LI101", pairs.data(), 2}, {"valve", pairs.data() + 1, 2}}};
  HistorianOptions options;
  options.columns.tags = {{"LI101", "level", 2.0, -1.0}};
  const auto import = ImportTables({table}, TableTank(), options);
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_EQ(import->records[0].outputs, Eigen::RowVector4d(1, 3, 5, 7));
  EXPECT_EQ(import->records[0].inputs, Eigen::RowVector4d(0, 0, 1, 1));
}

TEST(TableImport, SaysWhatIsWrongAndWhere) {
  const auto refused = [](const Samples& samples, const std::string& text) {
    const auto import = ImportTables({samples.AsTable()}, TableTank(), {});
    EXPECT_EQ(import.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(import.status().message()), HasSubstr(text));
  };
  Samples samples(20);
  samples.times[4] = 2.5;
  refused(samples, "table: row 5: time 2.5 follows 3");
  samples = Samples(20);
  samples.valve[3] = std::numeric_limits<double>::infinity();
  refused(samples, "table: row 4, column 'valve'");
  samples = Samples(20);
  samples.times[3] = kNaN;
  refused(samples, "a time is missing");
  refused(Samples(1), "at least 2");
  samples = Samples(3);
  Table table = samples.AsTable();
  table.columns[0] = {.name = "level", .holds = "words"};
  EXPECT_THAT(
      std::string(ImportTables({table}, TableTank(), {}).status().message()),
      HasSubstr("column 'level' holds words"));
}

}  // namespace
}  // namespace mle
