#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/iso_time.h"
#include "mle/data/record_columns.h"
#include "mle/data/record_csv.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kStepTolerance = 0.01;

class BadValues {
 public:
  explicit BadValues(const std::vector<std::string>& declared) {
    for (const std::string& text : declared) {
      double number = 0.0;
      if (ReadCsvNumber(text, number)) {
        numbers_.push_back(number);
      } else {
        texts_.push_back(text);
      }
    }
  }

  bool Contains(std::string_view text) const {
    for (const std::string& bad : texts_) {
      if (text == bad) return true;
    }
    return false;
  }
  bool Contains(double number) const {
    for (const double bad : numbers_) {
      if (number == bad) return true;
    }
    return false;
  }

 private:
  std::vector<double> numbers_;
  std::vector<std::string> texts_;
};

bool IsNan(std::string_view text) {
  return text.size() == 3 && (text[0] == 'n' || text[0] == 'N') &&
         (text[1] == 'a' || text[1] == 'A') &&
         (text[2] == 'n' || text[2] == 'N');
}

// A sample; NaN for a bad one. False for text that is neither.
bool ReadSample(std::string_view field, const BadValues& bad, double& sample) {
  const std::string_view text = TrimCsvField(field);
  sample = kNaN;
  if (text.empty() || IsNan(text) || bad.Contains(text)) return true;
  if (!ReadCsvNumber(text, sample) || std::isinf(sample)) return false;
  if (bad.Contains(sample)) sample = kNaN;
  return true;
}

absl::Status NotReadable(const CsvRows& rows, int field,
                         const RecordColumn& column, std::string_view text,
                         const char* wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat(rows.Place(field), " ('", column.name, "'): '",
                   std::string(text), "' is not ", wanted));
}

// The time column: numbers, or ISO 8601 from its first field on.
class TimeReader {
 public:
  explicit TimeReader(const std::string& time_unit)
      : seconds_per_unit_(SecondsPerUnit(time_unit)) {}

  // False for text that is no time of the kind that the first one is.
  bool Read(std::string_view field, double& time) {
    const std::string_view text = TrimCsvField(field);
    const std::optional<double> seconds = ParseIsoTime(text);
    if (is_first_) {
      is_first_ = false;
      are_dates_ = seconds.has_value();
      first_seconds_ = seconds.value_or(0.0);
    }
    if (!are_dates_) return ReadCsvNumber(text, time) && std::isfinite(time);
    if (!seconds || !seconds_per_unit_) return false;
    time = (*seconds - first_seconds_) / *seconds_per_unit_;
    return true;
  }

  // What Read() takes.
  const char* Wanted() const {
    if (!are_dates_) return "a finite number";
    if (seconds_per_unit_) return "a date and time as the first one is";
    return "of use: dates need a time_unit of s, min, h or d in the model";
  }

 private:
  std::optional<double> seconds_per_unit_;
  bool is_first_ = true;
  bool are_dates_ = false;
  double first_seconds_ = 0.0;
};

// The columns of a file as they grow, row by row.
struct Columns {
  std::vector<RecordColumn> columns;
  std::vector<std::vector<double>> values;  // of each column

  int samples() const { return static_cast<int>(values[0].size()); }
};

absl::Status AddRow(const CsvRows& rows, const std::vector<std::string>& fields,
                    const BadValues& bad, TimeReader& times, Columns& all) {
  if (fields.size() != all.columns.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        rows.Place(static_cast<int>(fields.size())), ": the row ends after ",
        fields.size(), " fields, the header has ", all.columns.size()));
  }
  for (std::size_t c = 0; c < fields.size(); ++c) {
    const RecordColumn& column = all.columns[c];
    const int number = static_cast<int>(c) + 1;
    double value = kNaN;
    if (column.kind == Kind::kTime) {
      if (!times.Read(fields[c], value)) {
        return NotReadable(rows, number, column, fields[c], times.Wanted());
      }
    } else if (column.kind != Kind::kOther &&
               !ReadSample(fields[c], bad, value)) {
      return NotReadable(rows, number, column, fields[c],
                         "a finite number, or empty or NaN for a bad sample");
    }
    all.values[c].push_back(value);
  }
  return absl::OkStatus();
}

