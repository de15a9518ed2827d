// Trials in the state: how they are read, written and kept as numbers.

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "apps/watch/state.h"
#include "mle/base/status.h"

namespace mle::watch {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the state is kept in little-endian order");

// Both go over the same numbers in the same order (VisitTrial()).
class TrialWriter {
 public:
  void Number(double& value) { numbers_.push_back(value); }
  template <typename Whole>
  void Integer(Whole& value) {
    numbers_.push_back(static_cast<double>(value));
  }
  template <typename Item>
  void Resize(std::vector<Item>& items) {
    numbers_.push_back(static_cast<double>(items.size()));
  }
  template <typename Matrix>
  void Values(Matrix& matrix) {
    numbers_.push_back(static_cast<double>(matrix.rows()));
    numbers_.push_back(static_cast<double>(matrix.cols()));
    numbers_.insert(numbers_.end(), matrix.data(),
                    matrix.data() + matrix.size());
  }
  std::string Bytes() const {
    return {reinterpret_cast<const char*>(numbers_.data()),
            numbers_.size() * sizeof(double)};
  }

 private:
  std::vector<double> numbers_;
};

class TrialReader {
 public:
  explicit TrialReader(std::string_view bytes)
      : numbers_(bytes.size() / sizeof(double)),
        sound_(bytes.size() % sizeof(double) == 0) {
    if (numbers_.empty()) return;  // nor has data() a place
    std::memcpy(numbers_.data(), bytes.data(),
                numbers_.size() * sizeof(double));
  }
  void Number(double& value) {
    if (next_ >= numbers_.size()) sound_ = false;
    value = sound_ ? numbers_[next_++] : 0.0;
  }
  template <typename Whole>
  void Integer(Whole& value) {
    double number = 0.0;
    Number(number);
    if (!(std::abs(number) <= kMostWhole)) sound_ = false;
    value = sound_ ? static_cast<Whole>(number) : Whole{};
  }
  template <typename Item>
  void Resize(std::vector<Item>& items) {
    items.resize(Size());
  }
  template <typename Matrix>
  void Values(Matrix& matrix) {
    const std::size_t rows = Size();
    const std::size_t columns = Size();
    if (rows * columns > numbers_.size() - next_ ||
        (Matrix::ColsAtCompileTime == 1 && columns != 1)) {
      sound_ = false;
    }
    if (!sound_) return;
    matrix.resize(static_cast<Eigen::Index>(rows),
                  static_cast<Eigen::Index>(columns));
    for (double& value : matrix.reshaped()) Number(value);
  }
  // Everything was read, and nothing is missing.
  bool sound() const { return sound_ && next_ == numbers_.size(); }

 private:
  static constexpr double kMostWhole = 1e9;

  // No larger than what is left to read.
  std::size_t Size() {
    double number = 0.0;
    Number(number);
    if (!(number >= 0.0 && number <= static_cast<double>(numbers_.size()))) {
      sound_ = false;
    }
    return sound_ ? static_cast<std::size_t>(number) : 0;
  }

  std::vector<double> numbers_;
  std::size_t next_ = 0;
  bool sound_;
};

template <typename Archive>
void VisitNumbers(std::vector<double>& numbers, Archive& archive) {
  archive.Resize(numbers);
  for (double& number : numbers) archive.Number(number);
}

template <typename Archive>
void VisitResponses(std::vector<TrialResponse>& responses, Archive& archive) {
  archive.Resize(responses);
  for (TrialResponse& response : responses) {
    archive.Number(response.time);
    archive.Integer(response.changes);
    for (auto* numbers :
         {&response.gains, &response.sizes, &response.deviations,
          &response.in_use, &response.proposed}) {
      VisitNumbers(*numbers, archive);
    }
    archive.Integer(response.shapes);
  }
}

template <typename Archive>
void VisitTrial(TrialState& state, Archive& archive) {
  archive.Integer(state.adopted);
  archive.Integer(state.by_hand);
  archive.Number(state.end);
  archive.Integer(state.rows);
  archive.Integer(state.last_move);
  archive.Integer(state.response);
  archive.Integer(state.changes);
  for (auto* matrix : {&state.shapes, &state.differences, &state.in_use,
                       &state.proposed, &state.normal, &state.moments}) {
    archive.Values(*matrix);
  }
  for (auto* noise : {&state.noise, &state.always}) {
    archive.Resize(*noise);
    for (Variogram& of : *noise) {
      archive.Values(of.sums);
      archive.Values(of.counts);
    }
  }
  archive.Resize(state.losses);
  for (StepLosses& losses : state.losses) {
    for (auto* numbers : {&losses.in_use, &losses.proposed, &losses.counts}) {
      VisitNumbers(*numbers, archive);
    }
  }
  VisitResponses(state.learned, archive);
  VisitResponses(state.before, archive);
  VisitResponses(state.responses, archive);
}

}  // namespace

