#include "apps/correct/record_flags.h"

#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "gflags/gflags.h"
#include "mle/base/status.h"

DEFINE_string(time_column, "time", "Name of the column of times.");
DEFINE_string(time_format, "recognise",
              "Form of times: recognise (numbers or ISO 8601), numbers, iso, "
              "day_first (29.02.2024 12:34) or month_first (2/29/2024 12:34 "
              "PM).");
DEFINE_string(
    number_unit, "",
    "Unit of numerical times: ms, s, min, h or d; empty: the model's.");
DEFINE_string(time_zone, "",
              "Zone of dates without a zone, such as Europe/Berlin; empty: "
              "UTC, or a local time without clock changes.");
DEFINE_string(separator, "recognise",
              "Separator of fields: recognise, comma, semicolon or tab.");
DEFINE_string(decimal, "recognise", "Decimal mark: recognise, point or comma.");
DEFINE_int32(lines_above_header, 0, "Lines above the header, ≥ 0.");
DEFINE_int32(rows_below_header, 0,
             "Rows between the header and the samples, such as of units, ≥ 0.");
DEFINE_string(
    tags, "",
    "TAG=CHANNEL,… for columns that are not named as in the model: CHANNEL is "
    "an input, output or <output>_setpoint; TAG=CHANNEL*SCALE+OFFSET converts "
    "units, channel = scale × column + offset.");
DEFINE_bool(ignore_other_columns, false,
            "Unknown columns are ignored; if false, they are errors.");
DEFINE_string(quality_suffixes, "_quality,.quality",
              "The column <column><suffix> holds the quality of <column>.");
DEFINE_string(good_qualities, "good,ok,192",
              "Values of quality columns that mean good.");
DEFINE_string(
    bad_values, "",
    "Values that mark a bad sample, in addition to an empty field, NaN and "
    "words such as Bad and No Data, separated by commas: -9999.");
DEFINE_bool(skip_repeated_times, false,
            "Rows with the time of the row before are ignored; if false, they "
            "are errors.");
DEFINE_bool(skip_backward_times, false,
            "Rows with an earlier time than the row before are ignored; if "
            "false, they are errors.");
DEFINE_double(sample_time, 0.0,
              "Sample time Δt of the resampled records, in the model's time "
              "unit (min); 0: that of the files.");
DEFINE_double(max_gap, -1.0,
              "Longest gap of inputs that is bridged (min), ≥ 0; negative: "
              "five samples.");
DEFINE_bool(
    mark_outliers, true,
    "Samples far from their neighbours are marked as bad; if there are any, or "
    "with --robust, also samples that are outliers under the model.");
DEFINE_bool(
    mark_frozen, true,
    "Stretches in which an output repeats one value are marked as bad.");
DEFINE_double(window_before, 0.0,
              "Length of the record kept before a set-point change (min); 0: "
              "the model's settling time.");
DEFINE_double(window_after, 0.0,
              "Length of the record kept after a set-point change (min); 0: "
              "1.5 times the model's settling time.");
DEFINE_double(min_setpoint_change, 0.0,
              "Largest change of a set point that is ignored, ≥ 0.");
DEFINE_string(change_times, "",
              "Times of set-point changes, for records without set points, "
              "ascending and separated by commas.");

namespace mle::correct {
namespace {

absl::Status Refuse(const std::string& flag, const std::string& value,
                    const std::string& wanted) {
  return absl::InvalidArgumentError(
      absl::StrCat("--", flag, "=", value, ": ", wanted));
}

// The character that a word stands for.
absl::StatusOr<char> Mark(const char* flag, const std::string& word,
                          const std::map<std::string, char>& known) {
  const auto found = known.find(word);
  if (found != known.end()) return found->second;
  std::vector<std::string> words;
  for (const auto& [name, mark] : known) words.push_back(name);
  return Refuse(flag, word,
                absl::StrCat("known are ", absl::StrJoin(words, ", ")));
}

absl::StatusOr<TimeFormat> TimeFormatFromFlags() {
  const std::map<std::string, TimeFormat> formats = {
      {"recognise", TimeFormat::kRecognise},
      {"numbers", TimeFormat::kNumbers},
      {"iso", TimeFormat::kIso},
      {"day_first", TimeFormat::kDayFirst},
      {"month_first", TimeFormat::kMonthFirst}};
  const auto found = formats.find(FLAGS_time_format);
  if (found != formats.end()) return found->second;
  return Refuse("time_format", FLAGS_time_format,
                "known are recognise, numbers, iso, day_first and month_first");
}

// TAG=CHANNEL, with *SCALE and +OFFSET or -OFFSET after it. Channels may have
// these marks in their names: the numbers are sought from the end.
absl::StatusOr<TagMapping> ParseTag(const std::string& text,
                                    const ProcessModel& model) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) {
    return Refuse("tags", text, "it is not of the form TAG=CHANNEL");
  }
  TagMapping mapping;
  mapping.tag = text.substr(0, equals);
  const std::string rest = text.substr(equals + 1);
  const auto known = [&](const std::string& name) {
    for (const OutputChannel& output : model.outputs()) {
      if (name == output.name || name == output.name + "_setpoint") return true;
    }
    for (const InputChannel& input : model.inputs()) {
      if (name == input.name) return true;
    }
    return false;
  };
  if (known(rest)) {
    mapping.channel = rest;
    return mapping;
  }
  const std::size_t star = rest.rfind('*');
  mapping.channel = rest.substr(0, star);
  if (!known(mapping.channel)) {
    return Refuse(
        "tags", text,
        absl::StrCat(
            "'", mapping.channel,
            "' is not an input, output or <output>_setpoint of the model"));
  }
  const std::string numbers = rest.substr(star + 1);
  const std::size_t sign = numbers.find_first_of("+-", 1);
  const bool exponent = sign != std::string::npos &&
                        (numbers[sign - 1] == 'e' || numbers[sign - 1] == 'E');
  const std::size_t split =
      exponent ? numbers.find_first_of("+-", sign + 1) : sign;
  const std::string scale = numbers.substr(0, split);
  const std::string offset =
      split == std::string::npos ? "0" : numbers.substr(split);
  if (!absl::SimpleAtod(scale, &mapping.scale) ||
      !absl::SimpleAtod(offset, &mapping.offset)) {
    return Refuse("tags", text,
                  "after the channel *SCALE+OFFSET is expected, two numbers");
  }
  return mapping;
}

