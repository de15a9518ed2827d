#include "mle/correction/prediction_residuals.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "glog/logging.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A_lᵀ of l = d … 1, one below the other (dp × p).
MatrixXd StackFeedback(const MatrixXd& R, Index channels) {
  const Index p = R.rows();
  const Index order = R.cols() / channels;
  MatrixXd stack(order * p, p);
  for (Index lag = 1; lag <= order; ++lag) {
    stack.middleRows((order - lag) * p, p) =
        R.middleCols((lag - 1) * channels, p).transpose();
  }
  return stack;
}

// e from r, both rows × p, latest first.
void Propagate(const MatrixXd& R, Index channels, Index horizon,
               MatrixXd& residuals) {
  const Index rows = residuals.rows();
  const Index p = residuals.cols();
  if (horizon == 0 || horizon > rows) horizon = rows;
  if (horizon <= 1) return;
  const MatrixXd stack = StackFeedback(R, channels);
  const Index order = stack.rows() / p;
  // A row for each start, a block of p columns for each step after it: starts
  // are independent, and go through the recursion together.
  const Index starts = (rows + horizon - 1) / horizon;
  MatrixXd steps = MatrixXd::Zero(starts, horizon * p);
  for (Index k = 0; k < rows; ++k) {
    steps.row(k / horizon).segment(k % horizon * p, p) =
        residuals.row(rows - 1 - k);
  }
  for (Index step = 1; step < horizon; ++step) {
    const Index past = std::min(step, order);
    steps.middleCols(step * p, p).noalias() +=
        steps.middleCols((step - past) * p, past * p) *
        stack.bottomRows(past * p);
  }
  for (Index k = 0; k < rows; ++k) {
    residuals.row(rows - 1 - k) =
        steps.row(k / horizon).segment(k % horizon * p, p);
  }
}

}  // namespace

MatrixXd PredictionResiduals(const LaggedSeries& series, RowRange rows,
                             const MatrixXd& R, int horizon) {
  CHECK_EQ(R.cols(), series.num_regressors());
  CHECK_GE(horizon, 0);
  MatrixXd residuals = series.Outputs(rows).transpose();
  residuals.noalias() -= series.Regressors(rows).transpose() * R.transpose();
  Propagate(R, series.num_channels(), horizon, residuals);
  residuals.rowwise() -= residuals.colwise().mean().eval();
  return residuals.transpose();
}

AheadLosses::AheadLosses(const RegressionData& data, const Fold& fold,
                         int horizon)
    : data_(data), horizon_(horizon) {
  CHECK_GE(horizon, 0);
  for (int i = 0; i < data.num_windows(); ++i) {
    for (const RegressionRows& rows : data.window(i)) {
      Run run;
      run.rows = &rows;
      for (const RegressionRows& block : fold) {
        if (block.series != rows.series || block.rows.first < rows.rows.first ||
            block.rows.last > rows.rows.last) {
          continue;
        }
        run.parts.push_back(block.rows);
        rows_ += block.rows.rows();
      }
      if (run.parts.empty()) continue;
      run.channels = rows.series
                         ->Samples({rows.rows.first - rows.series->order(),
                                    rows.rows.last})
                         .transpose();
      runs_.push_back(std::move(run));
    }
  }
}

MatrixXd AheadLosses::OneStep(const Run& run, const MatrixXd& first,
                              const MatrixXd* second) const {
  const Index rows = run.rows->rows.rows();
  const Index p = first.rows();
  const Index channels = run.channels.cols();
  MatrixXd residuals(rows, 2 * p);
  residuals << run.rows->responses.transpose(), run.rows->responses.transpose();
  std::vector<int> lags;
  std::vector<double> a;
  std::vector<double> b;
  for (Index i = 0; i < p; ++i) {
    for (Index channel = 0; channel < channels; ++channel) {
      lags.clear();
      a.clear();
      b.clear();
      for (Index column = channel; column < first.cols(); column += channels) {
        const double x = first(i, column);
        const double y = second != nullptr ? (*second)(i, column) : 0.0;
        if (x == 0.0 && y == 0.0) continue;
        lags.push_back(static_cast<int>(column / channels) + 1);
        a.push_back(-x);
        b.push_back(-y);
      }
      // The values at lag l begin l behind those of the rows.
      VectorKernels().multiply_columns(
          {run.channels.col(channel).data(), 1, lags.data(),
           static_cast<std::ptrdiff_t>(lags.size())},
          a.data(), b.data(), rows, residuals.col(i).data(),
          residuals.col(p + i).data());
    }
  }
  return residuals;
}

void AheadLosses::AddSquares(const Run& run, const MatrixXd& R,
                             MatrixXd residuals,
                             Eigen::Ref<VectorXd> squares) const {
  Propagate(R, run.channels.cols(), horizon_, residuals);
  residuals.rowwise() -= residuals.colwise().mean().eval();
  for (const RowRange& part : run.parts) {
    squares +=
        residuals.middleRows(run.rows->rows.last - part.last, part.rows())
            .colwise()
            .squaredNorm()
            .transpose();
  }
}

MatrixXd AheadLosses::Of(absl::Span<const MatrixXd> changes) const {
  const MatrixXd& R = data_.model_R();
  const Index p = R.rows();
  MatrixXd squares = MatrixXd::Zero(p, static_cast<Index>(changes.size()));
  for (const Run& run : runs_) {
    for (std::size_t n = 0; n < changes.size(); n += 2) {
      const bool pair = n + 1 < changes.size();
      const MatrixXd residuals =
          OneStep(run, changes[n], pair ? &changes[n + 1] : nullptr);
      for (std::size_t k = 0; k < (pair ? 2U : 1U); ++k) {
        AddSquares(run, R + changes[n + k],
                   residuals.middleCols(static_cast<Index>(k) * p, p),
                   squares.col(static_cast<Index>(n + k)));
      }
    }
  }
  // An unstable model runs away, until nothing is a number any more.
  return squares.array().isFinite().select(
      0.5 / rows_ * squares.array(), std::numeric_limits<double>::infinity());
}

}  // namespace mle
