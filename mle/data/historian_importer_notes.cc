// The notes of an import on its files, and the faults in them that make it
// fail.

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/data/historian_importer.h"
#include "mle/data/record_columns.h"

namespace mle {
namespace {

using Kind = RecordColumn::Kind;

// Samples this much finer than rows are mostly interpolated.
constexpr double kCoarse = 1.5;

}  // namespace

void HistorianImporter::NoteForm(const HistorianProbe& probe,
                                 FileReport& report) {
  report.time_form = probe.time_form;
  report.newest_first = probe.newest_first;
  std::vector<ImportNote>& notes = import_.report.notes;
  notes.insert(notes.end(), probe.notes.begin(), probe.notes.end());
  if (probe.newest_first) {
    notes.push_back({absl::StrCat(probe.source.name,
                                  ": the newest rows stand first; it was "
                                  "turned round."),
                     ""});
  }
  if (probe.is_unchanged && options_.empty_fields == EmptyFields::kRecognise) {
    notes.push_back(
        {absl::StrCat(probe.source.name, ": ",
                      std::round(100.0 * probe.empty_share),
                      " % of the fields are empty, as of a table reported by "
                      "exception: they are taken as unchanged."),
         "empty_fields"});
  }
}

ChannelReport* HistorianImporter::NoteColumn(const RecordColumn& column) {
  const int value = ValueOf(column, channels_);
  if (value < 0) return nullptr;
  is_there_[value] = true;
  ChannelReport& report = values_[value];
  report.name = column.kind == Kind::kInput
                    ? channels_.inputs()[column.channel].name
                    : channels_.outputs()[column.channel].name;
  if (column.kind == Kind::kSetPoint) report.name = SetPointName(report.name);
  report.column = column.name;
  return &report;
}

void HistorianImporter::NoteChannels(const RecordRows& rows,
                                     bool is_unchanged) {
  for (const RecordColumn& column : rows.columns()) {
    ChannelReport* const report = NoteColumn(column);
    if (report == nullptr) continue;
    const BadSampleCounts& bad = rows.bad()[ValueOf(column, channels_)];
    (is_unchanged ? report->unchanged : report->bad.empty) += bad.empty;
    report->bad.not_a_number += bad.not_a_number;
    report->bad.declared += bad.declared;
    report->bad.quality += bad.quality;
  }
  for (const std::string& quality : rows.bad_qualities()) {
    if (std::find(bad_qualities_.begin(), bad_qualities_.end(), quality) ==
        bad_qualities_.end()) {
      bad_qualities_.push_back(quality);
    }
  }
}

void HistorianImporter::NoteSamples() {
  HistorianReport& report = import_.report;
  import_.records = collector_->TakeRecords();
  for (int v = 0; v < num_values(); ++v) {
    if (!is_there_[v]) continue;
    values_[v].bridged = collector_->bridged()[v];
    values_[v].missing = collector_->missing()[v];
    report.channels.push_back(values_[v]);
  }
  report.records = static_cast<int>(import_.records.size());
  report.samples = collector_->samples() - collector_->short_pieces();
  for (const Record& record : import_.records) {
    report.kept_samples += record.samples();
  }
}

// Every row that is ignored is counted.
void HistorianImporter::NoteIgnoredRows() {
  HistorianReport& report = import_.report;
  const auto note = [&](std::int64_t rows, const char* what,
                        const char* option) {
    if (rows == 0) return;
    report.notes.push_back(
        {absl::StrCat(rows, rows == 1 ? " row " : " rows ", what, "."),
         option});
  };
  note(report.repeated_rows,
       "at a time that was already read: ignored, with the samples in them",
       "skip_repeated_times");
  note(report.backward_rows, "earlier than the row before: ignored",
       "skip_backward_times");
  note(report.empty_rows, "without any good sample: left as gaps", "");
  note(report.outside_rows, "outside of the time range: not read", "begin,end");
  note(report.comment_rows, "of comments or repeated headers: passed over", "");
  note(report.spread_rows,
       "at a time that was already read: spread evenly until the next time",
       "spread_repeated_times");
}

absl::Status HistorianImporter::CheckChannels() {
  for (int v = 0; v < num_values(); ++v) {
    if (!is_there_[v] || good_[v] > 0) continue;
    const ChannelReport& channel = values_[v];
    if (channel.bad.quality == 0) {
      return InvalidArgument(
          probes_[0].source.name, ": column '", ShowCsvText(channel.column),
          "' has no good sample in any row (", channel.bad.empty, " empty, ",
          channel.bad.not_a_number, " NaN, ", channel.bad.declared,
          " bad values); the channel '", channel.name, "' needs samples");
    }
    return OptionError(
        "good_qualities",
        absl::StrCat(
            probes_[0].source.name, ": column '", ShowCsvText(channel.column),
            "' has no good sample, as its quality says; the qualities found "
            "are '",
            absl::StrJoin(bad_qualities_, "', '"),
            "'; declare which of them mean good, such as good_qualities = ",
            bad_qualities_.empty() ? "" : bad_qualities_[0]));
  }
  return absl::OkStatus();
}

void HistorianImporter::Warn() {
  HistorianReport& report = import_.report;
  if (options_.sample_time > 0.0 &&
      report.step > kCoarse * report.sample_time) {
    report.warnings.push_back(absl::StrCat(
        "rows are ", report.step, " apart, more than the sample time ",
        report.sample_time,
        ": most outputs are interpolated, and their noise is not white; choose "
        "a sample time not below the step"));
  }
  if (collector_->short_pieces() > 0) {
    report.warnings.push_back(
        absl::StrCat(collector_->short_pieces(),
                     " single samples between long gaps are "
                     "left out"));
  }
  // What is measured now and then is missing in between.
  std::set<std::string> points;
  for (int i = 0; i < channels_.num_outputs(); ++i) {
    if (IsPoint(i)) points.insert(channels_.outputs()[i].name);
  }
  for (const ChannelReport& channel : report.channels) {
    if (channel.missing > 0 && !points.contains(channel.name)) {
      report.warnings.push_back(absl::StrCat("'", channel.name, "' has ",
                                             channel.missing,
                                             " samples that stay bad"));
    }
  }
}

}  // namespace mle
