#include "mle/nonlinear/delay_search.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "mle/regression/lagged_products.h"

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
    return ScaledGains(chosen).dot(VectorXd(products(chosen)));
  }
};

// Columns without what those of other elements explain of them and of y.
class Conditional {
 public:
  Conditional(const Combinations& combinations, const std::vector<int>& others,
              int first, int count)
      : gram_(combinations.gram.middleCols(first, count)),
        products_(combinations.products.segment(first, count)),
        squares_(VectorXd::Constant(count, 1.0 + kRidge)),
        shares_(others.size(), count) {
    if (others.empty()) return;
    const Eigen::LLT<MatrixXd> llt(
        combinations.gram(others, others) +
        kRidge * MatrixXd::Identity(shares_.rows(), shares_.rows()));
    shares_ = llt.matrixL().solve(MatrixXd(gram_(others, Eigen::all)));
    const VectorXd explained =
        llt.matrixL().solve(VectorXd(combinations.products(others)));
    products_ -= shares_.transpose() * explained;
    squares_ -= shares_.colwise().squaredNorm();
    explained_ = explained.squaredNorm();
  }

  double explained() const { return explained_; }  // by the others
  double product(int i) const { return products_(i); }
  double square(int i) const { return squares_(i); }
  // With all columns of `other`, which begin at `first`.
  MatrixXd Products(const Conditional& other, int first) const {
    return gram_.middleRows(first, other.products_.size()).transpose() -
           shares_.transpose() * other.shares_;
  }

 private:
  MatrixXd gram_;
  VectorXd products_;  // with y
  VectorXd squares_;
  MatrixXd shares_;
  double explained_ = 0.0;
};

// Elements a and b (columns begins[a] … begins[a+1]−1) over all combinations,
// the others held; true if that improves.
bool ImprovePair(const Combinations& combinations,
                 const std::vector<int>& begins, int a, int b,
                 std::vector<int>& chosen, double& explained) {
  std::vector<int> others;
  for (int c = 0; c < static_cast<int>(chosen.size()); ++c) {
    if (c != a && c != b) others.push_back(chosen[c]);
  }
  const int count_a = begins[a + 1] - begins[a];
  const int count_b = begins[b + 1] - begins[b];
  const Conditional left(combinations, others, begins[a], count_a);
  const Conditional right(combinations, others, begins[b], count_b);
  const MatrixXd cross = left.Products(right, begins[b]);
  const double least = explained * (1.0 + 1e-12);
  double best = least;
  for (int i = 0; i < count_a; ++i) {
    const double p = left.product(i);
    for (int k = 0; k < count_b; ++k) {
      const double q = right.product(k);
      const double c = cross(i, k);
      const double determinant = left.square(i) * right.square(k) - c * c;
      const double value =
          left.explained() +
          (p * p * right.square(k) - 2.0 * c * p * q + q * q * left.square(i)) /
              determinant;
      if (!(determinant > 0.0) || !(value > best)) continue;
      best = value;
      chosen[a] = begins[a] + i;
      chosen[b] = begins[b] + k;
    }
  }
  if (!(best > least)) return false;
  explained = best;
  return true;
}

// The same of a single element.
double ChooseBest(const Combinations& combinations, std::vector<int>& chosen) {
  Eigen::Index best = 0;
  const double product = combinations.products.cwiseAbs().maxCoeff(&best);
  chosen[0] = static_cast<int>(best);
  return product * product / (1.0 + kRidge);
}

// The dead times that are tried, in samples, and where they begin.
struct Candidates {
  std::vector<std::vector<int>> delays;  // of each element
  std::vector<int> elements;             // the free ones
  std::vector<int> begins = {0};         // of their columns
  std::vector<int> all_delays;           // of the columns
  std::vector<int> nearest;  // of each free element: the column of the start
};