// The last step of time is like the first.
absl::Status CheckLastStep(const CsvRows& rows, int time_column,
                           const std::vector<double>& times) {
  const std::size_t n = times.size();
  if (n < 2) return absl::OkStatus();
  const double first = times[1] - times[0];
  const double last = times[n - 1] - times[n - 2];
  const std::string place = rows.Place(time_column + 1);
  if (!(last > 0.0)) {
    return absl::InvalidArgumentError(
        absl::StrCat(place, " ('time'): ", times[n - 1], " follows ",
                     times[n - 2], "; times must increase"));
  }
  const double rounding =
      4.0 * kEpsilon * std::max(std::abs(times[n - 1]), std::abs(times[0]));
  if (std::abs(last - first) <= kStepTolerance * first + rounding) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      place, " ('time'): a step of ", last, " from ", times[n - 2], " to ",
      times[n - 1], ", but the first step is ", first,
      "; steps must be equal, with missing samples as empty fields"));
}

// t_k = start + kΔt for all k, but for rounding.
bool Reproduces(const std::vector<double>& times, double sample_time) {
  const double tolerance =
      4.0 * kEpsilon *
      std::max(std::abs(times.front()), std::abs(times.back()));
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double time = times[0] + static_cast<double>(k) * sample_time;
    if (std::abs(time - times[k]) > tolerance) return false;
  }
  return true;
}

double FindSampleTime(const std::vector<double>& times) {
  const double mean =
      (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  for (const double candidate : {RoundCsvTime(mean), times[1] - times[0]}) {
    if (Reproduces(times, candidate)) return candidate;
  }
  return mean;
}

Record MakeRecord(const Columns& all, const ProcessModel& channels) {
  const int samples = all.samples();
  Record record;
  record.outputs.resize(channels.num_outputs(), samples);
  record.inputs.resize(channels.num_inputs(), samples);
  for (std::size_t c = 0; c < all.columns.size(); ++c) {
    const int channel = all.columns[c].channel;
    const Eigen::Map<const Eigen::RowVectorXd> values(all.values[c].data(),
                                                      samples);
    switch (all.columns[c].kind) {
      case Kind::kTime:
        record.start_time = values[0];
        record.sample_time = FindSampleTime(all.values[c]);
        break;
      case Kind::kOutput:
        record.outputs.row(channel) = values;
        break;
      case Kind::kSetPoint:
        if (record.set_points.size() == 0) {
          record.set_points.setConstant(channels.num_outputs(), samples, kNaN);
        }
        record.set_points.row(channel) = values;
        break;
      case Kind::kInput:
        record.inputs.row(channel) = values;
        break;
      case Kind::kOther:
        break;
    }
  }
  return record;
}

absl::Status At(const std::string& place, const absl::Status& status) {
  return absl::Status(status.code(),
                      absl::StrCat(place, ": ", status.message()));
}

}  // namespace

absl::StatusOr<Record> ReadRecordCsv(const std::string& path,
                                     const ProcessModel& channels,
                                     const RecordCsvOptions& options) {
  std::ifstream in(path, std::ios::binary);
  if (!in || in.peek() == std::ifstream::traits_type::eof()) {
    // Why, if it cannot be read.
    MLE_RETURN_IF_ERROR(ReadFile(path).status());
    in.clear();
  }
  return ParseRecordCsv(in, path, channels, options);
}

absl::StatusOr<Record> ParseRecordCsv(std::istream& in, std::string_view source,
                                      const ProcessModel& channels,
                                      const RecordCsvOptions& options) {
  const std::string name(source);
  CsvRows rows(in, name);
  std::vector<std::string> fields;
  if (!rows.Next(fields)) {
    MLE_RETURN_IF_ERROR(rows.status());
    return absl::InvalidArgumentError(absl::StrCat(
        name, ": line 1: the file is empty; a record begins with a header"));
  }
  absl::StatusOr<std::vector<RecordColumn>> columns =
      MatchHeader(fields, channels);
  if (!columns.ok()) {
    return At(absl::StrCat(name, ": line ", rows.line()), columns.status());
  }
  Columns all{*std::move(columns), {}};
  all.values.resize(all.columns.size());
  int time_column = 0;
  while (all.columns[time_column].kind != Kind::kTime) ++time_column;

  const BadValues bad(options.bad_values);
  TimeReader times(channels.time_unit());
  while (rows.Next(fields)) {
    MLE_RETURN_IF_ERROR(AddRow(rows, fields, bad, times, all));
    MLE_RETURN_IF_ERROR(
        CheckLastStep(rows, time_column, all.values[time_column]));
  }
  MLE_RETURN_IF_ERROR(rows.status());
  if (all.samples() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, ": line ", rows.line(), ": the record ends after ",
                     all.samples(), " samples; at least 2 are needed"));
  }
  return MakeRecord(all, channels);
}

}  // namespace mle
