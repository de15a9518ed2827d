#include "mle/maintain/record_scan.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// Stretches that are kept, about.
constexpr int kStretches = 100;

}  // namespace

int RecordScan::PieceSamples(double sample_time) const {
  return std::max(most_samples_ / kStretches,
                  ShortestStretch(model_, sample_time));
}

// One and a half of the settling times of which ShortestStretch() has four, so
// that the sides of two stretches do not meet in the one between them.
int RecordScan::Side(const Record& stretch) const {
  return std::min(ShortestStretch(model_, stretch.sample_time) / 8 * 3,
                  stretch.samples());
}

absl::Status RecordScan::Take(Record piece, bool continues) {
  MLE_ASSIGN_OR_RETURN(StretchInformation information,
                       InformationIn(piece, model_));
  if (all_.size() == 0) all_.setZero(information.information.size());
  all_ += information.information;
  samples_read_ += piece.samples();
  samples_ += piece.samples();
  const int side = Side(piece);
  Stretch stretch;
  stretch.number = stretches_read_;
  stretch.continues = continues;
  if (continues) {
    stretch.before = std::move(last_);
    if (!stretches_.empty() &&
        stretches_.back().number + 1 == stretches_read_) {
      stretches_.back().after = PartOf(piece, 0, side);
    }
  }
  last_ = PartOf(piece, piece.samples() - side, side);
  stretch.record = std::move(piece);
  stretches_.push_back(std::move(stretch));
  information_.push_back(std::move(information));
  ++stretches_read_;
  if (samples_ / 2 >= most_samples_) Keep();
  return absl::OkStatus();
}

// Leaves what informs most of what is held.
void RecordScan::Keep() {
  const std::vector<bool> taken =
      ChooseStretches(information_, all_, most_samples_);
  samples_ = 0;
  std::size_t kept = 0;
  for (std::size_t s = 0; s < stretches_.size(); ++s) {
    if (!taken[s]) continue;
    samples_ += stretches_[s].record.samples();
    if (kept != s) {
      stretches_[kept] = std::move(stretches_[s]);
      information_[kept] = std::move(information_[s]);
    }
    ++kept;
  }
  stretches_.resize(kept);
  information_.resize(kept);
}

std::vector<Record> RecordScan::Finish() {
  if (samples_ > most_samples_) Keep();
  stretches_kept_ = static_cast<std::int64_t>(stretches_.size());
  used_.setZero(all_.size());
  for (const StretchInformation& stretch : information_) {
    used_ += stretch.information;
  }
  std::vector<Record> records;
  for (std::size_t s = 0; s < stretches_.size();) {
    std::vector<Record> parts = {std::move(stretches_[s].before)};
    do {
      parts.push_back(std::move(stretches_[s].record));
      ++s;
    } while (s < stretches_.size() && stretches_[s].continues &&
             stretches_[s].number == stretches_[s - 1].number + 1);
    parts.push_back(std::move(stretches_[s - 1].after));
    std::erase_if(parts,
                  [](const Record& part) { return part.samples() == 0; });
    Record record =
        parts.size() == 1 ? std::move(parts[0]) : JoinRecords(parts);
    if (record.samples() < 2) continue;
    samples_kept_ += record.samples();
    records.push_back(std::move(record));
  }
  stretches_.clear();
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
                           stretches_read_, stretches_kept_, samples_kept_,
                           samples_read_, DescribeLoss(used_, all_)),
           {"most_samples_in_memory"}}};
}

}  // namespace mle
