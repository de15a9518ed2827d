#include "mle/nonlinear/response_rows.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "mle/data/record.h"
#include "mle/model/transfer_function.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kSamples = 500;

// Elements of several orders in turn, of which the tenth is none; the outputs
// miss samples one by one and a hundred together.
OutputErrorProblem MixedProblem(bool gaps) {
  const std::vector<TransferFunction> shapes = {
      TransferFunction::FirstOrder(1.0, 5.0, 0.4),
      TransferFunction({2.0}, {12.0, 7.0, 1.0}, 1.3),
      TransferFunction::FirstOrder(-2.0, 9.0, 3.0),
      TransferFunction::FirstOrder(0.5, 2.0, 0.0)};
  constexpr int kElements = 14;
  OutputErrorProblem::Elements elements(kElements);
  for (int j = 0; j < kElements; ++j) {
    if (j == 9) continue;
    elements[j] = *ElementResponse::Create(shapes[j % shapes.size()]);
  }
  Record record;
  record.sample_time = 1.0;
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  record.outputs.resize(1, kSamples);
  record.inputs.resize(kElements, kSamples);
  for (double& value : record.outputs.reshaped()) value = normal(engine);
  for (double& value : record.inputs.reshaped()) value = normal(engine);
  if (gaps) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    record.outputs.block(0, 200, 1, 100).setConstant(nan);
    for (const int k : {60, 62, 63, 420, 499}) record.outputs(0, k) = nan;
  }
  return OutputErrorProblem(elements, {record}, 0, /*skip=*/10,
                            /*min_rows=*/20);
}

// Row by row they are what the problem's elements make one by one, in blocks of
// any size and whatever was asked before.
TEST(ResponseRowsTest, AreTheColumnsOfEachElement) {
  for (const bool gaps : {false, true}) {
    const OutputErrorProblem problem = MixedProblem(gaps);
    ASSERT_EQ(problem.num_segments(), 1);
    const OutputErrorProblem::Segment& segment = problem.segment(0);
    const auto count = std::ssize(segment.times);
    OutputPoint point;
    for (const auto& element : problem.elements()) {
      point.values.push_back(element.has_value() ? element->initial_values()
                                                 : ElementValues());
      point.values.back().delay += 0.3;
    }
    point.SetCells(problem.sample_time());
    const std::vector<int> elements = {0, 1, 2, 3, 5, 6, 7, 8, 10, 11, 12, 13};
    ResponseRows responses(problem, elements);
    for (const bool derivatives : {true, false, true}) {
      responses.Start(segment, point, derivatives);
      const Eigen::Index stride = 3 * responses.count() + 2;
      RowMajorMatrix rows = RowMajorMatrix::Constant(count, stride, 7.0);
      VectorXd rest = VectorXd::Ones(count);
      Eigen::Index first = 0;
      for (const Eigen::Index size : {1, 40, 3, 200}) {
        responses.Next(segment.times.data() + first, size, rest.data() + first,
                       &rows(first, 1), stride);
        first += size;
      }
      responses.Next(segment.times.data() + first, count - first,
                     rest.data() + first, &rows(first, 1), stride);
      VectorXd expected = VectorXd::Ones(count);
      for (std::size_t f = 0; f < elements.size(); ++f) {
        MatrixXd response;
        problem.Respond(segment, point, elements[f], response);
        const double K = point.values[elements[f]].gain;
        const MatrixXd kept = response(segment.times, Eigen::all);
        expected -= K * kept.col(0);
        if (!derivatives) continue;
        const auto* places = &responses.places()[3 * f];
        EXPECT_LT((rows.col(1 + places[0]) + kept.col(0)).norm(), 1e-10);
        EXPECT_LT((rows.col(1 + places[1]) + K * kept.col(1)).norm(), 1e-10);
        EXPECT_LT((rows.col(1 + places[2]) + K * kept.col(2)).norm(), 1e-10);
      }
      EXPECT_LT((rest - expected).norm(), 1e-10);
      EXPECT_TRUE((rows.col(0).array() == 7.0).all());
      EXPECT_TRUE((rows.col(stride - 1).array() == 7.0).all());
      if (!derivatives) {
        EXPECT_TRUE((rows.array() == 7.0).all());
      }
    }
  }
}

}  // namespace
}  // namespace mle
