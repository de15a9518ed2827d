#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/historian.h"
#include "mle/data/time_range.h"

namespace mle {
namespace {

absl::Status FieldFault(const char* field, const std::string& value,
                        const char* constraint) {
  return InvalidArgument("historian: ", field, " is ", value, ", must be ",
                         constraint);
}

const char* MarkName(char mark) {
  return mark == ','    ? "comma"
         : mark == ';'  ? "semicolon"
         : mark == '.'  ? "point"
         : mark == '\t' ? "tab"
                        : "another mark";
}

void AppendBad(const ChannelReport& channel, std::string& text) {
  const BadSampleCounts& bad = channel.bad;
  absl::StrAppend(&text, "  ", channel.name);
  if (channel.column != channel.name) {
    absl::StrAppend(&text, " (column '", channel.column, "')");
  }
  absl::StrAppend(&text, ": ", bad.total(), " bad in the files");
  const auto part = [&](std::int64_t count, const char* what) {
    if (count > 0) absl::StrAppend(&text, ", ", count, " ", what);
  };
  part(bad.empty, "empty");
  part(bad.not_a_number, "NaN");
  part(bad.declared, "bad values");
  part(bad.quality, "of bad quality");
  if (channel.unchanged > 0) {
    absl::StrAppend(&text, "; ", channel.unchanged, " unchanged");
  }
  absl::StrAppend(&text, "; ", channel.bridged, " samples bridged, ",
                  channel.missing, " stay bad\n");
}

}  // namespace

absl::Status HistorianOptions::Validate(const ProcessModel& channels) const {
  if (separator != 0 && separator != ',' && separator != ';' &&
      separator != '\t') {
    return FieldFault("separator",
                      absl::StrCat("'", std::string(1, separator), "'"),
                      "a comma, a semicolon or a tab");
  }
  if (decimal != 0 && decimal != '.' && decimal != ',') {
    return FieldFault("decimal",
                      absl::StrCat("'", std::string(1, decimal), "'"),
                      "a point or a comma");
  }
  if (lines_above_header < 0) {
    return FieldFault("lines_above_header", absl::StrCat(lines_above_header),
                      "not negative");
  }
  if (rows_below_header < 0) {
    return FieldFault("rows_below_header", absl::StrCat(rows_below_header),
                      "not negative");
  }
  if (!(sample_time >= 0.0) || !std::isfinite(sample_time)) {
    return FieldFault("sample_time", absl::StrCat(sample_time),
                      "positive, or 0 for the files' step");
  }
  if (!std::isfinite(max_gap)) {
    return FieldFault("max_gap", absl::StrCat(max_gap), "finite");
  }
  if (max_samples < 2) {
    return FieldFault("max_samples", absl::StrCat(max_samples), "at least 2");
  }
  if (limits.max_columns < 1 || limits.max_row_bytes < 16) {
    return FieldFault("limits",
                      absl::StrCat(limits.max_columns, " columns, ",
                                   limits.max_row_bytes, " bytes"),
                      "at least 1 column and 16 bytes");
  }
  MLE_RETURN_IF_ERROR(TimeRange::Create(begin, end, clock).status());
  return columns.Validate(channels);
}

std::string HistorianReport::BriefReport() const {
  std::int64_t bad = 0;
  std::int64_t bridged = 0;
  for (const ChannelReport& channel : channels) {
    bad += channel.bad.total();
    bridged += channel.bridged;
  }
  return absl::StrCat(
      rows, " rows of ", files.size(), " files: ", records, " records, ",
      samples, " samples every ", sample_time,
      kept_samples < samples ? absl::StrCat(" (", kept_samples, " kept)") : "",
      ", ", bad, " values bad, ", bridged, " bridged, ", num_gaps, " gaps");
}

std::string HistorianReport::FullReport(const std::string& time_unit) const {
  std::string text = BriefReport() + "\n";
  const TimeNames times = Times(time_unit);
  for (const FileReport& file : files) {
    absl::StrAppend(&text, file.name, ": ", file.rows, " rows, ",
                    times.Span(file.first_time, file.last_time), ", times as ",
                    file.time_form, ", separated by ", MarkName(file.separator),
                    ", decimal ", MarkName(file.decimal), "\n");
    if (file.num_ignored_columns > 0) {
      absl::StrAppend(
          &text, "  ", file.num_ignored_columns,
          " columns ignored: ", absl::StrJoin(file.ignored_columns, ", "),
          file.num_ignored_columns >
                  static_cast<int>(file.ignored_columns.size())
              ? ", …\n"
              : "\n");
    }
  }
  if (time_origin) {
    absl::StrAppend(&text, "time 0 is ", FormatIsoTime(*time_origin), "\n");
  }
  absl::StrAppend(&text, "rows are usually ", step, " ", time_unit,
                  " apart; outputs are ",
                  averaged ? "means over each sample time"
                           : "taken or interpolated at each sample",
                  "\n");
  text += "channels:\n";
  for (const ChannelReport& channel : channels) AppendBad(channel, text);
  for (const GapReport& gap : gaps) {
    absl::StrAppend(&text, "gap: ", times.Span(gap.from, gap.to),
                    gap.splits ? ", a new record after it\n" : "\n");
  }
  if (num_gaps > static_cast<std::int64_t>(gaps.size())) {
    absl::StrAppend(&text, "and ", num_gaps - gaps.size(), " more gaps\n");
  }
  for (const ImportNote& note : notes) absl::StrAppend(&text, note.text, "\n");
  for (const std::string& warning : warnings) {
    absl::StrAppend(&text, "warning: ", warning, "\n");
  }
  return text;
}

}  // namespace mle
