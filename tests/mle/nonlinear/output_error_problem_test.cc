#include "mle/nonlinear/output_error_problem.h"

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "Eigen/QR"
#include "gtest/gtest.h"
#include "mle/nonlinear/delay_search.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

OutputErrorProblem ProblemOf(const ProcessModel& model,
                             const std::vector<Record>& records) {
  OutputErrorProblem::Elements elements(model.num_inputs());
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.element(0, j).IsZero()) continue;
    elements[j] = *ElementResponse::Create(model.element(0, j));
  }
  return OutputErrorProblem(elements, records, 0, /*skip=*/40, /*min_rows=*/20);
}

OutputPoint PointOf(const OutputErrorProblem& problem) {
  OutputPoint point;
  for (const auto& element : problem.elements()) {
    point.values.push_back(element.has_value() ? element->initial_values()
                                               : ElementValues());
  }
  point.SetCells(problem.sample_time());
  return point;
}

const NoiseShape kDriftShapes[] = {{.ratio = 0.0, .offset = false},
                                   {.ratio = 0.0},
                                   {.ratio = 1e-3},
                                   {.ratio = 1.0}};

TEST(OutputErrorProblemTest, TheTrueParametersLeaveNothing) {
  const ProcessModel plant = TwoElements();
  const auto records = MakeRecords(plant, 400, 1, {});
  const OutputErrorProblem problem = ProblemOf(plant, records);
  for (const NoiseShape shape : kDriftShapes) {
    const WhitenedColumns whitened =
        problem.Whiten(problem.Linearise(PointOf(problem), shape, {}), shape);
    // The simulation is exact to about 1e-9 (Runge–Kutta in fine steps).
    EXPECT_LT(whitened.residuals.cwiseAbs().maxCoeff(), 1e-7);
  }
}

// Of an output without elements, of which a step disturbs one segment alone:
// the others have no amplitudes.
TEST(OutputErrorProblemTest, SegmentsMayHaveNoAmplitudes) {
  ProcessModel model = MakeModel(1, 2);
  std::vector<Record> records = MakeRecords(TwoElements(), 200, 2, {});
  for (Record& record : records) record.outputs.setZero();
  records[1].outputs.rightCols(100).setConstant(3.0);
  OutputErrorProblem problem = ProblemOf(model, records);
  ASSERT_EQ(problem.num_segments(), 2);
  problem.SetSteps({{.segment = 1, .sample = 100}});
  const NoiseShape white = {.ratio = 0.0, .offset = false};
  const OutputErrorProblem::Sizes sizes =
      problem.DisturbanceSizes(PointOf(problem), white);
  ASSERT_EQ(sizes.steps.size(), 1u);
  EXPECT_NEAR(sizes.steps[0], 3.0, 1e-9);
  const WhitenedColumns whitened =
      problem.Whiten(problem.Linearise(PointOf(problem), white, {}), white);
  EXPECT_LT(whitened.residuals.cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(whitened.num_amplitudes, 1);
}

// Where samples are lost the rows of free responses are those of the samples
// that are left.
TEST(OutputErrorProblemTest, FreeResponsesGoOnThroughGaps) {
  const ProcessModel plant = TwoElements();
  std::vector<Record> records = {MakeRecord(plant, 200, 5, {.variance = 0.01})};
  const OutputErrorProblem whole = ProblemOf(plant, records);
  for (const int lost : {60, 61, 62, 90}) {
    records[0].outputs(0, lost) = std::numeric_limits<double>::quiet_NaN();
  }
  const OutputErrorProblem gaps = ProblemOf(plant, records);
  const NoiseShape shape;
  const MatrixXd all = whole.Linearise(PointOf(whole), shape, {})[0].amplitudes;
  const MatrixXd left = gaps.Linearise(PointOf(gaps), shape, {})[0].amplitudes;
  const std::vector<int>& times = gaps.times(0);
  ASSERT_EQ(left.rows(), all.rows() - 4);
  for (Eigen::Index row = 0; row < left.rows(); ++row) {
    EXPECT_EQ(left.row(row), all.row(times[row] - times.front()));
  }
}

// Over a short step the secant is the derivative; over a long one it is the
// difference of the residuals at its ends.
TEST(OutputErrorProblemTest, SecantsOfDeadTimes) {
  const ProcessModel plant = TwoElements();
  const OutputErrorProblem problem =
      ProblemOf(plant, MakeRecords(plant, 400, 5, {.variance = 0.01}));
  const OutputPoint point = PointOf(problem);
  const NoiseShape shape = {.ratio = 0.01};
  const auto exact = problem.Linearise(point, shape, {true, true});
  auto columns = exact;
  problem.TakeSecants(point, {true, true}, {0.0, 1e-4}, columns);
  for (std::size_t s = 0; s < exact.size(); ++s) {
    EXPECT_EQ(columns[s].jacobian.leftCols(5), exact[s].jacobian.leftCols(5));
    EXPECT_LT((columns[s].jacobian - exact[s].jacobian).norm(),
              1e-3 * exact[s].jacobian.col(5).norm());
  }
  problem.TakeSecants(point, {true, true}, {0.0, 1.7}, columns);
  OutputPoint ends[2] = {point, point};
  ends[0].values[1].delay -= 1.7;
  ends[1].values[1].delay += 1.7;
  for (OutputPoint& end : ends) end.SetCells(problem.sample_time());
  const auto low = problem.Linearise(ends[0], shape, {});
  const auto high = problem.Linearise(ends[1], shape, {});
  for (std::size_t s = 0; s < exact.size(); ++s) {
    const VectorXd expected =
        (high[s].residuals - low[s].residuals) / (2.0 * 1.7);
    EXPECT_LT((columns[s].jacobian.col(5) - expected).norm(),
              1e-9 * expected.norm());
  }
}

TEST(OutputErrorProblemTest, GradientIsThatOfDifferences) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction({2.0}, {8.0, 6.0, 1.0}, 1.2);
  const auto records = MakeRecords(plant, 400, 2, {.variance = 0.01});
  const OutputErrorProblem problem = ProblemOf(plant, records);
  OutputPoint point = PointOf(problem);
  point.values[0].gain *= 1.2;
  point.values[0].time_scale *= 0.9;
  point.values[1].delay += 0.13;
  point.SetCells(problem.sample_time());
  const auto cost = [&](const OutputPoint& at, const NoiseShape& shape) {
    return 0.5 * problem.Whiten(problem.Linearise(at, shape, {}), shape)
                     .residuals.squaredNorm();
  };
  for (const NoiseShape shape : kDriftShapes) {
    const WhitenedColumns whitened =
        problem.Whiten(problem.Linearise(point, shape, {true, true}), shape);
    const VectorXd gradient =
        whitened.jacobian.transpose() * whitened.residuals;
    const double h = 1e-5;
    for (int index = 0; index < 6; ++index) {
      const auto shifted = [&](double step) {
        OutputPoint at = point;
        ElementValues& v = at.values[index / 3];
        if (index % 3 == 0) v.gain += step;
        if (index % 3 == 1) v.time_scale *= std::exp(step);
        if (index % 3 == 2) v.delay += step;
        return at;
      };
      const double numeric =
          (cost(shifted(h), shape) - cost(shifted(-h), shape)) / (2.0 * h);
      // h² times third derivatives, and rounding of the cost by 1e-16/h.
      EXPECT_NEAR(gradient(index), numeric,
                  1e-6 * (1.0 + gradient.cwiseAbs().maxCoeff()))
          << index << " at ratio " << shape.ratio;
    }
  }
}

