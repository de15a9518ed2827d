// Examines the first rows of a file, before any is imported.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/historian_file.h"
#include "mle/data/record_rows.h"
#include "mle/data/sampling.h"

namespace mle {
namespace {

// Whether the empty fields of a wide table are bad samples, or stand for values
// that have not changed, as historians write that report by exception.

// Looks at rows one by one.
class EmptyCells {
 public:
  void Add(const std::vector<double>& values);

  // Half of the fields are empty and hardly a row is; every channel that is
  // there has a sample now and then, at distances that vary. A slower tag among
  // others, with a sample in every tenth row, is no such table.
  bool MeanUnchanged() const;
  // Share of empty fields among the channels that are there.
  double share() const;

 private:
  struct Channel {
    std::int64_t samples = 0;
    std::int64_t last = 0;      // row of the last
    std::int64_t shortest = 0;  // rows from one to the next
    std::int64_t longest = 0;
  };
  std::vector<Channel> channels_;
  std::int64_t rows_ = 0;
  std::int64_t empty_rows_ = 0;
};

constexpr std::int64_t kFewestRows = 20;
constexpr double kMostlyEmpty = 0.5;
constexpr double kFewEmptyRows = 0.01;

void EmptyCells::Add(const std::vector<double>& values) {
  channels_.resize(values.size());
  bool is_empty = true;
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (IsNoSample(values[v])) continue;
    is_empty = false;
    Channel& channel = channels_[v];
    if (channel.samples > 0) {
      const std::int64_t distance = rows_ - channel.last;
      channel.longest = std::max(channel.longest, distance);
      channel.shortest = channel.samples == 1
                             ? distance
                             : std::min(channel.shortest, distance);
    }
    ++channel.samples;
    channel.last = rows_;
  }
  if (is_empty) ++empty_rows_;
  ++rows_;
}

double EmptyCells::share() const {
  std::int64_t samples = 0;
  std::int64_t cells = 0;
  for (const Channel& channel : channels_) {
    if (channel.samples == 0) continue;
    samples += channel.samples;
    cells += rows_;
  }
  return cells == 0
             ? 0.0
             : 1.0 - static_cast<double>(samples) / static_cast<double>(cells);
}

bool EmptyCells::MeanUnchanged() const {
  int sparse = 0;
  int uneven = 0;
  for (const Channel& channel : channels_) {
    if (channel.samples < 3 || 2 * channel.samples > rows_) continue;
    ++sparse;
    if (channel.longest >= 2 * channel.shortest) ++uneven;
  }
  return rows_ >= kFewestRows && share() >= kMostlyEmpty &&
         static_cast<double>(empty_rows_) <=
             kFewEmptyRows * static_cast<double>(rows_) &&
         sparse > 0 && 2 * uneven > sparse;
}

constexpr std::size_t kProbeRows = 4096;

// How many rows the times have, and how far times are apart.
void CountRowsOfTimes(const std::vector<double>& times, HistorianProbe& probe) {
  std::vector<double> apart;
  std::vector<int> counts;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (k > 0 && times[k] == times[k - 1]) {
      ++counts.back();
      ++probe.repeated_rows;
      continue;
    }
    if (k > 0 && times[k] > times[k - 1]) {
      apart.push_back(times[k] - times[k - 1]);
    }
    counts.push_back(1);
  }
  // The first and the last may be cut.
  if (counts.size() < 4 || apart.empty()) return;
  std::sort(counts.begin() + 1, counts.end() - 1);
  probe.rows_of_time = counts[counts.size() / 2];
  probe.time_step = UsualStep(apart);
}

// How far times are apart, where that hardly varies, as of samples that are
// taken by plan; 0 where it does.
double EvenStep(const std::vector<double>& times) {
  constexpr std::size_t kFewest = 4;
  constexpr double kEven = 1.5;
  std::vector<double> apart;
  for (std::size_t k = 1; k < times.size(); ++k) {
    apart.push_back(std::abs(times[k] - times[k - 1]));
  }
  if (apart.size() < kFewest) return 0.0;
  std::sort(apart.begin(), apart.end());
  const double usual = apart[apart.size() / 2];
  return usual <= kEven * apart[apart.size() / 10] ? usual : 0.0;
}

// Whether times go backwards; fewer than one row in ten may go forwards.
bool IsNewestFirst(const std::vector<double>& times) {
  std::size_t earlier = 0;
  std::size_t later = 0;
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] < times[k - 1]) ++earlier;
    if (times[k] > times[k - 1]) ++later;
  }
  return earlier > 10 * later;
}

