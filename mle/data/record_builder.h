// A record that grows sample by sample, without ever being in memory twice.
// Internal to mle/data.

#ifndef MLE_DATA_RECORD_BUILDER_H_
#define MLE_DATA_RECORD_BUILDER_H_

#include <vector>

#include "mle/data/record.h"

namespace mle {

class RecordBuilder {
 public:
  RecordBuilder(int num_outputs, int num_inputs)
      : num_outputs_(num_outputs), num_inputs_(num_inputs) {}

  // 2p + m values: outputs, set points, inputs.
  void Add(const std::vector<double>& values);
  int samples() const { return samples_; }

  // The record; nothing is left. `with_set_points`: if not, it has none.
  Record Take(double start_time, double sample_time, bool with_set_points);

 private:
  int num_outputs_;
  int num_inputs_;
  int samples_ = 0;
  std::vector<std::vector<double>> blocks_;  // sample after sample
};

}  // namespace mle

#endif  // MLE_DATA_RECORD_BUILDER_H_
