#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/common/option_values.h"
#include "apps/correct/request.h"
#include "mle/base/status.h"
#include "mle/data/tag_file.h"
#include "mle/data/time_format.h"

namespace mle::correct {
namespace {

// A value for all files, or one for each of them.
TextValue ForEachFile(
    std::vector<ClockOptions>* clocks, std::string text,
    const std::function<absl::Status(const std::string&, ClockOptions&)>& set) {
  return {.text = std::move(text),
          .read = [=](const std::string& given, const NumberRange&) {
            std::vector<std::string> values = ParseList(given);
            if (values.empty()) values.emplace_back();
            if (clocks->empty()) clocks->resize(1);
            if (clocks->size() == 1)
              clocks->resize(values.size(), clocks->front());
            if (values.size() > 1 && values.size() != clocks->size()) {
              return InvalidArgument(
                  "there are ", values.size(), " values, where another ",
                  "option has one for each of ", clocks->size(), " files");
            }
            for (std::size_t f = 0; f < clocks->size(); ++f) {
              MLE_RETURN_IF_ERROR(
                  set(values[std::min(f, values.size() - 1)], (*clocks)[f]));
            }
            return absl::OkStatus();
          }};
}

TextValue ForEachFile(std::vector<ClockOptions>* clocks,
                      std::string ClockOptions::*field) {
  return ForEachFile(clocks, "",
                     [field](const std::string& text, ClockOptions& clock) {
                       clock.*field = text;
                       return absl::OkStatus();
                     });
}

// The name of a form, or a pattern.
absl::Status SetTimeFormat(const std::string& text, ClockOptions& clock) {
  std::vector<std::string> names;
  for (const TimeForm& form : TimeForms()) {
    names.push_back(form.name);
    if (form.name != text) continue;
    clock.format = form.format;
    return absl::OkStatus();
  }
  if (text.find('%') == std::string::npos) {
    return InvalidArgument("choose from ", absl::StrJoin(names, ", "),
                           ", and a form such as '%d.%m.%Y %H:%M'");
  }
  MLE_RETURN_IF_ERROR(TimePattern::Create(text).status());
  clock.format = TimeFormat::kPattern;
  clock.pattern = text;
  return absl::OkStatus();
}

TextValue TimeFormatOf(std::vector<ClockOptions>* clocks) {
  TextValue value = ForEachFile(clocks, "recognise", SetTimeFormat);
  std::vector<std::string> known;
  for (const TimeForm& form : TimeForms()) {
    known.push_back(absl::StrCat(form.name, " (", form.example, ")"));
  }
  value.known = absl::StrJoin(known, ", ");
  return value;
}

// Numbers, and other texts that have a digit and a colon, as dates have.
TextValue TimesOrDates(std::vector<double>* times,
                       std::vector<std::string>* dates) {
  return {.read = [=](const std::string& given, const NumberRange&) {
    times->clear();
    dates->clear();
    for (const std::string& part : ParseList(given)) {
      double number = 0.0;
      if (absl::SimpleAtod(part, &number) && std::isfinite(number)) {
        times->push_back(number);
      } else if (part.find(':') != std::string::npos) {
        dates->push_back(part);
      } else {
        return InvalidArgument(
            "'", part,
            "' is not a number, nor a date such as 2024-02-29 12:34");
      }
    }
    return absl::OkStatus();
  }};
}

// TAG or TAG=CHANNEL, separated by commas.
TextValue ModeTags(std::vector<ModeTag>* modes) {
  return {.read = [modes](const std::string& given, const NumberRange&) {
    modes->clear();
    for (const std::string& part : ParseList(given)) {
      const std::size_t equals = part.rfind('=');
      ModeTag& mode = modes->emplace_back();
      mode.tag = part.substr(0, equals);
      if (equals != std::string::npos) mode.channel = part.substr(equals + 1);
      if (mode.tag.empty()) {
        return InvalidArgument("'", part, "' is neither TAG nor TAG=CHANNEL");
      }
    }
    return absl::OkStatus();
  }};
}

bool IsColumnOf(const ProcessModel& model, const std::string& name) {
  const std::vector<std::string> names = ChannelNames(model);
  return std::count(names.begin(), names.end(), name) > 0;
}

// "SCALE", "SCALE+OFFSET" or "SCALE-OFFSET".
bool ParseScale(const std::string& text, TagMapping& mapping) {
  const std::size_t sign = text.find_first_of("+-", 1);
  const bool exponent = sign != std::string::npos &&
                        (text[sign - 1] == 'e' || text[sign - 1] == 'E');
  const std::size_t split =
      exponent ? text.find_first_of("+-", sign + 1) : sign;
  const std::string offset =
      split == std::string::npos ? "0" : text.substr(split);
  return absl::SimpleAtod(text.substr(0, split), &mapping.scale) &&
         absl::SimpleAtod(offset, &mapping.offset);
}

// TAG=CHANNEL, with *SCALE and +OFFSET or -OFFSET after it. Channels may have
// these marks in their names: the numbers are sought from the end.
absl::StatusOr<TagMapping> ParseTag(const std::string& text,
                                    const ProcessModel& model) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) {
    return RefuseOption("tags", text, "it is not of the form TAG=CHANNEL");
  }
  TagMapping mapping;
  mapping.tag = text.substr(0, equals);
  mapping.channel = text.substr(equals + 1);
  if (IsColumnOf(model, mapping.channel)) return mapping;
  const std::size_t star = mapping.channel.rfind('*');
  const std::string scale = mapping.channel.substr(star + 1);
  mapping.channel.resize(std::min(star, mapping.channel.size()));
  if (!IsColumnOf(model, mapping.channel)) {
    return RefuseOption(
        "tags", text,
        absl::StrCat(DidYouMean(mapping.channel, ChannelNames(model)), "'",
                     mapping.channel,
                     "' is not an input, output or <output>_setpoint of the "
                     "model"));
  }
  if (!ParseScale(scale, mapping)) {
    return RefuseOption(
        "tags", text,
        "after the channel *SCALE+OFFSET is expected, two numbers");
  }
  return mapping;
}

}  // namespace

