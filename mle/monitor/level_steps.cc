#include "mle/monitor/level_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mle/monitor/output_scores.h"
#include "mle/nonlinear/amplitude_fit.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kMostSteps = 6;
constexpr Index kBesideStep = 8;  // samples before it and after
constexpr Index kPlacesAtFirst = 64;
constexpr double kStepClip = 4.0;   // deviations
constexpr double kStepPrice = 8.0;  // of χ², beside 2 ln N
constexpr double kLeastLeft = 0.1;  // of a step, unexplained by the rest

struct StepCandidate {
  double chi_square = 0.0;
  Index row = 0;
  double lag = 0.0;
  VectorXd column;
};

}  // namespace

MatrixXd FindLevelSteps(const std::vector<int>& instants,
                        const InnovationsFilter& filter,
                        const std::vector<double>& lags, double deviation,
                        const MatrixXd& whitened) {
  const Index rows = whitened.rows();
  MatrixXd found(rows, 0);
  if (rows <= 2 * kBesideStep + kMostSteps + whitened.cols()) return found;
  const double least = 2.0 * std::log(static_cast<double>(rows)) + kStepPrice;
  while (found.cols() < kMostSteps) {
    MatrixXd others(rows, whitened.cols() - 1 + found.cols());
    others << whitened.rightCols(whitened.cols() - 1), found;
    const AmplitudeFit rest(std::move(others));
    VectorXd residual = whitened.col(0);
    rest.TakeOut(residual);
    const double unit = std::max(
        RobustDeviationOf({residual.begin(), residual.end()}), deviation);
    if (!(unit > 0.0)) break;
    residual =
        residual.cwiseMin(kStepClip * unit).cwiseMax(-kStepClip * unit) / unit;
    StepCandidate best;
    const auto look = [&](double lag, Index from, Index to, Index stride) {
      const Index places = (to - from + stride - 1) / stride;
      MatrixXd columns = MatrixXd::Zero(rows, places);
      for (Index place = 0; place < places; ++place) {
        const Index begin = from + place * stride;
        const LevelStep step = {.time = static_cast<double>(instants[begin]),
                                .lag = lag,
                                .size = 1.0};
        for (Index row = begin; row < rows; ++row) {
          columns(row, place) = step.At(instants[row], 1.0);
        }
      }
      filter.Apply(columns);
      MatrixXd left = columns;
      rest.TakeOut(left);
      for (Index place = 0; place < places; ++place) {
        const double square = left.col(place).squaredNorm();
        if (!(square > kLeastLeft * columns.col(place).squaredNorm())) continue;
        const double product = left.col(place).dot(residual);
        if (product * product <= best.chi_square * square) continue;
        best = {product * product / square, from + place * stride, lag,
                columns.col(place)};
      }
    };
    const Index stride =
        std::max<Index>((rows - 2 * kBesideStep) / kPlacesAtFirst, 1);
    for (const double lag : lags) {
      look(lag, kBesideStep, rows - kBesideStep, stride);
    }
    if (best.chi_square > 0.0) {
      const Index row = best.row;
      look(best.lag, std::max(row - stride + 1, kBesideStep),
           std::min(row + stride, rows - kBesideStep), 1);
    }
    if (!(best.chi_square > least)) break;
    found.conservativeResize(Eigen::NoChange, found.cols() + 1);
    found.rightCols(1) = best.column;
  }
  return found;
}

}  // namespace mle
