// How often the watch of a model cries wolf, how often it finds a change and
// when, beside the CUSUM that knows the change and tests that are repeated
// without regard to it.
//
//   watch_benchmark FILE.csv MODEL.json ROUNDS FIRST_ROUND
//
// Each round simulates a life of every effect without ageing, and one of every
// effect and kind of ageing, and appends a line for each to FILE.csv; lives
// that are there are not simulated again. table.py makes the table.

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "benchmarks/watch/informed_cusum.h"
#include "benchmarks/watch/plant_life.h"
#include "glog/logging.h"
#include "mle/mle.h"
#include "mle/monitor/change_evidence.h"
#include "mle/nonlinear/distributions.h"

namespace mle::benchmarks {
namespace {

constexpr int kNever = -1;
constexpr double kNominal = 0.05;

struct Outcome {
  int output_alarm = kNever;  // days of the first
  int element_alarm = kNever;
  int repeated_alarm = kNever;
  bool right_output = false;
  bool right_element = false;
  int used = 0;
  int cannot_tell = 0;
  // Day and value wherever the CUSUM of the ageing at hand reaches a new
  // height; without ageing the largest value of each of the 12.
  std::vector<std::string> cusum;
};

// Whether all data up to now reject "nothing has changed" at the nominal level,
// as if it were asked once.
bool RejectsOnce(const std::vector<std::vector<ScoredBatch>>& batches) {
  for (const std::vector<ScoredBatch>& output : batches) {
    if (output.empty()) continue;
    Eigen::VectorXd score = output.front().score;
    Eigen::MatrixXd information = output.front().information;
    for (std::size_t b = 1; b < output.size(); ++b) {
      score += output[b].score;
      information += output[b].information;
    }
    const double statistic =
        score.dot(information.completeOrthogonalDecomposition().solve(score));
    if (ChiSquareTail(statistic, static_cast<double>(score.size())) <
        kNominal / static_cast<double>(batches.size())) {
      return true;
    }
  }
  return false;
}

class LifeRun {
 public:
  LifeRun(const ProcessModel& model, const LifeOptions& options)
      : options_(options), life_(model, options) {
    absl::StatusOr<ModelWatch> watch =
        ModelWatch::Create(model, 1.0, WatchOptions());
    CHECK(watch.ok()) << watch.status();
    watch_ = std::make_unique<ModelWatch>(*std::move(watch));
    batches_.resize(model.num_outputs());
    const int skip = static_cast<int>(SettlingTime(model)) + 1;
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
        cusums_.emplace_back(life_, *watch_, skip, kind, element);
        heights_.push_back(0.0);
      }
    }
  }

  Outcome Run() {
    std::vector<WatchBatch> first;
    for (int day = 0; day < options_.reference_days; ++day) {
      first.push_back(life_.Day(day, watch_->lead()));
    }
    absl::StatusOr<WatchReference> reference = watch_->MakeReference(first);
    CHECK(reference.ok()) << reference.status();
    for (int day = 0; day < options_.days; ++day) {
      if (!life_.Moves(day)) continue;
      Live(day, *reference);
    }
    if (options_.ageing == Ageing::kNone) {
      for (const double height : heights_) {
        outcome_.cusum.push_back(absl::StrCat(height));
      }
    }
    return outcome_;
  }

 private:
  void Live(int day, const WatchReference& reference) {
    WatchBatch batch = life_.Day(day, watch_->lead());
    for (std::size_t c = 0; c < cusums_.size(); ++c) {
      cusums_[c].Add(day, reference, batch.record);
      if (cusums_[c].value() <= heights_[c]) continue;
      heights_[c] = cusums_[c].value();
      if (options_.ageing != Ageing::kNone) {
        outcome_.cusum.push_back(absl::StrCat(day, ":", heights_[c]));
      }
    }
    absl::StatusOr<BatchScores> scores =
        watch_->Score(reference, std::move(batch));
    CHECK(scores.ok()) << scores.status();
    for (const std::string& reason : scores->Reasons()) {
      VLOG(1) << "day " << day << ": " << reason;
    }
    outcome_.used += scores->state == BatchState::kUsed ? 1 : 0;
    outcome_.cannot_tell += scores->state == BatchState::kCannotTell ? 1 : 0;
    for (std::size_t i = 0; i < batches_.size(); ++i) {
      BatchOutput& output = scores->outputs[i];
      if (output.state != BatchState::kUsed) continue;
      batches_[i].push_back({.number = day,
                             .score = output.score,
                             .information = output.information});
      batches_[i] = MergeOld(batches_[i], day);
      Look(static_cast<int>(i), day);
    }
    if (outcome_.repeated_alarm == kNever && RejectsOnce(batches_)) {
      outcome_.repeated_alarm = day;
    }
  }

