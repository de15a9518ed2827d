// What is declared of files of records: their text, their columns, how times
// are written, and what marks a bad sample. What is not declared is recognised
// (historian.h).
//
//   HistorianOptions options;
//   options.columns.tags = {{.tag = "TI101", .channel = "overhead"}};
//   options.clock.time_zone = "Europe/Berlin";

#ifndef MLE_DATA_IMPORT_OPTIONS_H_
#define MLE_DATA_IMPORT_OPTIONS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "mle/model/process_model.h"

namespace mle {

struct CsvLimits {
  std::size_t max_row_bytes = std::size_t{1} << 20;
  int max_columns = 10000;
};

enum class TimeFormat {
  kRecognise,         // a form that is certain, as the first row has it
  kNumbers,           // in ClockOptions::number_unit
  kIso,               // 2024-02-29T12:34:56Z, with another zone or none
  kDayFirst,          // 29.02.2024 12:34:56, 29/2/24 12:34
  kMonthFirst,        // 2/29/2024 12:34:56 PM
  kYearFirst,         // 2024/02/29 12:34:56
  kMonthName,         // 29-Feb-24 12:34:56.0
  kExcel,             // 45351.5242: days since 1899-12-30
  kUnix,              // 1709210096: seconds since 1970
  kUnixMilliseconds,  // 1709210096000
  kPattern,           // ClockOptions::pattern
};

struct ClockOptions {
  TimeFormat format = TimeFormat::kRecognise;
  // The pattern of times for kPattern (time_format.h).
  std::string pattern = {};
  // Unit of times that are numbers: ms, s, min, h, d; empty: the model's.
  std::string number_unit = {};
  // Time zone of dates that state none, as the IANA names it ("Europe/Berlin");
  // empty: UTC, or local time that has no change of clocks in it.
  std::string time_zone = {};
};

// A column whose name is not that of its channel, or whose unit is not.
struct TagMapping {
  std::string tag;      // name of the column
  std::string channel;  // input, output or <output>_setpoint of the model
  double scale = 1.0;   // not 0: channel = scale × column + offset
  double offset = 0.0;
  std::string place = {};  // where it is written, for messages: a file, a line
  // In place of what the model declares of an input or output.
  std::optional<Sampling> sampling = {};
};

// A tag that says when a loop or the controller was in use (modes.h).
struct ModeTag {
  std::string tag;      // name of the column
  std::string channel;  // an input or output; empty: the whole controller
};

struct ColumnOptions {
  // Two columns are named with a plus between them: "date+time".
  std::string time_column = "time";
  // Columns of long tables, which have a row for each sample; empty: recognised
  // by usual names (tag, value, quality, …).
  std::string tag_column = {};
  std::string value_column = {};
  std::string quality_column = {};
  std::vector<TagMapping> tags = {};
  // Columns known not to be needed: ignored without being asked for.
  std::vector<std::string> unused_tags = {};
  // Words, folded (nearest_names.h), that stand for a number.
  std::map<std::string, double> word_values = {};
  // Unknown columns are ignored. If false, they are errors.
  bool ignore_other_columns = false;
  // <column><suffix> is the quality of <column>. As long as they are these,
  // other usual names are known too (quality_columns.h).
  std::vector<std::string> quality_suffixes = {"_quality", ".quality"};

  // Channels exist, none is mapped twice, scales are finite and not 0.
  absl::Status Validate(const ProcessModel& channels) const;
};

// Values of quality columns that mean good unless others are declared: good, ok
// and 192.
const std::vector<std::string>& UsualGoodQualities();

// Meaning of an empty field of a table.
enum class EmptyFields {
  kRecognise,  // unchanged, if the table looks as if reported by exception
  kBad,        // a bad sample
  kUnchanged,  // the value of the row above
};

// How far an import is.
struct ImportProgress {
  std::string source;      // its name
  std::int64_t rows = 0;   // read of it
  std::string reached;     // the time of the last one, as messages have it
  double fraction = -1.0;  // of the source, in [0, 1]; negative: not known
};

// Times are in the model's unit.
struct HistorianOptions {
  // The text. 0: recognised.
  char separator = 0;  // ',', ';' or a tab
  char decimal = 0;    // '.' or ','
  // Titles, and rows of units. 0: recognised.
  int lines_above_header = 0;
  int rows_below_header = 0;
  // Names of the columns of files that have no header.
  std::vector<std::string> header = {};
  CsvLimits limits = {};

  // Time, tags and their units, quality columns, others.
  ColumnOptions columns = {};
  // Values of quality columns that mean good, whatever their case. All others
  // mean bad, but as long as they are these, for what is usual (IsUsuallyGood()
  // in quality_columns.h).
  std::vector<std::string> good_qualities = UsualGoodQualities();
  // Values that mark a bad sample, besides an empty field, NaN and the words in
  // KnownBadWords(): as text or as a number ("-9999").
  std::vector<std::string> bad_values = {};
  // All other text in place of a number is a bad sample too; if false, it is an
  // error that counts such words.
  bool any_word_is_bad = false;
  EmptyFields empty_fields = EmptyFields::kRecognise;

  // The clock of all files; or clocks, one for each file, in the order in which
  // they are given.
  ClockOptions clock = {};
  std::vector<ClockOptions> clocks = {};
  // The time range that is read (time_range.h): numbers or dates; empty: no
  // limit. Both are included.
  std::string begin = {};
  std::string end = {};
  // Files whose times are numbers are records of their own, one after another
  // in the order given: each may begin at 0.
  bool separate_files = false;
  // A row at the time of the one before, or earlier than it: an error, unless
  // such rows are ignored and counted.
  bool skip_repeated_times = false;
  // Rows of one time, whose seconds are lost, are spread evenly until the next.
  bool spread_repeated_times = false;
  bool skip_backward_times = false;

  // Δt > 0; 0: the files' step.
  double sample_time = 0.0;
  // Gaps of inputs and set points are bridged up to this, ≥ 0. Negative: 5 Δt,
  // or 5 steps where those are longer. Gaps of outputs stay NaN.
  double max_gap = -1.0;
  // Limit of the samples of all records together, > 0: more is an error.
  std::int64_t max_samples = 20'000'000;
  // Called after every 1,000 rows of files and databases; false ends the import
  // with absl::CancelledError. May be empty.
  std::function<bool(const ImportProgress&)> progress = {};

  absl::Status Validate(const ProcessModel& channels) const;
};

}  // namespace mle

#endif  // MLE_DATA_IMPORT_OPTIONS_H_
