// How a plant was operated and sampled, as far as it bears on what its records
// can tell: inputs at their limits, moves between samples, samples per time
// constant, set points that an optimiser moves.

#ifndef MLE_DATA_OPERATION_H_
#define MLE_DATA_OPERATION_H_

#include <vector>

#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// Time that an input spends at exactly its smallest and largest value. They are
// taken for limits if the input comes there three times or more, or stays for
// more than ten times its usual run of equal samples, and is elsewhere for a
// tenth of the time: a switch has two values, not limits.
struct TimeAtLimits {
  int input = 0;
  double low = 0.0;
  double high = 0.0;
  double share_low = 0.0;  // of the samples; 0 where it is not a limit
  double share_high = 0.0;
};
// Inputs that spend at least one sample in a hundred there.
std::vector<TimeAtLimits> FindTimeAtLimits(const std::vector<Record>& records);

// Moves of an input that holds its value on both sides for two samples or more:
// those that take two steps in the same direction happened between samples, and
// the sample in the middle is an average.
struct SplitMoves {
  int input = 0;
  int moves = 0;
  int split = 0;
};
// Inputs of whose moves, ten or more, at least half are split.
std::vector<SplitMoves> FindSplitMoves(const std::vector<Record>& records);

// An element whose slowest time constant is less than 3 or more than 500
// samples. With fewer its shape is not seen; with more, neighbouring samples
// tell the same, and costs grow.
struct SamplingRate {
  int output = 0;
  int input = 0;
  double samples = 0.0;  // per time constant
};
std::vector<SamplingRate> FindUnusualSampling(const ProcessModel& model,
                                              double sample_time);

// A set point that moves, on average, more than twice within a settling time,
// more than 50 times in all: no change has a response of its own.
struct ManyMoves {
  int output = 0;
  int moves = 0;
  double median_size = 0.0;
};
std::vector<ManyMoves> FindManySetPointMoves(const std::vector<Record>& records,
                                             const ProcessModel& model);

}  // namespace mle

#endif  // MLE_DATA_OPERATION_H_
