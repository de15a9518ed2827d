// Keeps, of records that are read, the segments that are expected to say most
// about a model (segment_information.h), so that records of any length can be
// read.
//
//   RecordScan scan(model, 200'000);
//   MLE_ASSIGN_OR_RETURN(
//       const HistorianImport import,
//       ImportHistorianSources(sources, model, HistorianOptions(), &scan));
//   scan.Notes();  // how many were kept, and what the others would have added
//
// Records are divided into segments of four settling times or a hundredth of
// what is kept, whichever is longer. A segment that is kept brings one and a
// half settling times on both sides with it, so that a change of a set point
// near its end has the window that it needs. When twice as many samples are
// held as are to be kept, those are chosen that inform most, and of what has
// been left only the sum of its information remains: what is kept at the end
// need not be what would be chosen from all at once, but of two segments that
// say the same of the same elements the shorter one stays.
//
// Memory: twice the samples kept, and those at their sides, whatever is read.
// Operations: samples times elements.

#ifndef MLE_MAINTAIN_RECORD_SCAN_H_
#define MLE_MAINTAIN_RECORD_SCAN_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/data/record.h"
#include "mle/data/record_sink.h"
#include "mle/maintain/message.h"
#include "mle/maintain/segment_information.h"
#include "mle/model/process_model.h"

namespace mle {

class RecordScan final : public RecordSink {
 public:
  // Keeps `most_samples` > 0, or one segment where that is longer, and what
  // belongs to its sides. `model` must outlive it.
  RecordScan(const ProcessModel& model, int most_samples)
      : model_(model), most_samples_(most_samples) {}

  int PieceSamples(double sample_time) const override;
  absl::Status Take(Record piece, bool continues) override;
  // Segments that follow each other without a gap are one record again.
  std::vector<Record> Finish() override;

  // After Finish(). Empty where everything was kept.
  std::vector<Message> Notes() const;

 private:
  struct Segment {
    Record record;
    Record before;  // at its sides; perhaps empty
    Record after;
    std::int64_t number = 0;  // of the segments read
    bool continues = false;   // the one before it
  };

  void Keep();
  int Side(const Record& segment) const;

  const ProcessModel& model_;
  const int most_samples_;
  std::int64_t segments_read_ = 0;
  std::int64_t samples_read_ = 0;
  std::int64_t samples_ = 0;  // of the segments held
  std::int64_t segments_kept_ = 0;
  std::int64_t samples_kept_ = 0;
  Record last_;  // the end of the last segment, perhaps needed by the next
  std::vector<Segment> segments_;
  std::vector<SegmentInformation> information_;  // of these
  Eigen::VectorXd all_;                          // of everything read
  Eigen::VectorXd used_;                         // of what is kept
};

}  // namespace mle

#endif  // MLE_MAINTAIN_RECORD_SCAN_H_
