// How often the watch of a model cries wolf, how often it finds a change and
// when, beside the CUSUM that knows the change and tests that are repeated
// without regard to it.
//
//   watch_benchmark FILE.csv MODEL.json ROUNDS FIRST_ROUND [FOLDER] [KINDS]
//       [EFFECTS]
//
// Each round simulates a life of every effect and kind of ageing, none among
// them, and appends a line for each to FILE.csv; lives that are there are not
// simulated again. FOLDER keeps their scores, so that another FILE.csv is made
// of the same lives without simulation. KINDS: none, gain, delay or
// time_constant, or several of them with commas, "" for all; EFFECTS likewise:
// white, drift, coloured, load, sine, outliers, compression, heavy_tails,
// steps, stiction, saturation, noisier. table.py makes the table.

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "benchmarks/watch/life_scores.h"
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

// Looks at the scores of a life day by day.
class Judgement {
 public:
  Judgement(const ModelWatch& watch, const LifeOptions& life,
            const AgeingElement& ageing)
      : watch_(watch), aged_(life.ageing != Ageing::kNone), ageing_(ageing) {
    batches_.resize(watch.model().num_outputs());
  }

  Outcome Judge(const LifeScores& scores) {
    std::map<int, std::vector<std::pair<int, const ScoredBatch*>>> days;
    for (std::size_t i = 0; i < scores.outputs.size(); ++i) {
      for (const ScoredBatch& batch : scores.outputs[i]) {
        days[batch.number].emplace_back(static_cast<int>(i), &batch);
      }
    }
    for (const auto& [day, outputs] : days) {
      for (const auto& [output, batch] : outputs) {
        batches_[output].push_back(*batch);
        batches_[output] = MergeOld(batches_[output], day);
        Look(output, day);
      }
      if (outcome_.repeated_alarm == kNever && RejectsOnce(batches_)) {
        outcome_.repeated_alarm = day;
      }
    }
    return outcome_;
  }

 private:
  void Look(int output, int day) {
    const WatchOptions& options = watch_.options();
    const ChangeEvidence evidence = ConfirmedEvidenceOf(
        batches_[output], watch_.LeastChanges(output), options);
    const double alpha = options.level;
    if (outcome_.output_alarm == kNever &&
        evidence.log_output >= std::log(2.0 * 2.0 / alpha)) {
      outcome_.output_alarm = day;
      outcome_.right_output = aged_ && output == ageing_.output;
      const LikelyChange likely = ExplainEvidence(
          batches_[output], watch_.LeastChanges(output), options);
      outcome_.right_element =
          outcome_.right_output && likely.element == ageing_.input;
    }
    for (const double element : evidence.log_elements) {
      if (outcome_.element_alarm == kNever &&
          element >= std::log(2.0 * 4.0 / alpha)) {
        outcome_.element_alarm = day;
      }
    }
  }

  const ModelWatch& watch_;
  bool aged_;
  AgeingElement ageing_;
  std::vector<std::vector<ScoredBatch>> batches_;
  Outcome outcome_;
};

std::string KeyOf(const LifeOptions& life) {
  return absl::StrCat(NameOf(life.effect), ",", NameOf(life.ageing), ",",
                      life.seed);
}

void RunLife(const ProcessModel& model, const LifeOptions& life,
             const std::string& path, const std::string& folder) {
  const std::string kept =
      folder.empty() ? ""
                     : absl::StrCat(folder, "/", NameOf(life.effect), "-",
                                    NameOf(life.ageing), "-", life.seed);
  std::optional<LifeScores> scores;
  if (!kept.empty()) scores = ReadLifeScores(kept);
  if (!scores.has_value()) {
    scores = SimulateLife(model, life);
    if (!kept.empty()) WriteLifeScores(kept, *scores);
  }
  const AgeingElement element = PlantLife(model, life).ageing();
  const absl::StatusOr<ModelWatch> watch =
      ModelWatch::Create(model, 1.0, WatchOptions());
  CHECK(watch.ok()) << watch.status();
  const Outcome outcome = Judgement(*watch, life, element).Judge(*scores);
  std::ofstream(path, std::ios::app)
      << KeyOf(life) << "," << element.output << "," << element.input << ","
      << element.begin << "," << outcome.output_alarm << ","
      << outcome.element_alarm << "," << outcome.repeated_alarm << ","
      << outcome.right_output << "," << outcome.right_element << ","
      << scores->used << "," << scores->cannot_tell << ","
      << absl::StrJoin(scores->cusum, " ") << std::endl;
}

// What an argument lists with commas; empty: all.
std::set<std::string> ListedIn(int argc, char** argv, int index) {
  if (argc <= index || std::string(argv[index]).empty()) return {};
  return absl::StrSplit(argv[index], ',');
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
  if (argc < 5 || argc > 8) {
    std::cerr << "usage: watch_benchmark FILE.csv MODEL.json ROUNDS "
                 "FIRST_ROUND [FOLDER] [KINDS] [EFFECTS]\n";
    return 2;
  }
  absl::StatusOr<ProcessModel> model = ReadProcessModel(argv[2]);
  CHECK(model.ok()) << model.status();
  const std::set<std::string> done = KeysIn(argv[1]);
  const int first = std::atoi(argv[4]);
  const std::string folder = argc > 5 ? argv[5] : "";
  const std::set<std::string> kinds = ListedIn(argc, argv, 6);
  const std::set<std::string> effects = ListedIn(argc, argv, 7);
  for (int round = first; round < first + std::atoi(argv[3]); ++round) {
    for (int effect = 0; effect < kNumEffects; ++effect) {
      for (int ageing = 0; ageing < kNumAgeings; ++ageing) {
        LifeOptions life;
        life.effect = static_cast<Effect>(effect);
        life.ageing = static_cast<Ageing>(ageing);
        life.seed = static_cast<std::uint64_t>(
            1000 * round + kNumAgeings * effect + ageing + 1);
        if (done.contains(KeyOf(life))) continue;
        if (!kinds.empty() && !kinds.contains(NameOf(life.ageing))) continue;
        if (!effects.empty() && !effects.contains(NameOf(life.effect)))
          continue;
        RunLife(*model, life, argv[1], folder);
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace mle::benchmarks

int main(int argc, char** argv) { return mle::benchmarks::Main(argc, argv); }
