#include <cmath>
#include <fstream>
#include <limits>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/data/record_clock.h"
#include "mle/data/record_columns.h"
#include "mle/data/record_csv.h"
#include "mle/data/record_rows.h"

namespace mle {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kStepTolerance = 0.01;

// The columns of a file as they grow, row by row.
struct Columns {
  std::vector<double> times;
  std::vector<std::vector<double>> values;  // 2p + m, as in RecordRow

  int samples() const { return static_cast<int>(times.size()); }
};

// The last step of time is like the first.
absl::Status CheckLastStep(const RecordRows& rows,
                           const std::vector<double>& times) {
  const std::size_t n = times.size();
  if (n < 2) return absl::OkStatus();
  const double first = times[1] - times[0];
  const double last = times[n - 1] - times[n - 2];
  const std::string place = rows.TimePlace();
  if (!(last > 0.0)) {
    return absl::InvalidArgumentError(absl::StrCat(place, ": ", times[n - 1],
                                                   " follows ", times[n - 2],
                                                   "; times must increase"));
  }
  const double rounding =
      4.0 * kEpsilon * std::max(std::abs(times[n - 1]), std::abs(times[0]));
  if (std::abs(last - first) <= kStepTolerance * first + rounding) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      place, ": a step of ", last, " from ", times[n - 2], " to ", times[n - 1],
      ", but the first step is ", first,
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

Record MakeRecord(const Columns& all, const ProcessModel& channels,
                  bool has_set_points) {
  const int samples = all.samples();
  const int p = channels.num_outputs();
  const int m = channels.num_inputs();
  Record record;
  record.start_time = all.times[0];
  record.sample_time = FindSampleTime(all.times);
  const auto fill = [&](int count, int first, Eigen::MatrixXd& rows) {
    rows.resize(count, samples);
    for (int i = 0; i < count; ++i) {
      rows.row(i) = Eigen::Map<const Eigen::RowVectorXd>(
          all.values[first + i].data(), samples);
    }
  };
  fill(p, 0, record.outputs);
  if (has_set_points) fill(p, p, record.set_points);
  fill(m, 2 * p, record.inputs);
  return record;
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
  CsvRows csv(in, name);
  MLE_ASSIGN_OR_RETURN(RecordClock clock,
                       RecordClock::Create(channels.time_unit(), {}));
  RecordRowsOptions row_options;
  row_options.columns.ignore_other_columns = true;
  row_options.columns.quality_suffixes.clear();
  row_options.bad_values = options.bad_values;
  MLE_ASSIGN_OR_RETURN(RecordRows rows,
                       RecordRows::Open(csv, channels, row_options, clock));
  Columns all;
  all.values.resize(rows.num_values());
  RecordRow row;
  while (rows.Next(row)) {
    all.times.push_back(row.time);
    for (int v = 0; v < rows.num_values(); ++v) {
      all.values[v].push_back(row.values[v]);
    }
    MLE_RETURN_IF_ERROR(CheckLastStep(rows, all.times));
  }
  MLE_RETURN_IF_ERROR(rows.status());
  if (all.samples() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat(rows.TimePlace(), ": the record ends after ",
                     all.samples(), " samples; at least 2 are needed"));
  }
  bool has_set_points = false;
  for (const RecordColumn& column : rows.columns()) {
    has_set_points |= column.kind == RecordColumn::Kind::kSetPoint;
  }
  return MakeRecord(all, channels, has_set_points);
}

}  // namespace mle
