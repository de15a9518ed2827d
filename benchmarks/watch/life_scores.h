// A life of a plant as the watch remembers it: the scores of its days, and what
// the informed CUSUM saw. To simulate and to score a life takes seconds, to
// judge its scores milliseconds; so they are kept in a file, and other rules of
// evidence are tried on the same lives.

#ifndef BENCHMARKS_WATCH_LIFE_SCORES_H_
#define BENCHMARKS_WATCH_LIFE_SCORES_H_

#include <optional>
#include <string>
#include <vector>

#include "benchmarks/watch/plant_life.h"
#include "mle/monitor/change_evidence.h"

namespace mle::benchmarks {

struct LifeScores {
  int used = 0;  // days
  int cannot_tell = 0;
  // Day and value wherever the CUSUM of the ageing at hand reaches a new
  // height; without ageing the largest value of each of the 12.
  std::vector<std::string> cusum;
  std::vector<std::vector<ScoredBatch>> outputs;  // p, one batch a day
};

LifeScores SimulateLife(const ProcessModel& model, const LifeOptions& options);

// Binary, whole or not there.
void WriteLifeScores(const std::string& path, const LifeScores& scores);
// Nothing where there is no such file.
std::optional<LifeScores> ReadLifeScores(const std::string& path);

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_WATCH_LIFE_SCORES_H_