std::string EncodeTrial(const TrialState& state) {
  TrialState copy = state;
  TrialWriter writer;
  VisitTrial(copy, writer);
  return writer.Bytes();
}

absl::StatusOr<TrialState> DecodeTrial(std::string_view bytes) {
  TrialReader reader(bytes);
  TrialState state;
  VisitTrial(state, reader);
  if (!reader.sound()) return absl::DataLossError("a trial cannot be read");
  return state;
}

absl::Status State::LoadTrials(Watch& watch) {
  MLE_ASSIGN_OR_RETURN(
      const Rows rows,
      database_->Run("SELECT day, last_day, sample_time, in_use, proposed, "
                     "ended, fault, who, at, note, adopted_day, data "
                     "FROM trial WHERE watch = ? ORDER BY day",
                     {watch.id}));
  for (const Row& row : rows) {
    Trial trial = {.day = static_cast<int>(row.Integer(0)),
                   .last_day = static_cast<int>(row.Integer(1)),
                   .sample_time = row.Number(2),
                   .in_use = row.Text(3),
                   .proposed = row.Text(4),
                   .ended = row.Text(5),
                   .fault = row.Text(6),
                   .adopted_day = static_cast<int>(row.Integer(10))};
    if (!row.IsNull(7)) {
      trial.adopted = {
          .who = row.Text(7), .at = row.Integer(8), .note = row.Text(9)};
    }
    MLE_ASSIGN_OR_RETURN(trial.state, DecodeTrial(row.Text(11)));
    watch.trials.push_back(std::move(trial));
  }
  return absl::OkStatus();
}

absl::Status State::SaveTrials(const Watch& now, const Watch& before) {
  for (const Trial& trial : now.trials) {
    const std::string data = EncodeTrial(trial.state);
    bool is_same = false;
    for (const Trial& saved : before.trials) {
      is_same = is_same ||
                (saved.day == trial.day && saved.last_day == trial.last_day &&
                 saved.ended == trial.ended && saved.fault == trial.fault &&
                 saved.adopted_day == trial.adopted_day &&
                 EncodeTrial(saved.state) == data);
    }
    if (is_same) continue;
    Value who;
    Value at;
    Value note;
    if (trial.adopted.has_value()) {
      who = trial.adopted->who;
      at = trial.adopted->at;
      note = trial.adopted->note;
    }
    MLE_RETURN_IF_ERROR(Write(
        "INSERT INTO trial VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
        "ON CONFLICT(watch, day) DO UPDATE SET last_day = excluded.last_day, "
        "sample_time = excluded.sample_time, in_use = excluded.in_use, "
        "proposed = excluded.proposed, ended = excluded.ended, "
        "fault = excluded.fault, who = excluded.who, at = excluded.at, "
        "note = excluded.note, adopted_day = excluded.adopted_day, "
        "data = excluded.data",
        {now.id, trial.day, trial.last_day, trial.sample_time, trial.in_use,
         trial.proposed, trial.ended, trial.fault, who, at, note,
         trial.adopted_day, Bytes{data}}));
  }
  return absl::OkStatus();
}

}  // namespace mle::watch
