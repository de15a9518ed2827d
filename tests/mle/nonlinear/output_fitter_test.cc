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

// Of elements with nearly equal time constants some free responses are one for
// the solves and more for the search, whose squares are then less: no better
// dead times are behind that, and the search is not begun again.
TEST(FitterTest, SearchesAreJudgedByTheObjectiveOfTheSolves) {
  constexpr int kElements = 8;
  ProcessModel model = MakeModel(1, kElements);
  for (int j = 0; j < kElements; ++j) {
    model.element(0, j) = TransferFunction::FirstOrder(
        1.0 + 0.1 * j, 4.0 + 0.4 * j, 0.6 + 0.5 * j);
  }
  std::vector<Record> records;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    records.push_back(MakeRecord(model, 500, seed, {.variance = 4.0}));
  }
  const auto setups = SetUpOutputs(model, records, {});
  ASSERT_TRUE(setups.ok()) << setups.status();
  const OutputSetup& setup = setups->front();
  const OutputFit fit =
      FitOutput(*setup.problem, setup.start, std::vector<bool>(kElements, true),
                setup.bounds, {});
  EXPECT_TRUE(fit.certificate.search_confirmed);
  // Three at the start.
  EXPECT_LE(fit.certificate.grid_searches, 5);
}

}  // namespace
}  // namespace mle