// Numbers of no declared unit may be Excel's: days such as 45355, apart by what
// is a second or more of a day, but next to nothing in the model's unit.
absl::Status CheckUnit(const RecordClock& clock, const std::string& source,
                       double first, const std::vector<double>& steps) {
  constexpr double kFirstDay = 32874.0;  // 1990
  constexpr double kLastDay = 54789.0;   // 2050
  constexpr double kSecondsPerDay = 86400.0;
  if (!clock.has_assumed_unit() || clock.has_dates() || steps.empty() ||
      first < kFirstDay || first > kLastDay) {
    return absl::OkStatus();
  }
  const double step = UsualStep(steps);
  if (step * clock.seconds_per_unit().value_or(1.0) > 0.5 ||
      step * kSecondsPerDay < 0.9) {
    return absl::OkStatus();
  }
  return OptionError(
      "time_format",
      absl::StrCat(source, ": times such as ", first, ", ", step,
                   " apart, look like the days of Excel; declare time_format = "
                   "excel, or time_format = numbers if they are not"));
}

absl::Status NoRows(const HistorianSource& source,
                    const HistorianOptions& options, const ClockOptions& clock,
                    const RecordRows& rows) {
  if (rows.passed_over() > 0) {
    MLE_ASSIGN_OR_RETURN(const TimeRange range,
                         TimeRange::Create(options.begin, options.end, clock));
    return OptionError(
        "begin,end", absl::StrCat(source.name, ": none of its ",
                                  rows.passed_over(), " rows is ", range.Text(),
                                  "; begin and end leave nothing to read"));
  }
  return InvalidArgument(
      source.name, ": ", CsvLineName(rows.line(), source.is_table),
      ", column 1: there is no row below the header; a record "
      "needs samples");
}

}  // namespace

absl::StatusOr<HistorianProbe> ProbeHistorian(const HistorianSource& source,
                                              const ProcessModel& channels,
                                              const HistorianOptions& options,
                                              const ClockOptions& clock) {
  MLE_ASSIGN_OR_RETURN(
      const std::unique_ptr<HistorianFile> file,
      HistorianFile::Open(source, channels, options, clock, std::nullopt));
  HistorianProbe probe;
  probe.source = source;
  probe.clock = clock;
  for (const RecordColumn& column : file->rows().columns()) {
    probe.has_set_points |= column.kind == RecordColumn::Kind::kSetPoint;
  }
  RecordRow row;
  std::vector<double> times;
  EmptyCells empty;
  std::vector<std::vector<double>> sample_times(1);
  while (times.size() < kProbeRows && file->rows().Next(row)) {
    times.push_back(row.time);
    empty.Add(row.values);
    sample_times.resize(row.values.size());
    for (std::size_t v = 0; v < row.values.size(); ++v) {
      if (!IsNoSample(row.values[v])) sample_times[v].push_back(row.time);
    }
    if (times.size() == 2) file->clock().set_descending(times[1] < times[0]);
  }
  MLE_RETURN_IF_ERROR(file->rows().status());
  if (times.empty()) return NoRows(source, options, clock, file->rows());
  probe.newest_first = IsNewestFirst(times);
  double first = probe.newest_first ? times.back() : times.front();
  if (probe.newest_first) {
    while (file->rows().Next(row)) first = row.time;
    MLE_RETURN_IF_ERROR(file->rows().status());
    std::reverse(times.begin(), times.end());
  }
  for (const std::vector<double>& of_value : sample_times) {
    if (file->is_sparse()) probe.sample_steps.push_back(EvenStep(of_value));
  }
  CountRowsOfTimes(times, probe);
  if (options.spread_repeated_times && probe.rows_of_time > 1) {
    probe.steps.assign(times.size(), probe.time_step / probe.rows_of_time);
    times.clear();
  }
  for (std::size_t k = 1; k < times.size(); ++k) {
    if (times[k] > times[k - 1]) probe.steps.push_back(times[k] - times[k - 1]);
  }
  MLE_RETURN_IF_ERROR(
      CheckUnit(file->clock(), source.name, first, probe.steps));
  probe.time_form = file->clock().form_name();
  probe.notes = file->notes();
  probe.empty_share = empty.share();
  probe.is_unchanged = options.empty_fields == EmptyFields::kUnchanged ||
                       (options.empty_fields == EmptyFields::kRecognise &&
                        (file->is_sparse() || empty.MeanUnchanged()));
  probe.has_dates = file->clock().has_dates();
  if (probe.has_dates) {
    probe.origin = file->clock().origin().value_or(0.0) +
                   first * file->clock().seconds_per_unit().value_or(1.0);
  } else {
    probe.first_time = first;
  }
  return probe;
}

}  // namespace mle
