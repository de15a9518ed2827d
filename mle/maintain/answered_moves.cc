#include "mle/maintain/answered_moves.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/QR"
#include "mle/base/status.h"
#include "mle/maintain/element_responses.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Samples looked at on each side of a move.
constexpr double kFewestBeside = 10.0;
constexpr double kMostBeside = 200.0;
// Fitted to each move: level, slope and answer.
constexpr int kParameters = 3;

// The estimate of d by one output: its weight, and d times that.
struct Answer {
  double weight = 0.0;
  double weighted = 0.0;
};

// Estimates d from residuals e at the times n since the move, and the response
// h there.
Answer AnswerOf(const std::vector<double>& times, const std::vector<double>& e,
                const std::vector<double>& h) {
  const auto rows = static_cast<Index>(times.size());
  if (rows <= kParameters) return {};
  MatrixXd level(rows, 2);
  level.col(0).setOnes();
  level.col(1) = Eigen::Map<const VectorXd>(times.data(), rows);
  // Both less their level and slope.
  const Eigen::HouseholderQR<MatrixXd> qr(level);
  const auto left = [&](const std::vector<double>& values) {
    const VectorXd all = Eigen::Map<const VectorXd>(values.data(), rows);
    return VectorXd(all - level * qr.solve(all));
  };
  const VectorXd response = left(h);
  const VectorXd residual = left(e);
  const double squares = response.squaredNorm();
  if (!(squares > 0.0)) return {};
  const double answer = response.dot(residual) / squares;
  const double variance = (residual - answer * response).squaredNorm() /
                          static_cast<double>(rows - kParameters);
  // A record without noise tells all.
  const double weight = squares / std::max(variance, 1e-12 * squares);
  return {.weight = weight, .weighted = weight * answer};
}

}  // namespace

absl::StatusOr<AnsweredMoves> AnsweredMoves::Create(const ProcessModel& model,
                                                    const Record& record) {
  AnsweredMoves moves;
  MLE_ASSIGN_OR_RETURN(
      const MatrixXd response,
      SimulateResponse(model, record.sample_time, WithoutGaps(record).inputs));
  moves.residual_ = record.outputs - response;
  const double samples =
      std::clamp(std::ceil(SettlingTime(model) / record.sample_time),
                 kFewestBeside, kMostBeside);
  moves.steps_ = model.ComputeStepResponse(record.sample_time,
                                           static_cast<int>(samples) + 1);
  return moves;
}

double AnsweredMoves::Share(int input, int sample, double size) const {
  Answer all;
  for (int i = 0; i < steps_.num_outputs; ++i) {
    const VectorXd step = steps_.element(i, input);
    if (step.isZero(0.0)) continue;
    const Index reach = step.size() - 1;
    std::vector<double> times;
    std::vector<double> residual;
    std::vector<double> response;
    for (Index n = -reach; n <= reach; ++n) {
      const Index k = sample + n;
      if (k < 0 || k >= residual_.cols()) continue;
      if (!std::isfinite(residual_(i, k))) continue;
      times.push_back(static_cast<double>(n));
      residual.push_back(residual_(i, k));
      response.push_back(n <= 0 ? 0.0 : size * (step(n) - step(n - 1)));
    }
    const Answer answer = AnswerOf(times, residual, response);
    all.weight += answer.weight;
    all.weighted += answer.weighted;
  }
  return all.weight > 0.0 ? 1.0 + all.weighted / all.weight : 0.0;
}

}  // namespace mle
