// Records of known ARX models.

#ifndef TESTS_MLE_CORRECTION_ARX_DATA_H_
#define TESTS_MLE_CORRECTION_ARX_DATA_H_

#include <algorithm>
#include <cstdint>
#include <random>

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"

namespace mle {

// 2 × 2 and stable, few coefficients of 4 lags different from zero.
inline ArxModel SparseArx() {
  ArxModel model;
  model.sample_time = 0.5;
  model.order = 4;
  model.num_outputs = 2;
  model.num_inputs = 2;
  model.R.setZero(2, 16);
  model.R(0, 0) = 0.7;    // y1, lag 1
  model.R(0, 2) = 1.0;    // u1, lag 1
  model.R(0, 11) = -0.5;  // u2, lag 3
  model.R(1, 1) = 0.5;    // y2, lag 1
  model.R(1, 5) = 0.2;    // y2, lag 2
  model.R(1, 7) = 2.0;    // u2, lag 2
  return model;
}

// y_k = offset + R x_k + noise under white inputs about `input_offset`, in
// deviations from the offsets.
inline Record SimulateArx(const ArxModel& model, int samples, double noise,
                          std::uint64_t seed, double output_offset = 0.0,
                          double input_offset = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const int p = model.num_outputs;
  const int m = model.num_inputs;
  Record record;
  record.sample_time = model.sample_time;
  record.outputs.setZero(p, samples);
  record.inputs.setZero(m, samples);
  for (int k = 0; k < samples; ++k) {
    for (int i = 0; i < p; ++i) record.outputs(i, k) = noise * normal(random);
    for (int j = 0; j < m; ++j) record.inputs(j, k) = normal(random);
    for (int lag = 1; lag <= std::min(model.order, k); ++lag) {
      const auto block = model.R.middleCols((lag - 1) * (p + m), p + m);
      record.outputs.col(k) += block.leftCols(p) * record.outputs.col(k - lag) +
                               block.rightCols(m) * record.inputs.col(k - lag);
    }
  }
  record.outputs.array() += output_offset;
  record.inputs.array() += input_offset;
  return record;
}

}  // namespace mle

#endif  // TESTS_MLE_CORRECTION_ARX_DATA_H_
