// Records as a historian exports them: one or several CSV files of samples that
// need be neither evenly spaced nor complete, made into records sampled every
// Δt.
//
// The form of a file is recognised: its separator (comma, semicolon, tab), its
// decimal mark, its form of time. Where the form is not certain the import
// fails and says what to declare; it never guesses at a number. Quality columns
// and known words for bad samples are understood.
//
// With the spacing of the file's rows called its step:
//
//   inputs      held from row to row; a sample is the mean over [t_k, t_k + Δt)
//   set points  the value in force at t_k
//   outputs     step < Δt/1.5: the mean over [t_k − Δt/2, t_k + Δt/2), which
//               keeps dead times where they are and lets no noise from above
//               the new Nyquist frequency through; otherwise the row at t_k, or
//               linear between the rows on both sides
//
// A row farther than 1.9 steps from the one before leaves a gap, as bad samples
// do. Gaps of inputs and set points up to `max_gap` are bridged (held) and
// counted; a longer one, and any gap of an output, leaves bad samples (NaN),
// or, where every row is missing for longer, ends the record, and the next
// begins.
//
//   MLE_ASSIGN_OR_RETURN(
//       const HistorianImport import,
//       ImportHistorian({"jan.csv", "feb.csv"}, model, HistorianOptions()));
//   std::cout << import.report.FullReport(model.time_unit());
//   FindWindows(import.records, model, …);
//
// docs/records.md has the decisions, docs/formats.md the file.

#ifndef MLE_DATA_HISTORIAN_H_
#define MLE_DATA_HISTORIAN_H_

#include <cstdint>
#include <functional>
#include <istream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/import_options.h"
#include "mle/data/record.h"
#include "mle/data/time_names.h"
#include "mle/model/process_model.h"

namespace mle {

class RecordSink;
class RowSource;

// Why samples are bad.
struct BadSampleCounts {
  std::int64_t empty = 0;
  std::int64_t not_a_number = 0;  // NaN
  std::int64_t declared = 0;      // a bad value or a bad word
  std::int64_t quality = 0;       // by the quality column

  std::int64_t total() const {
    return empty + not_a_number + declared + quality;
  }
};

// A channel's samples as they were found, in rows of the files, and what became
// of them, in samples of the records.
struct ChannelReport {
  std::string name;    // of the channel
  std::string column;  // that it was read from
  BadSampleCounts bad;
  std::int64_t unchanged = 0;  // empty, as nothing has changed
  std::int64_t bridged = 0;    // samples
  std::int64_t missing = 0;    // samples that stay bad (NaN)
};

// Something that was recognised, with the option that declares otherwise.
struct ImportNote {
  std::string text;    // a whole sentence
  std::string option;  // may be empty
};

// Time without a usable row.
struct GapReport {
  double from = 0.0;    // of the row before
  double to = 0.0;      // of the row after
  bool splits = false;  // a new record begins after it
};

struct FileReport {
  std::string name;
  char separator = ',';
  char decimal = '.';
  std::string time_form;      // its name (time_format.h)
  bool newest_first = false;  // it was turned round
  std::int64_t rows = 0;
  double first_time = 0.0;
  double last_time = 0.0;
  std::vector<std::string> ignored_columns;  // the first 20
  int num_ignored_columns = 0;
};

struct HistorianReport {
  std::vector<FileReport> files;  // in order of time
  // Outputs, the set points present, inputs.
  std::vector<ChannelReport> channels;
  std::int64_t rows = 0;
  // Rows that are ignored, of which `rows` has the first three.
  std::int64_t repeated_rows = 0;
  std::int64_t backward_rows = 0;
  std::int64_t empty_rows = 0;    // without a good sample
  std::int64_t outside_rows = 0;  // of the time range
  std::int64_t comment_rows = 0;  // comments, and the header again
  std::int64_t spread_rows = 0;   // whose times were spread; not ignored
  double step = 0.0;              // of the files: the usual one
  double sample_time = 0.0;       // Δt
  bool averaged = false;          // the files are finer than Δt
  // Seconds since 1970-01-01T00:00:00Z at time 0, where times are dates.
  std::optional<double> time_origin;
  std::string time_zone;        // declared for dates; empty: none
  std::vector<GapReport> gaps;  // the first 100
  std::int64_t num_gaps = 0;
  std::int64_t samples = 0;       // that were read
  std::int64_t kept_samples = 0;  // of the records; the others a sink has left
  int records = 0;
  std::vector<std::string> warnings;
  std::vector<ImportNote> notes;

  // How its times are written. `time_unit` as in the model.
  TimeNames Times(const std::string& time_unit) const {
    return {time_unit, time_origin, time_zone};
  }

  std::string BriefReport() const;  // one line
  // `time_unit` as in the model.
  std::string FullReport(const std::string& time_unit) const;
};

struct HistorianImport {
  std::vector<Record> records;
  HistorianReport report;
};

// Records of these channels, from wherever those of a model come.
using ImportOf = std::function<absl::StatusOr<HistorianImport>(
    const ProcessModel&, const HistorianOptions&)>;

// A file, a query of a database (mle/database), or what takes their place in a
// test. Opened more than once, and always with the same rows.
struct HistorianSource {
  std::string name;
  // A text, whose form is recognised.
  std::function<absl::StatusOr<std::unique_ptr<std::istream>>()> open;
  // Or rows, of which nothing is to be recognised.
  std::function<absl::StatusOr<std::unique_ptr<RowSource>>()> open_rows = {};
  // Messages name rows, not lines.
  bool is_table = false;
  // Bytes of the text, for progress; 0: not known.
  std::int64_t bytes = 0;
};
// The name of standard input in messages and reports.
inline constexpr char kStandardInput[] = "standard input";

// A file, also one compressed by gzip; "-" is standard input.
HistorianSource FileSource(const std::string& path);
// Standard input, read to its end on the first call and kept, so that it can be
// read again. Not for several threads at once.
std::string_view StandardInput();
HistorianSource TextSource(std::string name, std::string text);

// Files may be given in any order. InvalidArgument, naming file, line and
// column, for what cannot be read with certainty; NotFound and the like for
// files. Memory is that of the records: 8 bytes for each channel and sample.
absl::StatusOr<HistorianImport> ImportHistorian(
    const std::vector<std::string>& paths, const ProcessModel& channels,
    const HistorianOptions& options);
// `sink`: takes the records in pieces while they are read, and what it keeps of
// them are the records of the import, however many samples are read; null: all
// are held.
absl::StatusOr<HistorianImport> ImportHistorianSources(
    const std::vector<HistorianSource>& sources, const ProcessModel& channels,
    const HistorianOptions& options, RecordSink* sink = nullptr);

}  // namespace mle

#endif  // MLE_DATA_HISTORIAN_H_