TEST(OutputErrorProblemTest, BadSamplesAreLeftOut) {
  const ProcessModel plant = TwoElements();
  auto records = MakeRecords(plant, 400, 3, {});
  const double bad = std::numeric_limits<double>::quiet_NaN();
  records[0].outputs(0, 150) = bad;
  records[0].outputs(0, 151) = bad;
  records[1].inputs(1, 200) = bad;
  const OutputErrorProblem problem = ProblemOf(plant, records);
  // An unknown input begins a new segment, which skips 40 samples anew.
  EXPECT_EQ(problem.num_segments(), 3);
  EXPECT_EQ(problem.num_samples(), 360 - 2 + 160 + 159);
  const NoiseShape shape = {.ratio = 0.01};
  const WhitenedColumns whitened =
      problem.Whiten(problem.Linearise(PointOf(problem), shape, {}), shape);
  EXPECT_LT(whitened.residuals.cwiseAbs().maxCoeff(), 1e-7);
}

TEST(DelaySearchTest, FindsDeadTimesFarAway) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0).set_delay(8.0);
  plant.element(0, 1).set_delay(0.5);
  const auto records = MakeRecords(plant, 400, 4, {.variance = 1e-4});
  const OutputErrorProblem problem = ProblemOf(TwoElements(), records);
  for (const NoiseShape shape : kDriftShapes) {
    const DelaySearchResult found = SearchDelays(
        problem, PointOf(problem), shape, {true, true}, {15.0, 15.0}, {});
    EXPECT_EQ(found.point.values[0].delay, 8.0);
    EXPECT_EQ(found.point.values[1].delay, 0.5);
    EXPECT_NEAR(found.point.values[0].gain, 2.0, 0.02);
    const double cost =
        0.5 * problem.Whiten(problem.Linearise(found.point, shape, {}), shape)
                  .residuals.squaredNorm();
    EXPECT_NEAR(found.cost, cost, 1e-6 * cost + found.cost_accuracy);
  }
}

