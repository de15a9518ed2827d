// The CUSUM that knows the change: which element, which parameter, by how much
// and how it goes on, all but when it begins. What no test can do much better
// than (Page, Biometrika 41, 1954; Lorden, Annals of Mathematical Statistics
// 42, 1971).

#ifndef BENCHMARKS_WATCH_INFORMED_CUSUM_H_
#define BENCHMARKS_WATCH_INFORMED_CUSUM_H_

#include <vector>

#include "benchmarks/watch/plant_life.h"
#include "mle/monitor/model_watch.h"
#include "mle/monitor/row_response.h"

namespace mle::benchmarks {

// What the model leaves of an output, clipped.
std::vector<WhitenedRun> ClippedInnovations(const ProcessModel& model,
                                            int output, int skip,
                                            const OutputReference& reference,
                                            const Record& record, double clip);

class InformedCusum {
 public:
  // The element ages in that way from an unknown day on.
  InformedCusum(const PlantLife& life, const ModelWatch& watch, int skip,
                Ageing ageing, AgeingElement element);

  // Adds a day, in order; `before`: what the model as it is leaves of each
  // output (ClippedInnovations).
  void Add(int day, const WatchReference& reference, const Record& record,
           const std::vector<std::vector<WhitenedRun>>& before);
  // The statistic after the last day: max over the begin of the log-likelihood
  // ratio, at least 0.
  double value() const { return value_; }

 private:
  // Of a gain that is off by δ: δ S − δ²V/2.
  struct GainDay {
    int day = 0;
    double score = 0.0;
    double information = 0.0;
  };

  Ageing ageing_;
  AgeingElement element_;
  int skip_;
  double clip_;
  ProcessModel after_;
  std::vector<GainDay> days_;
  double value_ = 0.0;
};

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_WATCH_INFORMED_CUSUM_H_
