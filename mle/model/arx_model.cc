#include "mle/model/arx_model.h"

#include <algorithm>
#include <vector>

#include "glog/logging.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr double kSaturation = 1e100;
// Samples computed together: what lies at least this far back is added to all
// of them at once.
constexpr int kBlock = 8;
using Block = Eigen::Array<double, kBlock, 1>;

// A non-zero coefficient of an output's past, for a history whose columns hold
// the samples of one pair each: `offset` leads from the entry that is computed
// to the one that the coefficient multiplies.
struct OutputTerm {
  Eigen::Index offset;
  double coefficient;
};

double Saturated(double value) {
  if (value > -kSaturation && value < kSaturation) return value;
  return value <= -kSaturation ? -kSaturation : kSaturation;
}

// Terms of row `output` of R with lag in [first_lag, last_lag].
void AppendTerms(const ArxModel& model, int output, int first_lag, int last_lag,
                 Eigen::Index rows, std::vector<OutputTerm>& terms) {
  const int m = model.num_inputs;
  for (int a = first_lag; a <= last_lag; ++a) {
    for (int c = 0; c < model.num_outputs; ++c) {
      const double value = model.R(output, (a - 1) * model.num_channels() + c);
      if (value != 0.0) terms.push_back({(c - output) * m * rows - a, value});
    }
  }
}

double SumOfTerms(const OutputTerm* begin, const OutputTerm* end,
                  const double* entry) {
  double sum = 0.0;
  for (const OutputTerm* term = begin; term != end; ++term) {
    sum += term->coefficient * entry[term->offset];
  }
  return sum;
}

// Adds the terms to kBlock entries from `entry` on.
void AddTermsToBlock(const OutputTerm* begin, const OutputTerm* end,
                     double* entry) {
  Eigen::Map<Block> block(entry);
  Block sum = block;
  for (const OutputTerm* term = begin; term != end; ++term) {
    sum += term->coefficient * Eigen::Map<const Block>(entry + term->offset);
  }
  block = sum;
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
  MLE_RETURN_IF_ERROR(
      ValidateSampleTime("ARX model: sample_time", sample_time));
  if (order < 1 || num_outputs < 1 || num_inputs < 1) {
    return InvalidArgument("ARX model: order is ", order, ", num_outputs ",
                           num_outputs, ", num_inputs ", num_inputs,
                           "; each must be at least 1");
  }
  if (R.rows() != num_outputs ||
      R.cols() != static_cast<Eigen::Index>(order) * num_channels()) {
    return InvalidArgument("ARX model: R is ", R.rows(), " × ", R.cols(),
                           ", must be ", num_outputs, " × ",
                           static_cast<Eigen::Index>(order) * num_channels());
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

  // Row `first_row` + k holds sample k; zeros before it, room for a whole last
  // block after it.
  const int first_row = std::max(order, kBlock);
  const int rows = first_row + samples + kBlock;
  Eigen::MatrixXd history = Eigen::MatrixXd::Zero(rows, p * m);
  FillInputPart(*this, first_row, samples, history);

  // Row i has the terms far[i] … near[i] that reach back behind a block, then
  // up to far[i+1] those that may reach into it.
  std::vector<OutputTerm> terms;
  terms.reserve(static_cast<std::size_t>(p) * p * order);
  std::vector<const OutputTerm*> far(p + 1, terms.data());
  std::vector<const OutputTerm*> near(p, terms.data());
  for (int i = 0; i < p; ++i) {
    AppendTerms(*this, i, kBlock, order, rows, terms);
    near[i] = terms.data() + terms.size();
    AppendTerms(*this, i, 1, std::min(order, kBlock - 1), rows, terms);
    far[i + 1] = terms.data() + terms.size();
  }

  for (int begin = 1; begin < samples; begin += kBlock) {
    for (int i = 0; i < p; ++i) {
      for (int j = 0; j < m; ++j) {
        AddTermsToBlock(far[i], near[i],
                        &history(first_row + begin, i * m + j));
      }
    }
    const int end = std::min(begin + kBlock, samples);
    for (int k = begin; k < end; ++k) {
      for (int i = 0; i < p; ++i) {
        for (int j = 0; j < m; ++j) {
          double& y = history(first_row + k, i * m + j);
          y = Saturated(y + SumOfTerms(near[i], far[i + 1], &y));
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