ProcessModel ThreeElements() {
  ProcessModel model = MakeModel(1, 3);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3.0, 6.0, 2.5);
  model.element(0, 2) = TransferFunction::FirstOrder(1.0, 9.0, 0.5);
  return model;
}

// Of three elements no pair has better dead times, given the third, and the
// cost is that of the fit.
TEST(DelaySearchTest, NoPairOfThreeIsBetter) {
  const ProcessModel model = ThreeElements();
  ProcessModel plant = model;
  plant.element(0, 0).set_delay(3.5);
  plant.element(0, 1).set_delay(1.0);
  plant.element(0, 2).set_delay(4.0);
  const OutputErrorProblem problem =
      ProblemOf(model, MakeRecords(plant, 400, 6, {.variance = 0.3}));
  const NoiseShape shape = {.ratio = 0.01};
  const DelaySearchResult found =
      SearchDelays(problem, PointOf(problem), shape, {true, true, true},
                   {6.0, 6.0, 6.0}, {});
  std::vector<int> delays(13);
  std::iota(delays.begin(), delays.end(), 0);
  const MatrixXd dictionary =
      problem.Dictionary(PointOf(problem), shape, {delays, delays, delays});
  const VectorXd y = dictionary.col(39);
  const auto cost = [&](const std::array<int, 3>& at) {
    MatrixXd chosen(y.size(), 3);
    for (int j = 0; j < 3; ++j) chosen.col(j) = dictionary.col(13 * j + at[j]);
    const VectorXd gains = chosen.householderQr().solve(y);
    return 0.5 * (y - chosen * gains).squaredNorm();
  };
  std::array<int, 3> at;
  for (int j = 0; j < 3; ++j) {
    at[j] = static_cast<int>(std::lround(found.point.values[j].delay / 0.5));
  }
  EXPECT_NEAR(found.cost, cost(at), 1e-8 * found.cost + found.cost_accuracy);
  for (int held = 0; held < 3; ++held) {
    for (int i = 0; i < 13; ++i) {
      for (int k = 0; k < 13; ++k) {
        std::array<int, 3> other = at;
        other[(held + 1) % 3] = i;
        other[(held + 2) % 3] = k;
        EXPECT_GE(cost(other), found.cost * (1.0 - 1e-8)) << i << " " << k;
      }
    }
  }
}

// A quarter of 4, 6 and 9 min are 2, 3 and 4 samples: the best of them from
// where the search begins.
TEST(DelaySearchTest, TriesDeadTimesAsFarApartAsResponsesAllow) {
  const ProcessModel model = ThreeElements();
  ProcessModel plant = model;
  plant.element(0, 0).set_delay(3.0);
  plant.element(0, 1).set_delay(1.0);
  plant.element(0, 2).set_delay(4.5);
  const OutputErrorProblem problem =
      ProblemOf(model, MakeRecords(plant, 400, 6, {.variance = 1e-4}));
  const NoiseShape shape = {.ratio = 0.01};
  const DelaySearchResult found =
      SearchDelays(problem, PointOf(problem), shape, {true, true, true},
                   {6.0, 6.0, 6.0}, {.share = 0.25});
  EXPECT_EQ(found.point.values[0].delay, 3.0);
  EXPECT_EQ(found.point.values[1].delay, 1.0);
  EXPECT_EQ(found.point.values[2].delay, 4.5);
  // Between them there is a better one.
  plant.element(0, 0).set_delay(3.5);
  const OutputErrorProblem between =
      ProblemOf(model, MakeRecords(plant, 400, 6, {.variance = 1e-4}));
  const DelaySearchResult near =
      SearchDelays(between, PointOf(between), shape, {true, true, true},
                   {6.0, 6.0, 6.0}, {.share = 0.25});
  const DelaySearchResult exact =
      SearchDelays(between, PointOf(between), shape, {true, true, true},
                   {6.0, 6.0, 6.0}, {});
  EXPECT_EQ(std::fmod(near.point.values[0].delay, 1.0), 0.0);
  EXPECT_EQ(exact.point.values[0].delay, 3.5);
  EXPECT_LT(exact.cost, near.cost);
}

TEST(DelaySearchTest, HoldsWhatIsNotFree) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0).set_delay(8.0);
  const auto records = MakeRecords(plant, 400, 5, {.variance = 1e-4});
  const OutputErrorProblem problem = ProblemOf(TwoElements(), records);
  const DelaySearchResult found = SearchDelays(problem, PointOf(problem), {},
                                               {true, false}, {15.0, 15.0}, {});
  EXPECT_EQ(found.point.values[0].delay, 8.0);
  EXPECT_EQ(found.point.values[1].delay, 2.3);
  EXPECT_EQ(found.point.values[1].gain, -3.0);
}

}  // namespace
}  // namespace mle
