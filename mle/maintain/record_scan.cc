#include "mle/maintain/record_scan.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// Segments that are kept, about.
constexpr int kSegments = 100;

}  // namespace

int RecordScan::PieceSamples(double sample_time) const {
  return std::max(most_samples_ / kSegments,
                  ShortestSegment(model_, sample_time));
}

// One and a half of the settling times of which ShortestSegment() has four, so
// that the sides of two segments do not meet in the one between them.
int RecordScan::Side(const Record& segment) const {
  return std::min(ShortestSegment(model_, segment.sample_time) / 8 * 3,
                  segment.samples());
}

absl::Status RecordScan::Take(Record piece, bool continues) {
  MLE_ASSIGN_OR_RETURN(SegmentInformation information,
                       InformationIn(piece, model_));
  if (all_.size() == 0) all_.setZero(information.information.size());
  all_ += information.information;
  samples_read_ += piece.samples();
  samples_ += piece.samples();
  const int side = Side(piece);
  Segment segment;
  segment.number = segments_read_;
  segment.continues = continues;
  if (continues) {
    segment.before = std::move(last_);
    if (!segments_.empty() && segments_.back().number + 1 == segments_read_) {
      segments_.back().after = PartOf(piece, 0, side);
    }
  }
  last_ = PartOf(piece, piece.samples() - side, side);
  segment.record = std::move(piece);
  segments_.push_back(std::move(segment));
  information_.push_back(std::move(information));
  ++segments_read_;
  if (samples_ / 2 >= most_samples_) Keep();
  return absl::OkStatus();
}

// Leaves what informs most of what is held.
void RecordScan::Keep() {
  const std::vector<bool> taken =
      ChooseSegments(information_, all_, most_samples_);
  samples_ = 0;
  std::size_t kept = 0;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    if (!taken[s]) continue;
    samples_ += segments_[s].record.samples();
    if (kept != s) {
      segments_[kept] = std::move(segments_[s]);
      information_[kept] = std::move(information_[s]);
    }
    ++kept;
  }
  segments_.resize(kept);
  information_.resize(kept);
}

std::vector<Record> RecordScan::Finish() {
  if (samples_ > most_samples_) Keep();
  segments_kept_ = static_cast<std::int64_t>(segments_.size());
  used_.setZero(all_.size());
  for (const SegmentInformation& segment : information_) {
    used_ += segment.information;
  }
  std::vector<Record> records;
  for (std::size_t s = 0; s < segments_.size();) {
    std::vector<Record> parts = {std::move(segments_[s].before)};
    do {
      parts.push_back(std::move(segments_[s].record));
      ++s;
    } while (s < segments_.size() && segments_[s].continues &&
             segments_[s].number == segments_[s - 1].number + 1);
    parts.push_back(std::move(segments_[s - 1].after));
    std::erase_if(parts,
                  [](const Record& part) { return part.samples() == 0; });
    Record record =
        parts.size() == 1 ? std::move(parts[0]) : JoinRecords(parts);
    if (record.samples() < 2) continue;
    samples_kept_ += record.samples();
    records.push_back(std::move(record));
  }
  segments_.clear();
  information_.clear();
  return records;
}

std::vector<Message> RecordScan::Notes() const {
  if (samples_ == samples_read_) return {};
  return {{MessageCode::kWindowDropped,
           "",
           absl::StrFormat("Of %d stretches of the records %d were kept while "
                           "they were read, the most informative: %d of %d "
                           "samples. %s",
                           segments_read_, segments_kept_, samples_kept_,
                           samples_read_, DescribeLoss(used_, all_)),
           {"most_samples_in_memory"}}};
}

}  // namespace mle