  void Look(int output, int day) {
    const WatchOptions& options = watch_->options();
    const ChangeEvidence evidence =
        EvidenceOf(batches_[output], watch_->LeastChanges(output), options);
    const double alpha = options.level;
    const bool aged = options_.ageing != Ageing::kNone;
    if (outcome_.output_alarm == kNever &&
        evidence.log_output >= std::log(2.0 * 2.0 / alpha)) {
      outcome_.output_alarm = day;
      outcome_.right_output = aged && output == life_.ageing().output;
      const LikelyChange likely = ExplainEvidence(
          batches_[output], watch_->LeastChanges(output), options);
      outcome_.right_element =
          outcome_.right_output && likely.element == life_.ageing().input;
    }
    for (const double element : evidence.log_elements) {
      if (outcome_.element_alarm == kNever &&
          element >= std::log(2.0 * 4.0 / alpha)) {
        outcome_.element_alarm = day;
      }
    }
  }

  LifeOptions options_;
  PlantLife life_;
  std::unique_ptr<ModelWatch> watch_;
  std::vector<InformedCusum> cusums_;
  std::vector<double> heights_;
  std::vector<std::vector<ScoredBatch>> batches_;
  Outcome outcome_;
};

std::string KeyOf(const LifeOptions& life) {
  return absl::StrCat(NameOf(life.effect), ",", NameOf(life.ageing), ",",
                      life.seed);
}

void RunLife(const ProcessModel& model, const LifeOptions& life,
             const std::string& path) {
  LifeRun run(model, life);
  const Outcome outcome = run.Run();
  const AgeingElement element = PlantLife(model, life).ageing();
  std::ofstream(path, std::ios::app)
      << KeyOf(life) << "," << element.output << "," << element.input << ","
      << element.begin << "," << outcome.output_alarm << ","
      << outcome.element_alarm << "," << outcome.repeated_alarm << ","
      << outcome.right_output << "," << outcome.right_element << ","
      << outcome.used << "," << outcome.cannot_tell << ","
      << absl::StrJoin(outcome.cusum, " ") << std::endl;
}

std::set<std::string> KeysIn(const std::string& path) {
  std::set<std::string> keys;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> fields = absl::StrSplit(line, ',');
    if (fields.size() < 13) continue;
    keys.insert(absl::StrCat(fields[0], ",", fields[1], ",", fields[2]));
  }
  return keys;
}

int Main(int argc, char** argv) {
  google::InitGoogleLogging(argv[0]);
  if (argc != 5) {
    std::cerr
        << "usage: watch_benchmark FILE.csv MODEL.json ROUNDS FIRST_ROUND\n";
    return 2;
  }
  absl::StatusOr<ProcessModel> model = ReadProcessModel(argv[2]);
  CHECK(model.ok()) << model.status();
  const std::set<std::string> done = KeysIn(argv[1]);
  const int first = std::atoi(argv[4]);
  for (int round = first; round < first + std::atoi(argv[3]); ++round) {
    for (int effect = 0; effect < kNumEffects; ++effect) {
      for (int ageing = 0; ageing < kNumAgeings; ++ageing) {
        LifeOptions life;
        life.effect = static_cast<Effect>(effect);
        life.ageing = static_cast<Ageing>(ageing);
        life.seed = static_cast<std::uint64_t>(
            1000 * round + kNumAgeings * effect + ageing + 1);
        if (!done.contains(KeyOf(life))) RunLife(*model, life, argv[1]);
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace mle::benchmarks

int main(int argc, char** argv) { return mle::benchmarks::Main(argc, argv); }
