// One pass over the files of a historian. Internal to mle/data; historian.h is
// what users see.

#ifndef MLE_DATA_HISTORIAN_IMPORTER_H_
#define MLE_DATA_HISTORIAN_IMPORTER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/data/historian_file.h"
#include "mle/data/record_collector.h"
#include "mle/data/record_sink.h"
#include "mle/data/resampler.h"
#include "mle/data/row_stream.h"
#include "mle/data/table_import.h"

namespace mle {

// Reads the sources one after the other.
class HistorianImporter {
 public:
  // `sink`: takes the records while they are read; null: all are held.
  HistorianImporter(const ProcessModel& channels,
                    const HistorianOptions& options, RecordSink* sink = nullptr)
      : channels_(channels), options_(options), sink_(sink) {}

  absl::StatusOr<HistorianImport> Run(
      const std::vector<HistorianSource>& sources);
  // The same of tables in memory (historian_importer_tables.cc).
  absl::StatusOr<HistorianImport> Run(const std::vector<Table>& tables);

 private:
  // A table whose columns are matched, and its rows.
  struct MatchedTable;
  class TableRows;

  absl::Status Probe(const std::vector<HistorianSource>& sources);
  absl::Status ChooseSampleTime(const std::vector<double>& steps);
  absl::Status ChooseStepOfExceptions(const std::vector<double>& steps);
  // What is declared of each value, and is a mean over what lies between rows.
  void Declare(ResamplerOptions& resampler) const;
  bool IsMeanOfStep(const Sampling& sampling) const;
  bool IsPoint(int output) const;
  void NoteDeclared();
  Resampler Begin();
  absl::StatusOr<HistorianImport> End(Resampler& resampler);
  absl::Status ReadSource(const HistorianProbe& probe, Resampler& resampler);
  absl::StatusOr<std::vector<MatchedTable>> MatchTables(
      const std::vector<Table>& tables);
  absl::Status ProbeTables(const std::vector<MatchedTable>& tables);
  absl::Status ReadTable(const MatchedTable& matched,
                         const HistorianProbe& probe, Resampler& resampler);
  // Rows of a file, or of a table (`file` null).
  absl::Status TakeRows(RowStream& rows, const HistorianProbe& probe,
                        const HistorianFile* file, FileReport& report,
                        Resampler& resampler);
  absl::Status ShowProgress(const FileReport& report, double fraction) const;
  // A row in order. False where there would be more samples than allowed.
  bool TakeRow(const RecordRow& row, Resampler& resampler);
  std::string TooManySamples() const;
  absl::Status CheckOrder(const HistorianProbe& probe, const RowStream& rows,
                          double time, bool is_first, bool& skip);
  absl::Status OrderError(const HistorianProbe& probe, const RowStream& rows,
                          double time, bool is_first) const;
  // The time added to those of a file that is a record of its own.
  double ShiftOf(const HistorianProbe& probe) const;
  void NoteForm(const HistorianProbe& probe, FileReport& report);
  // `spread`: the part of the stream that spreads times, if it has one.
  std::unique_ptr<RowStream> StreamOf(HistorianFile& file,
                                      const HistorianProbe& probe,
                                      const SpreadRows*& spread) const;
  std::vector<bool> PointsOf(const HistorianProbe& probe) const;
  bool FitsWithin(double time);
  void NoteGap(double time);
  void NoteSamples();
  void NoteIgnoredRows();
  CollectorOptions MakeCollectorOptions() const;
  void NoteChannels(const RecordRows& rows, bool is_unchanged);
  // The report of the channel that a column is; null for other columns.
  ChannelReport* NoteColumn(const RecordColumn& column);
  absl::Status CheckChannels();
  void Warn();

  int num_values() const {
    return 2 * channels_.num_outputs() + channels_.num_inputs();
  }

  const ProcessModel& channels_;
  const HistorianOptions& options_;
  RecordSink* const sink_;
  std::vector<HistorianProbe> probes_;
  HistorianImport import_;
  double max_gap_ = 0.0;
  std::optional<RecordCollector> collector_;
  bool has_last_ = false;
  double last_time_ = 0.0;    // of any row
  double last_usable_ = 0.0;  // of one with a good sample
  bool has_usable_ = false;
  // By value: outputs, set points, inputs.
  std::vector<ChannelReport> values_;
  std::vector<bool> is_there_;
  std::vector<std::int64_t> good_;
  std::vector<std::string> bad_qualities_;
};

}  // namespace mle

#endif  // MLE_DATA_HISTORIAN_IMPORTER_H_
