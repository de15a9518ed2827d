#include "mle/nonlinear/delay_search.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Keeps combinations of all but equal responses from winning by rounding.
constexpr double kRidge = 1e-10;

// One column of the dictionary for each free element.
struct Combinations {
  MatrixXd gram;      // of all responses, scaled to a unit diagonal
  VectorXd products;  // with y
  VectorXd norms;

  VectorXd ScaledGains(const std::vector<int>& chosen) const {
    const MatrixXd normal =
        gram(chosen, chosen) +
        kRidge * MatrixXd::Identity(chosen.size(), chosen.size());
    return normal.llt().solve(VectorXd(products(chosen)));
  }
  double Explained(const std::vector<int>& chosen) const {
    if (chosen.size() == 2) {
      const double cross = gram(chosen[0], chosen[1]) / (1.0 + kRidge);
      const double a = products(chosen[0]);
      const double b = products(chosen[1]);
      return (a * a - 2.0 * cross * a * b + b * b) / (1.0 + kRidge) /
             (1.0 - cross * cross);
    }
    return ScaledGains(chosen).dot(VectorXd(products(chosen)));
  }
};

// Elements a and b (columns begins[a] … begins[a+1]−1) over all combinations;
// true if that improves.
bool ImprovePair(const Combinations& combinations,
                 const std::vector<int>& begins, int a, int b,
                 std::vector<int>& chosen, double& explained) {
  std::vector<int> trial = chosen;
  bool improved = false;
  for (int i = begins[a]; i < begins[a + 1]; ++i) {
    for (int k = begins[b]; k < begins[b + 1]; ++k) {
      trial[a] = i;
      trial[b] = k;
      const double value = combinations.Explained(trial);
      if (value > explained * (1.0 + 1e-12)) {
        explained = value;
        chosen = trial;
        improved = true;
      }
    }
  }
  return improved;
}

}  // namespace

DelaySearchResult SearchDelays(const OutputErrorProblem& problem,
                               const OutputPoint& start, NoiseShape shape,
                               const std::vector<bool>& free,
                               const std::vector<double>& max_delays,
                               int max_points) {
  const double sample_time = problem.sample_time();
  std::vector<std::vector<int>> delays(problem.num_elements());
  std::vector<int> elements;      // the free ones
  std::vector<int> begins = {0};  // of their columns
  std::vector<int> chosen;
  std::vector<int> all_delays;
  for (int j = 0; j < problem.num_elements(); ++j) {
    if (!free[j]) continue;
    const int last = static_cast<int>(max_delays[j] / sample_time);
    const int stride = std::max(1, (last + max_points - 1) / max_points);
    const int offset =
        static_cast<int>(std::lround(start.values[j].delay / sample_time)) %
        stride;
    for (int d = offset; d <= last; d += stride) delays[j].push_back(d);
    if (delays[j].empty()) delays[j].push_back(0);
    elements.push_back(j);
    all_delays.insert(all_delays.end(), delays[j].begin(), delays[j].end());
    const int nearest = std::clamp(
        static_cast<int>(std::lround(start.values[j].delay / sample_time)) /
            stride,
        0, static_cast<int>(delays[j].size()) - 1);
    chosen.push_back(begins.back() + nearest);
    begins.push_back(static_cast<int>(all_delays.size()));
  }

  const MatrixXd dictionary = problem.Dictionary(start, shape, delays);
  const Eigen::Index width = dictionary.cols() - 1;
  Combinations combinations;
  combinations.norms =
      dictionary.leftCols(width).colwise().norm().cwiseMax(1e-300);
  const MatrixXd unit = dictionary.leftCols(width) *
                        combinations.norms.cwiseInverse().asDiagonal();
  combinations.gram = MatrixXd::Zero(width, width);
  combinations.gram.selfadjointView<Eigen::Lower>().rankUpdate(
      unit.transpose());
  combinations.gram =
      MatrixXd(combinations.gram.selfadjointView<Eigen::Lower>());
  combinations.products = unit.transpose() * dictionary.col(width);

  double explained = combinations.Explained(chosen);
  const int count = static_cast<int>(elements.size());
  for (bool improved = true; improved;) {
    improved = false;
    for (int a = 0; a < std::max(1, count - 1); ++a) {
      for (int b = std::min(a + 1, count - 1); b < count; ++b) {
        improved |= ImprovePair(combinations, begins, a, b, chosen, explained);
      }
    }
    if (count <= 2) break;
  }

  DelaySearchResult result;
  result.point = start;
  const VectorXd gains = combinations.ScaledGains(chosen);
  for (int a = 0; a < count; ++a) {
    ElementValues& values = result.point.values[elements[a]];
    values.gain = gains(a) / combinations.norms(chosen[a]);
    values.delay = all_delays[chosen[a]] * sample_time;
  }
  result.point.SetCells(sample_time);
  const double squares = dictionary.col(width).squaredNorm();
  result.cost = 0.5 * (squares - explained);
  result.cost_accuracy = kRidge * squares;
  return result;
}

}  // namespace mle