std::vector<Option> OptionsOf(DatabaseOptions& database) {
  return {
      {"query", &database.query,
       "SQL whose rows are the records, in order of time, of the database in "
       "--data."},
      {"table", &database.table,
       "Table or view of that database, in place of --query; with its schema "
       "where one is needed, such as plant.trend."},
      {"columns", Words(&database.columns),
       "Columns of the table that are read, besides the time, separated by "
       "commas; empty: all."},
  };
}

std::vector<Option> OptionsOf(HistorianOptions& import,
                              std::vector<std::string>& tags,
                              std::string* tag_file) {
  ColumnOptions& columns = import.columns;
  return {
      {"time_column", &columns.time_column,
       "Name of the column of times; two columns, of dates and times of the "
       "day, or of times and their milliseconds, with a plus: date+time."},
      {"time_format", TimeFormatOf(&import.clocks),
       "Form of times: a name, or a form such as '%d.%m.%Y %H:%M[:%S]' (fields "
       "%Y %y %m %b %d %H %I %M %S %p %z, what may be missing in brackets). As "
       "the next two, one value, or one for each file, separated by commas."},
      {"number_unit", ForEachFile(&import.clocks, &ClockOptions::number_unit),
       "Unit of numerical times: ms, s, min, h or d; empty: the model's."},
      {"time_zone", ForEachFile(&import.clocks, &ClockOptions::time_zone),
       "Zone of dates without a zone, such as Europe/Berlin; empty: UTC, or a "
       "local time without clock changes."},
      {"begin", &import.begin,
       "Records before this time are not read: a date such as 2024-02-29 12:34 "
       "or 2024-02-29, or a number where times are numbers; empty: no limit."},
      {"end", &import.end,
       "Records after this time are not read; a day alone is its midnight."},
      {"separate_files", &import.separate_files,
       "Files whose times are numbers are taken one after another, in the "
       "order given, whatever their times: each may begin at 0."},
      {"separator",
       OneOf<char>(&import.separator, {{"recognise", '\0', ""},
                                       {"comma", ',', ""},
                                       {"semicolon", ';', ""},
                                       {"tab", '\t', ""}}),
       "Separator of fields."},
      {"decimal",
       OneOf<char>(
           &import.decimal,
           {{"recognise", '\0', ""}, {"point", '.', ""}, {"comma", ',', ""}}),
       "Decimal mark."},
      {"lines_above_header", &import.lines_above_header,
       "Lines above the header; 0: recognised.", "", kNotNegative},
      {"rows_below_header", &import.rows_below_header,
       "Rows between the header and the samples, such as of units; 0: "
       "recognised.",
       "", kNotNegative},
      {"header", Words(&import.header),
       "Names of the columns, separated by commas, of files that have no "
       "header."},
      {"tag_column", &columns.tag_column,
       "Name of the column of tags in a long table, which has a row for each "
       "sample; empty: recognised by usual names such as tag and TagName."},
      {"value_column", &columns.value_column,
       "Name of its column of values; empty: as above."},
      {"quality_column", &columns.quality_column,
       "Name of its column of qualities; empty: as above, or none."},
      {"empty_fields",
       OneOf<EmptyFields>(
           &import.empty_fields,
           {{"recognise", EmptyFields::kRecognise,
             "unchanged in tables that look as if reported by exception"},
            {"bad", EmptyFields::kBad, ""},
            {"unchanged", EmptyFields::kUnchanged, "as in the row above"}}),
       "What an empty field means."},
      {"tags", Words(&tags),
       "TAG=CHANNEL,… for columns that are not named as in the model: CHANNEL "
       "is an input, output or <output>_setpoint; TAG=CHANNEL*SCALE+OFFSET "
       "converts units, channel = scale × column + offset."},
      {"tag_file", tag_file,
       "File (CSV) of tags with the columns tag, channel and, where units "
       "differ, scale, offset and unit; in addition to --tags."},
      {"ignore_other_columns", &columns.ignore_other_columns,
       "Unknown columns are ignored; if false, they are errors."},
      {"quality_suffixes", Words(&columns.quality_suffixes),
       "The column <column><suffix> holds the quality of <column>; as long as "
       "they are these, so do columns of other usual names (OPCQuality, "
       "::status, Good, Questionable)."},
      {"good_qualities", Words(&import.good_qualities),
       "Values of quality columns that mean good; as long as they are these, "
       "so do others that are usual (192 to 255, GoodNonSpecific, True of a "
       "flag)."},
      {"bad_values", Words(&import.bad_values),
       "Values that mark a bad sample, in addition to an empty field, NaN and "
       "words such as Bad and No Data, separated by commas: -9999."},
      {"any_word_is_bad", &import.any_word_is_bad,
       "All text in place of a number marks a bad sample; if false, text that "
       "is not known is an error."},
      {"skip_repeated_times", &import.skip_repeated_times,
       "Rows with the time of the row before are ignored; if false, they are "
       "errors."},
      {"spread_repeated_times", &import.spread_repeated_times,
       "Rows of one time, whose seconds were lost, are spread evenly until the "
       "next time."},
      {"skip_backward_times", &import.skip_backward_times,
       "Rows with an earlier time than the row before are ignored; if false, "
       "they are errors."},
      {"sample_time", &import.sample_time,
       "Sample time Δt of the resampled records; 0: that of the files.", "min",
       kNotNegative},
      {"max_gap", &import.max_gap,
       "Longest gap of inputs that is bridged; negative: five samples.", "min"},
  };
}

