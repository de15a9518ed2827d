#include "mle/data/model_residual.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mle/data/line.h"

namespace mle {
namespace {

constexpr double kMaxProducts = 1e8;

struct Move {
  int sample = 0;
  double size = 0.0;
};

// Moves of an input from `begin` to `last`.
std::vector<Move> MovesOfInput(const Record& record, int input, int begin,
                               int last) {
  std::vector<Move> moves;
  double held = std::numeric_limits<double>::quiet_NaN();
  for (int k = begin; k <= last; ++k) {
    const double value = record.inputs(input, k);
    if (!std::isfinite(value)) continue;
    if (std::isfinite(held) && value != held) {
      moves.push_back({k - begin, value - held});
    }
    held = value;
  }
  return moves;
}

}  // namespace

Eigen::MatrixXd ModelResidual(const Record& record, const ProcessModel& model,
                              int first, int last, int settling) {
  const int begin = std::max(0, first - settling);
  const int length = last - begin + 1;
  Eigen::MatrixXd residual = record.outputs.middleCols(begin, length);
  const int responses = std::min(settling + 2, length);
  for (int j = 0; j < model.num_inputs(); ++j) {
    const std::vector<Move> moves = MovesOfInput(record, j, begin, last);
    const double products = static_cast<double>(moves.size()) * responses;
    if (moves.empty() || products > kMaxProducts) continue;
    for (int i = 0; i < model.num_outputs(); ++i) {
      if (model.element(i, j).IsZero()) continue;
      const Eigen::VectorXd step =
          model.element(i, j).StepResponse(record.sample_time, responses);
      Eigen::VectorXd response = Eigen::VectorXd::Zero(length);
      Eigen::VectorXd settled = Eigen::VectorXd::Zero(length);
      Eigen::VectorXd sloping = Eigen::VectorXd::Zero(length);
      const double slope =
          model.element(i, j).IsIntegrating()
              ? model.element(i, j).StaticGain() * record.sample_time
              : 0.0;
      for (const Move& move : moves) {
        const int count = std::min(responses, length - move.sample);
        response.segment(move.sample, count) += move.size * step.head(count);
        if (move.sample + count < length) {
          settled(move.sample + count) += move.size * step(responses - 1);
          sloping(move.sample + count) += move.size * slope;
        }
      }
      double level = 0.0;
      double rate = 0.0;
      for (int k = 0; k < length; ++k) {
        rate += sloping(k);
        level += settled(k) + rate;
        residual(i, k) -= response(k) + level;
      }
    }
  }
  residual = residual.rightCols(last - first + 1).eval();
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (!IsIntegrating(model, i)) continue;
    residual.row(i) = WithoutLine(residual.row(i).transpose()).transpose();
  }
  return residual;
}

}  // namespace mle
