#include "mle/explain/held_out_errors.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "mle/explain/several_steps.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kBlock = 3.0;  // of τ
constexpr int kFolds = 5;

// The block of each row, counted over all records.
std::vector<int> BlocksOf(const std::vector<ResidualRow>& rows,
                          int block_rows) {
  std::vector<int> blocks(rows.size(), 0);
  const auto inside = [&](const ResidualRow& row) {
    return row.first / row.samples / block_rows;
  };
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const bool begins = rows[i].record != rows[i - 1].record ||
                        inside(rows[i]) != inside(rows[i - 1]);
    blocks[i] = blocks[i - 1] + (begins ? 1 : 0);
  }
  return blocks;
}

// Squares of the errors of both models in a block.
struct BlockSquares {
  double initial = 0.0;
  double explained = 0.0;
};

// The mean over blocks of (a − b)/(a + b), in its standard errors: blocks
// differ in what moves and disturbs them, and one must not decide for all.
// Nothing where there are fewer than two.
std::optional<double> Deviations(const std::vector<BlockSquares>& blocks) {
  double n = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (const BlockSquares& block : blocks) {
    const double both = block.initial + block.explained;
    if (!(both > 0.0)) continue;
    const double share = (block.initial - block.explained) / both;
    n += 1.0;
    sum += share;
    squares += share * share;
  }
  if (n < 2.0) return std::nullopt;
  const double mean = sum / n;
  const double variance = (squares - n * mean * mean) / (n - 1.0);
  // Exact records differ in all blocks alike.
  return mean / std::sqrt(std::max(variance, 1e-12) / n);
}

}  // namespace

std::vector<HorizonErrors> HeldOutErrors(
    const ExplainedOutput& output, const Instruments& instruments,
    const std::function<std::vector<Explanation>(const VectorXd& weights)>&
        estimate) {
  const std::vector<ResidualRow>& rows = output.rows();
  const double row_time = output.sample_time() * output.samples_a_row();
  const std::vector<int> blocks =
      BlocksOf(rows, InRows(output, kBlock * output.tau()));
  const VectorXd initial = instruments.Freed(output.Residual({}));
  std::vector<VectorXd> explained;
  for (int f = 0; f < kFolds; ++f) {
    VectorXd weights = VectorXd::Ones(initial.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (blocks[i] % kFolds == f) weights[static_cast<Index>(i)] = 0.0;
    }
    explained.push_back(instruments.Freed(output.Residual(estimate(weights))));
  }
  std::vector<HorizonErrors> errors;
  for (const double horizon :
       {kStepsAhead[0], kStepsAhead[1], kStepsAhead[2], 0.0}) {
    const int ahead =
        horizon > 0.0 ? InRows(output, horizon * output.tau()) : 0;
    std::vector<BlockSquares> squares(static_cast<std::size_t>(blocks.back()) +
                                      1);
    double before = 0.0;
    double after = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (!Reaches(rows, i, ahead)) continue;
      const auto error = [&, k = static_cast<Index>(i)](const VectorXd& e) {
        return ahead > 0 ? e[k] - e[k - ahead] : e[k];
      };
      const double a = error(initial);
      const double b =
          error(explained[static_cast<std::size_t>(blocks[i] % kFolds)]);
      before += a * a;
      after += b * b;
      BlockSquares& block = squares[static_cast<std::size_t>(blocks[i])];
      block.initial += a * a;
      block.explained += b * b;
      ++count;
    }
    const std::optional<double> deviations = Deviations(squares);
    if (!deviations.has_value()) continue;
    errors.push_back({.horizon = ahead * row_time,
                      .initial = std::sqrt(before / count),
                      .explained = std::sqrt(after / count),
                      .deviations = *deviations});
  }
  return errors;
}

}  // namespace mle
