#include "benchmarks/watch/life_scores.h"

#include <fstream>
#include <memory>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "benchmarks/watch/informed_cusum.h"
#include "glog/logging.h"
#include "mle/base/file.h"
#include "mle/mle.h"

namespace mle::benchmarks {
namespace {

class LifeRun {
 public:
  LifeRun(const ProcessModel& model, const LifeOptions& options)
      : model_(model), options_(options), life_(model, options) {
    absl::StatusOr<ModelWatch> watch =
        ModelWatch::Create(model, 1.0, WatchOptions());
    CHECK(watch.ok()) << watch.status();
    watch_ = std::make_unique<ModelWatch>(*std::move(watch));
    scores_.outputs.resize(model.num_outputs());
    skip_ = static_cast<int>(SettlingTime(model)) + 1;
    for (int a = 1; a < kNumAgeings; ++a) {
      for (int e = 0; e < 4; ++e) {
        const AgeingElement element{.output = e / 2, .input = e % 2};
        const auto kind = static_cast<Ageing>(a);
        if (options.ageing != Ageing::kNone &&
            (options.ageing != kind ||
             element.output != life_.ageing().output ||
             element.input != life_.ageing().input)) {
          continue;
        }
        cusums_.emplace_back(life_, *watch_, skip_, kind, element);
        heights_.push_back(0.0);
      }
    }
  }

  LifeScores Run() {
    std::vector<WatchBatch> first;
    for (int day = 0; day < options_.reference_days; ++day) {
      first.push_back(life_.Day(day, watch_->lead()));
    }
    absl::StatusOr<WatchReference> reference = watch_->MakeReference(first);
    CHECK(reference.ok()) << reference.status();
    for (int day = 0; day < options_.days; ++day) {
      if (life_.Moves(day)) Live(day, *reference);
    }
    if (options_.ageing == Ageing::kNone) {
      for (const double height : heights_) {
        scores_.cusum.push_back(absl::StrCat(height));
      }
    }
    return scores_;
  }

 private:
  void AddToCusums(int day, const WatchReference& reference,
                   const Record& record) {
    std::vector<std::vector<WhitenedRun>> before;
    for (int i = 0; i < model_.num_outputs(); ++i) {
      before.push_back(ClippedInnovations(model_, i, skip_,
                                          reference.outputs[i], record,
                                          watch_->options().clip));
    }
    for (std::size_t c = 0; c < cusums_.size(); ++c) {
      cusums_[c].Add(day, reference, record, before);
      if (cusums_[c].value() <= heights_[c]) continue;
      heights_[c] = cusums_[c].value();
      if (options_.ageing != Ageing::kNone) {
        scores_.cusum.push_back(absl::StrCat(day, ":", heights_[c]));
      }
    }
  }

  void Live(int day, const WatchReference& reference) {
    WatchBatch batch = life_.Day(day, watch_->lead());
    AddToCusums(day, reference, batch.record);
    absl::StatusOr<BatchScores> scores =
        watch_->Score(reference, std::move(batch));
    CHECK(scores.ok()) << scores.status();
    for (const std::string& reason : scores->Reasons()) {
      VLOG(1) << "day " << day << ": " << reason;
    }
    scores_.used += scores->state == BatchState::kUsed ? 1 : 0;
    scores_.cannot_tell += scores->state == BatchState::kCannotTell ? 1 : 0;
    for (std::size_t i = 0; i < scores_.outputs.size(); ++i) {
      BatchOutput& output = scores->outputs[i];
      if (output.state != BatchState::kUsed) continue;
      scores_.outputs[i].push_back(
          {.number = day,
           .score = std::move(output.score),
           .information = std::move(output.information),
           .largest = std::move(output.largest)});
    }
  }

  const ProcessModel& model_;
  LifeOptions options_;
  PlantLife life_;
  std::unique_ptr<ModelWatch> watch_;
  int skip_ = 0;
  std::vector<InformedCusum> cusums_;
  std::vector<double> heights_;
  LifeScores scores_;
};

template <typename Value>
void Put(const Value& value, std::ostream& out) {
  out.write(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <typename Value>
Value Take(std::istream& in) {
  Value value{};
  in.read(reinterpret_cast<char*>(&value), sizeof(value));
  return value;
}

void PutPart(const Eigen::VectorXd& score, const Eigen::MatrixXd& information,
             std::ostream& out) {
  for (const double value : score) Put(value, out);
  for (const double value : information.reshaped()) Put(value, out);
}

void TakePart(Eigen::Index size, Eigen::VectorXd& score,
              Eigen::MatrixXd& information, std::istream& in) {
  score.resize(size);
  information.resize(size, size);
  for (double& value : score) value = Take<double>(in);
  for (double& value : information.reshaped()) value = Take<double>(in);
}

}  // namespace

LifeScores SimulateLife(const ProcessModel& model, const LifeOptions& options) {
  return LifeRun(model, options).Run();
}

void WriteLifeScores(const std::string& path, const LifeScores& scores) {
  std::ostringstream out;
  Put(scores.used, out);
  Put(scores.cannot_tell, out);
  Put(scores.cusum.size(), out);
  for (const std::string& step : scores.cusum) out << step << '\n';
  Put(scores.outputs.size(), out);
  for (const std::vector<ScoredBatch>& batches : scores.outputs) {
    Put(batches.size(), out);
    for (const ScoredBatch& batch : batches) {
      Put(batch.number, out);
      Put(batch.score.size(), out);
      PutPart(batch.score, batch.information, out);
      Put(batch.largest.has_value(), out);
      if (!batch.largest.has_value()) continue;
      PutPart(batch.largest->score, batch.largest->information, out);
    }
  }
  const absl::Status written = WriteFileAtomically(path, out.str());
  CHECK(written.ok()) << written;
}

std::optional<LifeScores> ReadLifeScores(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  LifeScores scores;
  scores.used = Take<int>(in);
  scores.cannot_tell = Take<int>(in);
  scores.cusum.resize(Take<std::size_t>(in));
  for (std::string& step : scores.cusum) std::getline(in, step);
  scores.outputs.resize(Take<std::size_t>(in));
  for (std::vector<ScoredBatch>& batches : scores.outputs) {
    batches.resize(Take<std::size_t>(in));
    for (ScoredBatch& batch : batches) {
      batch.number = Take<int>(in);
      const auto size = Take<Eigen::Index>(in);
      TakePart(size, batch.score, batch.information, in);
      if (!Take<bool>(in)) continue;
      batch.largest.emplace();
      TakePart(size, batch.largest->score, batch.largest->information, in);
    }
  }
  CHECK(in.good()) << path << " is not whole";
  return scores;
}

}  // namespace mle::benchmarks