Candidates MakeCandidates(const OutputErrorProblem& problem,
                          const OutputPoint& start,
                          const std::vector<bool>& free,
                          const std::vector<double>& max_delays,
                          const DelayGrid& grid) {
  Candidates candidates;
  candidates.delays.resize(problem.num_elements());
  for (int j = 0; j < problem.num_elements(); ++j) {
    if (!free[j]) continue;
    const int last = static_cast<int>(max_delays[j] / problem.sample_time());
    const double apart =
        std::min(grid.share * problem.elements()[j]->shortest_time() *
                     start.values[j].time_scale / problem.sample_time(),
                 static_cast<double>(last));
    const int stride =
        std::max({1, (last + grid.max_points - 1) / grid.max_points,
                  static_cast<int>(apart)});
    const int at = static_cast<int>(
        std::lround(start.values[j].delay / problem.sample_time()));
    std::vector<int>& delays = candidates.delays[j];
    for (int d = at % stride; d <= last; d += stride) delays.push_back(d);
    if (delays.empty()) delays.push_back(0);
    candidates.elements.push_back(j);
    candidates.all_delays.insert(candidates.all_delays.end(), delays.begin(),
                                 delays.end());
    candidates.nearest.push_back(
        candidates.begins.back() +
        std::clamp(at / stride, 0, static_cast<int>(delays.size()) - 1));
    candidates.begins.push_back(static_cast<int>(candidates.all_delays.size()));
  }
  return candidates;
}

// `dictionary`: the responses, then y.
Combinations MakeCombinations(const MatrixXd& dictionary) {
  const Eigen::Index width = dictionary.cols() - 1;
  Combinations combinations;
  combinations.norms =
      dictionary.leftCols(width).colwise().norm().cwiseMax(1e-300);
  const MatrixXd unit = dictionary.leftCols(width) *
                        combinations.norms.cwiseInverse().asDiagonal();
  combinations.gram = GramMatrix(unit);
  combinations.products = unit.transpose() * dictionary.col(width);
  return combinations;
}

// Pair by pair until no pair improves; returns the squares explained.
double Improve(const Combinations& combinations, const std::vector<int>& begins,
               std::vector<int>& chosen) {
  const int count = static_cast<int>(chosen.size());
  if (count == 1) return ChooseBest(combinations, chosen);
  double explained = combinations.Explained(chosen);
  for (bool improved = count > 1; improved;) {
    improved = false;
    for (int a = 0; a + 1 < count; ++a) {
      for (int b = a + 1; b < count; ++b) {
        improved |= ImprovePair(combinations, begins, a, b, chosen, explained);
      }
    }
    if (count == 2) break;
  }
  return explained;
}

}  // namespace

DelaySearchResult SearchDelays(const OutputErrorProblem& problem,
                               const OutputPoint& start,
                               const NoiseShape& shape,
                               const std::vector<bool>& free,
                               const std::vector<double>& max_delays,
                               const DelayGrid& grid) {
  const Candidates candidates =
      MakeCandidates(problem, start, free, max_delays, grid);
  const MatrixXd dictionary =
      problem.Dictionary(start, shape, candidates.delays);
  const Combinations combinations = MakeCombinations(dictionary);
  std::vector<int> chosen = candidates.nearest;
  const double explained = Improve(combinations, candidates.begins, chosen);

  DelaySearchResult result;
  result.point = start;
  const VectorXd gains = combinations.ScaledGains(chosen);
  for (std::size_t a = 0; a < chosen.size(); ++a) {
    ElementValues& values = result.point.values[candidates.elements[a]];
    values.gain =
        gains(static_cast<Eigen::Index>(a)) / combinations.norms(chosen[a]);
    values.delay = candidates.all_delays[chosen[a]] * problem.sample_time();
  }
  result.point.SetCells(problem.sample_time());
  const double squares = dictionary.col(dictionary.cols() - 1).squaredNorm();
  result.cost = 0.5 * (squares - explained);
  result.cost_accuracy = kRidge * squares;
  return result;
}

}  // namespace mle