std::vector<Option> OptionsOf(RecordOptions& options) {
  WindowOptions& windows = options.windows;
  return {
      {"mark_outliers", &options.mark.outliers,
       "Samples far from their neighbours are marked as bad; if there are any, "
       "or with --robust, also samples that are outliers under the model."},
      {"mark_frozen", &options.mark.frozen,
       "Stretches in which an output repeats one value are marked as bad."},
      {"window_before", &windows.before,
       "Length of the record kept before a set-point change; 0: the model's "
       "settling time.",
       "min", kNotNegative},
      {"window_after", &windows.after,
       "Length of the record kept after a set-point change; 0: 1.5 times the "
       "model's settling time, 20 samples at least.",
       "min", kNotNegative},
      {"min_setpoint_change", &windows.min_change,
       "Largest change of a set point that is ignored.", "", kNotNegative},
      {"mode_tag", ModeTags(&options.modes),
       "Tags that say when the controller was in use (TAG), or the loop of an "
       "output or below an input (TAG=CHANNEL), separated by commas; words "
       "such as MAN, AUTO, CAS, SHED, or 1 and 0. Moves of inputs by hand "
       "count as changes."},
      {"change_times",
       TimesOrDates(&windows.change_times, &options.change_dates),
       "Times of set-point changes, for records without set points, ascending "
       "and separated by commas; dates such as 2024-02-29 12:34 where the "
       "records have dates.",
       "min"},
      {"leave_out", TimesOrDates(&options.leave_out, &options.leave_out_dates),
       "Windows that are not used: each that contains one of these times, "
       "separated by commas; dates as in --change_times.",
       "min"},
      {"most_samples", &options.most_samples,
       "Samples of windows that are used: of longer records the windows that "
       "are expected to inform most; 0: all.",
       "", kNotNegative},
      {"most_samples_in_memory", &options.most_samples_in_memory,
       "Samples that are held in memory: of longer records the stretches that "
       "are expected to inform most, found while they are read; 0: all.",
       "", kNotNegative},
  };
}

absl::Status ParseTags(const std::vector<std::string>& tags,
                       const std::string& tag_file, const ProcessModel& model,
                       ColumnOptions& columns) {
  if (!tag_file.empty()) {
    MLE_ASSIGN_OR_RETURN(TagTable mapped,
                         AboutOption("tag_file", ReadTagFile(tag_file, model)));
    columns.tags = std::move(mapped.tags);
    columns.unused_tags = std::move(mapped.unused);
  }
  for (const std::string& text : tags) {
    MLE_ASSIGN_OR_RETURN(TagMapping mapping, ParseTag(text, model));
    columns.tags.push_back(std::move(mapping));
  }
  return absl::OkStatus();
}

}  // namespace mle::correct
