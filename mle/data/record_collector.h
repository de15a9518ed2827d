// Makes records of a stream of samples: gaps are bridged and counted. Records
// are held until they are taken, or given to a sink in pieces as they grow.
// Internal to mle/data.

#ifndef MLE_DATA_RECORD_COLLECTOR_H_
#define MLE_DATA_RECORD_COLLECTOR_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "mle/data/historian.h"
#include "mle/data/record.h"
#include "mle/data/record_sink.h"

namespace mle {

// Bad samples between good ones, up to `max_samples` in a row, are filled with
// the value before them; those of outputs stay bad. An input that moves at
// every so many samples only, as a controller moves it, is held up to the last
// such instant in the gap, and has the value after the gap from there on;
// eleven moves or more must show it. Returns how many samples were filled in
// each channel: outputs (none), set points, inputs (2p + m).
std::vector<int> BridgeGaps(int max_samples, Record& record);

// A record that grows sample by sample, without ever being in memory twice.
class RecordBuilder {
 public:
  RecordBuilder(int num_outputs, int num_inputs)
      : num_outputs_(num_outputs), num_inputs_(num_inputs) {}

  // 2p + m values: outputs, set points, inputs.
  void Add(const std::vector<double>& values);
  int samples() const { return samples_; }

  // The record; nothing is left. `with_set_points`: if not, it has none.
  Record Take(double start_time, double sample_time, bool with_set_points);

 private:
  int num_outputs_;
  int num_inputs_;
  int samples_ = 0;
  std::vector<std::vector<double>> blocks_;  // sample after sample
};

struct CollectorOptions {
  int num_outputs = 0;  // p
  int num_inputs = 0;   // m
  double sample_time = 0.0;
  bool has_set_points = false;
  int max_bridged = 0;  // samples in a row
};

class RecordCollector {
 public:
  // `sink`: takes the records, and outlives this; null: they are held.
  explicit RecordCollector(const CollectorOptions& options,
                           RecordSink* sink = nullptr);

  // `begins`: a record begins with this sample.
  void Add(bool begins, double time, const std::vector<double>& values);
  // To be called after the last sample.
  void Finish();

  // Samples so far.
  std::int64_t samples() const { return samples_; }
  // Single samples left out.
  std::int64_t short_pieces() const { return short_pieces_; }
  // By value (2p + m).
  const std::vector<std::int64_t>& bridged() const { return bridged_; }
  const std::vector<std::int64_t>& missing() const { return missing_; }
  // Status of the sink.
  const absl::Status& status() const { return status_; }
  // Those held, or what the sink has kept.
  std::vector<Record> TakeRecords() {
    return sink_ != nullptr ? sink_->Finish() : std::move(records_);
  }

 private:
  void EndRecord();
  // Takes the samples held of a record: all of it, or the rest after its last
  // piece.
  void EndPiece();
  bool IsPiece(const std::vector<double>& last) const;
  void TakeWhole(Record record);

  CollectorOptions options_;
  RecordSink* sink_;
  int piece_ = 0;           // samples
  bool continues_ = false;  // the record has a piece before this one
  absl::Status status_;
  RecordBuilder builder_;
  double start_time_ = 0.0;
  std::int64_t samples_ = 0;
  std::int64_t short_pieces_ = 0;
  std::vector<std::int64_t> bridged_;
  std::vector<std::int64_t> missing_;
  std::vector<Record> records_;
};

}  // namespace mle

#endif  // MLE_DATA_RECORD_COLLECTOR_H_
