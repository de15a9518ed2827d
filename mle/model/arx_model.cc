#include "mle/model/arx_model.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"

namespace mle {
namespace {

constexpr double kSaturation = 1e100;
// Samples computed together: what lies at least this far back is added to all
// of them at once.
constexpr int kBlock = 8;
using Block = Eigen::Array<double, kBlock, 1>;

// A non-zero coefficient of an output's own or another output's past.
struct OutputTerm {
  int lag;
  int output;
  double coefficient;
};

double Saturated(double value) {
  if (value > -kSaturation && value < kSaturation) return value;
  return value <= -kSaturation ? -kSaturation : kSaturation;
}

// Terms of row `output` of R with lag in [first_lag, last_lag].
void AppendTerms(const ArxModel& model, int output, int first_lag, int last_lag,
                 std::vector<OutputTerm>& terms) {
  for (int a = first_lag; a <= last_lag; ++a) {
    for (int c = 0; c < model.num_outputs; ++c) {
      const double value = model.R(output, (a - 1) * model.num_channels() + c);
      if (value != 0.0) terms.push_back({a, c, value});
    }
  }
}

// Σ_{a ≤ min(k, d)} of the coefficients of input j: what the step itself adds
// to the output at sample k. Filled in at the rows of k = 1 … samples − 1.
void FillInputPart(const ArxModel& model, int first_row, int samples,
                   Eigen::MatrixXd& history) {
  const int m = model.num_inputs;
  for (int i = 0; i < model.num_outputs; ++i) {
    for (int j = 0; j < m; ++j) {
      double sum = 0.0;
      auto column = history.col(i * m + j);
      for (int k = 1; k < samples; ++k) {
        if (k <= model.order) {
          sum += model.R(
              i, (k - 1) * model.num_channels() + model.num_outputs + j);
        }
        column(first_row + k) = sum;
      }
    }
  }
}

}  // namespace

absl::Status ArxModel::Validate() const {
  if (!(sample_time > 0.0) || !std::isfinite(sample_time)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "ARX model: sample_time is ", sample_time, ", must be positive"));
  }
  if (order < 1 || num_outputs < 1 || num_inputs < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "ARX model: order is ", order, ", num_outputs ", num_outputs,
        ", num_inputs ", num_inputs, "; each must be at least 1"));
  }
  if (R.rows() != num_outputs ||
      R.cols() != static_cast<Eigen::Index>(order) * num_channels()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "ARX model: R is ", R.rows(), " × ", R.cols(), ", must be ",
        num_outputs, " × ", static_cast<Eigen::Index>(order) * num_channels()));
  }
  if (!R.allFinite()) {
    return absl::InvalidArgumentError(
        "ARX model: R holds a coefficient that is not finite");
  }
  return absl::OkStatus();
}

StepResponse ArxModel::ComputeStepResponse(int samples) const {
  CHECK_GE(samples, 0);
  CHECK_EQ(R.rows(), num_outputs);
  CHECK_EQ(R.cols(), num_regressors());
  const int p = num_outputs;
  const int m = num_inputs;

  // Non-zero terms of all rows: those of row i from far_begin[i] on reach back
  // behind a block, those from near_begin[i] on into it.
  std::vector<OutputTerm> terms;
  terms.reserve(static_cast<std::size_t>(p) * p * order);
  std::vector<int> far_begin(p + 1);
  std::vector<int> near_begin(p + 1);
  for (int i = 0; i < p; ++i) {
    far_begin[i] = static_cast<int>(terms.size());
    AppendTerms(*this, i, kBlock, order, terms);
    near_begin[i] = static_cast<int>(terms.size());
    AppendTerms(*this, i, 1, std::min(order, kBlock - 1), terms);
  }
  far_begin[p] = static_cast<int>(terms.size());

  // Row `first_row` + k holds sample k; zeros before it, room for a whole last
  // block after it.
  const int first_row = std::max(order, kBlock);
  Eigen::MatrixXd history =
      Eigen::MatrixXd::Zero(first_row + samples + kBlock, p * m);
  FillInputPart(*this, first_row, samples, history);

  for (int begin = 1; begin < samples; begin += kBlock) {
    for (int i = 0; i < p; ++i) {
      for (int j = 0; j < m; ++j) {
        Block sum = history.col(i * m + j).segment<kBlock>(first_row + begin);
        for (int t = far_begin[i]; t < near_begin[i]; ++t) {
          const OutputTerm& term = terms[t];
          sum += term.coefficient *
                 history.col(term.output * m + j)
                     .segment<kBlock>(first_row + begin - term.lag)
                     .array();
        }
        history.col(i * m + j).segment<kBlock>(first_row + begin) = sum;
      }
    }
    const int end = std::min(begin + kBlock, samples);
    for (int k = begin; k < end; ++k) {
      for (int i = 0; i < p; ++i) {
        for (int j = 0; j < m; ++j) {
          double sum = history(first_row + k, i * m + j);
          for (int t = near_begin[i]; t < far_begin[i + 1]; ++t) {
            const OutputTerm& term = terms[t];
            sum += term.coefficient *
                   history(first_row + k - term.lag, term.output * m + j);
          }
          history(first_row + k, i * m + j) = Saturated(sum);
        }
      }
    }
  }

  StepResponse response;
  response.sample_time = sample_time;
  response.num_outputs = p;
  response.num_inputs = m;
  response.values = history.middleRows(first_row, samples);
  return response;
}

}  // namespace mle
