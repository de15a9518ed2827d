#include "mle/nonlinear/output_fitter.h"

#include <vector>

#include "gtest/gtest.h"
#include "mle/nonlinear/output_fit.h"
#include "tests/mle/nonlinear/fitted_output.h"

namespace mle {
namespace {

// Near the optimum dead times go from sample to sample, in both directions.
TEST(FitterTest, DeadTimesMoveThroughTheirSamples) {
  const FittedOutput fitted = FitRecords(TwoElements(), {.variance = 0.01}, 3);
  const OutputErrorOptions options;
  const std::vector<bool> free = {true, true};
  for (const int samples : {-2, 2}) {
    Fitter fitter(fitted.problem(), free, fitted.setups[0].bounds, options);
    OutputPoint point = fitted.fit.point;
    point.values[1].delay += samples * fitted.problem().sample_time();
    point.SetCells(fitted.problem().sample_time());
    fitter.RefineRoughly(point, ShapeOf(fitted.fit.noise), /*near=*/true);
    EXPECT_EQ(point.cells[1], fitted.fit.point.cells[1]) << samples;
    EXPECT_NEAR(point.values[1].delay, fitted.fit.point.values[1].delay, 0.01);
  }
}

}  // namespace
}  // namespace mle
