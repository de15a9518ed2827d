// Fits of one output, for the tests of the output-error correction.

#ifndef TESTS_MLE_NONLINEAR_OUTPUT_ERROR_FITS_H_
#define TESTS_MLE_NONLINEAR_OUTPUT_ERROR_FITS_H_

#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

inline OutputErrorCorrection Correct(const ProcessModel& model,
                                     const std::vector<Record>& records,
                                     const OutputErrorOptions& options = {}) {
  auto correction = CorrectByOutputError(model, records, options);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

inline std::vector<ParameterEstimate> Parameters(const OutputErrorFit& fit,
                                                 int input) {
  const ElementEstimate& e = fit.element(0, input);
  return {e.gain, e.time_scale, e.delay};
}

// K, T, L.
inline std::vector<double> Values(const TransferFunction& element) {
  return {element.StaticGain(), element.TimeConstant(), element.delay()};
}

}  // namespace mle

#endif  // TESTS_MLE_NONLINEAR_OUTPUT_ERROR_FITS_H_
