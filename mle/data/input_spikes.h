// Single samples of an input that its controller cannot have asked for: the
// input leaves its course for one sample and comes back. Other than outliers of
// a held value (channel_health.h), these may stand where the controller moves.
//
// A sample is a spike if it lies beyond both its neighbours by far more than
// usual: by five times the 99th percentile of such excursions. Where the input
// moves only every few samples, an excursion of one sample is not a move of the
// controller at all, and one of half a usual move is a spike. Around a change
// of set point, where controllers give kicks of one period, nothing is called a
// spike unless the period is longer than a sample.

#ifndef MLE_DATA_INPUT_SPIKES_H_
#define MLE_DATA_INPUT_SPIKES_H_

#include <vector>

#include "mle/data/record.h"

namespace mle {

struct InputSpike {
  int sample = 0;
  double value = 0.0;
  double usual = 0.0;  // what to put in its place
};

std::vector<InputSpike> FindInputSpikes(const Record& record, int input);

// Samples between instants at which the input moves; 1 if it may move at any.
// `phase`: the first instant.
int MovePeriod(const Record& record, int input, int& phase);

}  // namespace mle

#endif  // MLE_DATA_INPUT_SPIKES_H_
