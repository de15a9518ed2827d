// A record of a tank as rows, for tests that read it from a file and from a
// database and must get the same.

#ifndef TESTS_MLE_DATABASE_TANK_ROWS_H_
#define TESTS_MLE_DATABASE_TANK_ROWS_H_

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "mle/database/record_sources.h"
#include "mle/model/process_model.h"

namespace mle {

inline ProcessModel Tank() {
  return ProcessModel("tank", "min", {{"steam", ""}}, {{"level", ""}});
}

struct TankRow {
  absl::Time time;
  std::string level;  // with all digits; empty: a bad sample
  std::string set_point;
  std::string steam;
};

// One a minute, from five hours before clocks are set forward in New York.
inline std::vector<TankRow> TankRows(int digits = 17) {
  constexpr int kCount = 600;
  const absl::Time begin = absl::FromCivil(
      absl::CivilSecond(2024, 3, 10, 2, 0, 0.0), absl::UTCTimeZone());
  std::vector<TankRow> rows;
  for (int k = 0; k < kCount; ++k) {
    const double level = std::sin(0.37 * k) / 3.0 + (k >= 300 ? 1.0 : 0.0);
    rows.push_back({begin + absl::Minutes(k),
                    k % 97 == 50 ? "" : absl::StrFormat("%.*g", digits, level),
                    k >= 300 ? "1" : "0",
                    absl::StrFormat("%.*g", digits, 0.1 * k)});
  }
  return rows;
}

inline std::string TimeText(absl::Time time,
                            const char* form = "%Y-%m-%d %H:%M:%S",
                            absl::TimeZone zone = absl::UTCTimeZone()) {
  return absl::FormatTime(form, time, zone);
}

inline std::string TankCsv(const std::vector<TankRow>& rows) {
  std::string text = "time,level,level_setpoint,steam\n";
  for (const TankRow& row : rows) {
    absl::StrAppend(&text, TimeText(row.time), ",", row.level, ",",
                    row.set_point, ",", row.steam, "\n");
  }
  return text;
}

// "('2024-03-10 02:00:00', 0.5, 0, 1), …" with NULL for bad samples.
inline std::string TankValues(const std::vector<TankRow>& rows,
                              const std::string& zone = "") {
  std::vector<std::string> values;
  for (const TankRow& row : rows) {
    values.push_back(absl::StrCat("('", TimeText(row.time), zone, "', ",
                                  row.level.empty() ? "NULL" : row.level, ", ",
                                  row.set_point, ", ", row.steam, ")"));
  }
  return absl::StrJoin(values, ",\n");
}

inline absl::StatusOr<HistorianImport> ImportFrom(
    const std::string& name, const DatabaseOptions& database,
    const HistorianOptions& options = {}) {
  const auto sources = RecordSources({name}, database, options);
  if (!sources.ok()) return sources.status();
  return ImportHistorianSources(*sources, Tank(), options);
}

inline std::string ErrorFrom(const std::string& name,
                             const DatabaseOptions& database,
                             const HistorianOptions& options = {}) {
  const absl::Status status = ImportFrom(name, database, options).status();
  EXPECT_FALSE(status.ok());
  return std::string(status.message());
}

// Bit by bit.
inline std::vector<std::uint64_t> BitsOf(const Eigen::MatrixXd& matrix) {
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(matrix.size()));
  if (!bits.empty()) {
    std::memcpy(bits.data(), matrix.data(), bits.size() * sizeof(double));
  }
  return bits;
}

inline void ExpectSame(const absl::StatusOr<HistorianImport>& left,
                       const absl::StatusOr<HistorianImport>& right) {
  ASSERT_TRUE(left.ok()) << left.status();
  ASSERT_TRUE(right.ok()) << right.status();
  EXPECT_EQ(left->report.rows, right->report.rows);
  EXPECT_EQ(left->report.time_origin, right->report.time_origin);
  ASSERT_EQ(left->records.size(), right->records.size());
  for (std::size_t r = 0; r < left->records.size(); ++r) {
    const Record& a = left->records[r];
    const Record& b = right->records[r];
    EXPECT_EQ(a.start_time, b.start_time);
    EXPECT_EQ(a.sample_time, b.sample_time);
    EXPECT_EQ(BitsOf(a.outputs), BitsOf(b.outputs));
    EXPECT_EQ(BitsOf(a.inputs), BitsOf(b.inputs));
    EXPECT_EQ(BitsOf(a.set_points), BitsOf(b.set_points));
  }
}

// The import of the same rows as a file.
inline absl::StatusOr<HistorianImport> ImportCsv(
    const std::string& text, const HistorianOptions& options = {}) {
  return ImportHistorianSources({TextSource("a.csv", text)}, Tank(), options);
}

// The rows that a source of a database has, the header first.
inline std::vector<std::vector<std::string>> AllRows(
    const HistorianSource& source) {
  const auto rows = source.open_rows();
  EXPECT_TRUE(rows.ok()) << rows.status();
  std::vector<std::vector<std::string>> all;
  std::vector<std::string_view> fields;
  while (rows.ok() && (*rows)->Next(fields)) {
    all.emplace_back(fields.begin(), fields.end());
  }
  return all;
}

}  // namespace mle

#endif  // TESTS_MLE_DATABASE_TANK_ROWS_H_