absl::Status ReadColumns(const ProcessModel& model, ColumnOptions& columns) {
  columns.time_column = FLAGS_time_column;
  columns.ignore_other_columns = FLAGS_ignore_other_columns;
  columns.quality_suffixes = ParseList(FLAGS_quality_suffixes);
  for (const std::string& text : ParseList(FLAGS_tags)) {
    MLE_ASSIGN_OR_RETURN(TagMapping mapping, ParseTag(text, model));
    columns.tags.push_back(std::move(mapping));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<double>> ChangeTimes() {
  std::vector<double> times;
  for (const std::string& part : ParseList(FLAGS_change_times)) {
    double time = 0.0;
    if (!absl::SimpleAtod(part, &time) || !std::isfinite(time)) {
      return Refuse("change_times", FLAGS_change_times,
                    absl::StrCat("'", part, "' is not a number"));
    }
    times.push_back(time);
  }
  return times;
}

absl::Status CheckTimes() {
  const std::pair<const char*, double> times[] = {
      {"sample_time", FLAGS_sample_time},
      {"window_before", FLAGS_window_before},
      {"window_after", FLAGS_window_after},
      {"min_setpoint_change", FLAGS_min_setpoint_change}};
  for (const auto& [flag, value] : times) {
    if (!std::isfinite(value) || value < 0.0) {
      return Refuse(flag, absl::StrCat(value),
                    "it must be finite and not negative; 0 is the default");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<HistorianOptions> ImportOptionsFromFlags(
    const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(CheckTimes());
  HistorianOptions import;
  MLE_ASSIGN_OR_RETURN(import.separator, Mark("separator", FLAGS_separator,
                                              {{"recognise", 0},
                                               {"comma", ','},
                                               {"semicolon", ';'},
                                               {"tab", '\t'}}));
  MLE_ASSIGN_OR_RETURN(
      import.decimal, Mark("decimal", FLAGS_decimal,
                           {{"recognise", 0}, {"point", '.'}, {"comma", ','}}));
  import.lines_above_header = FLAGS_lines_above_header;
  import.rows_below_header = FLAGS_rows_below_header;
  MLE_RETURN_IF_ERROR(ReadColumns(model, import.columns));
  import.good_qualities = ParseList(FLAGS_good_qualities);
  import.bad_values = ParseList(FLAGS_bad_values);
  MLE_ASSIGN_OR_RETURN(import.clock.format, TimeFormatFromFlags());
  import.clock.number_unit = FLAGS_number_unit;
  import.clock.time_zone = FLAGS_time_zone;
  import.skip_repeated_times = FLAGS_skip_repeated_times;
  import.skip_backward_times = FLAGS_skip_backward_times;
  import.sample_time = FLAGS_sample_time;
  import.max_gap = FLAGS_max_gap;
  if (const absl::Status status = import.Validate(model); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("flags of the records (see --help): ", status.message()));
  }
  return import;
}

absl::StatusOr<RecordOptions> RecordOptionsFromFlags() {
  MLE_RETURN_IF_ERROR(CheckTimes());
  RecordOptions options;
  options.windows.before = FLAGS_window_before;
  options.windows.after = FLAGS_window_after;
  options.windows.min_change = FLAGS_min_setpoint_change;
  MLE_ASSIGN_OR_RETURN(options.windows.change_times, ChangeTimes());
  if (const absl::Status status = options.windows.Validate(); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("flags of the windows (see --help): ", status.message()));
  }
  options.mark.outliers = FLAGS_mark_outliers;
  options.mark.frozen = FLAGS_mark_frozen;
  return options;
}

}  // namespace mle::correct
