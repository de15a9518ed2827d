#include "mle/maintain/exchanged_set_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Eigen/Core"

namespace mle {
namespace {

constexpr int kLeastSettledSamples = 10;  // between changes
constexpr int kLeastParts = 3;
constexpr double kRatio = 10.0;

// Where outputs came to, and their set points, between changes.
struct Settled {
  std::vector<Eigen::VectorXd> outputs;     // p
  std::vector<Eigen::VectorXd> set_points;  // p
};

double MeanOf(const Eigen::VectorXd& values) {
  double sum = 0.0;
  double count = 0.0;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    sum += value;
    count += 1.0;
  }
  return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

// Ends of the segments in which no set point moves.
std::vector<int> EndsOf(const Record& record) {
  std::vector<int> ends;
  for (const SetPointChange& change : FindSetPointChanges(record)) {
    if (ends.empty() || change.sample > ends.back()) {
      ends.push_back(change.sample);
    }
  }
  ends.push_back(record.samples());
  return ends;
}

Settled FindSettled(const std::vector<Record>& records) {
  Settled settled;
  for (const Record& record : records) {
    if (record.set_points.rows() != record.num_outputs()) continue;
    int first = 0;
    for (const int end : EndsOf(record)) {
      const int length = end - first;
      const int last = std::max(length / 3, 1);
      if (length >= kLeastSettledSamples) {
        settled.outputs.emplace_back(record.num_outputs());
        settled.set_points.push_back(record.set_points.col(end - 1));
        for (int i = 0; i < record.num_outputs(); ++i) {
          settled.outputs.back()(i) = MeanOf(
              record.outputs.row(i).segment(end - last, last).transpose());
        }
      }
      first = end;
    }
  }
  return settled;
}

// Squares of the distances of output i from a constant plus set point j, or
// plus nothing (j < 0).
double SettledSquares(const Settled& settled, int i, int j) {
  const auto n = static_cast<Eigen::Index>(settled.outputs.size());
  Eigen::VectorXd distances(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    distances(k) =
        settled.outputs[k](i) - (j < 0 ? 0.0 : settled.set_points[k](j));
  }
  return (distances.array() - distances.mean()).square().sum();
}

// How much better output i is explained by set point j than by its own or none.
double RatioOf(const Settled& settled, int i, int j) {
  const double other = SettledSquares(settled, i, j);
  const double rival =
      std::min(SettledSquares(settled, i, i), SettledSquares(settled, i, -1));
  return rival > 0.0 && std::isfinite(rival)
             ? rival / std::max(other, 1e-12 * rival)
             : 0.0;
}

}  // namespace

std::vector<ExchangedSetPoints> FindExchangedSetPoints(
    const std::vector<Record>& records) {
  std::vector<ExchangedSetPoints> all;
  const Settled settled = FindSettled(records);
  if (settled.outputs.size() < kLeastParts) return all;
  const auto p = static_cast<int>(settled.outputs.front().size());
  std::vector<bool> taken(p);
  for (int i = 0; i < p; ++i) {
    for (int j = i + 1; j < p && !taken[i]; ++j) {
      if (taken[j]) continue;
      const double ratio =
          std::min(RatioOf(settled, i, j), RatioOf(settled, j, i));
      if (!(ratio > kRatio)) continue;
      all.push_back({i, j, ratio});
      taken[i] = true;
      taken[j] = true;
    }
  }
  return all;
}

}  // namespace mle
