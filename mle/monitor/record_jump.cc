#include "mle/monitor/record_jump.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mle/base/status.h"
#include "mle/maintain/element_responses.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr double kDeviations = 8.0;
constexpr int kBeside = 5;       // samples on either side
constexpr int kLongestGap = 60;  // samples that a jump may hide in
constexpr double kOfNormal = 1.4826;

double Median(std::vector<double> values) {
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// A channel's known samples and where they stand.
struct KnownSamples {
  std::vector<int> at;
  std::vector<double> values;

  explicit KnownSamples(const Eigen::RowVectorXd& row) {
    for (int k = 0; k < row.size(); ++k) {
      if (!std::isfinite(row(k))) continue;
      at.push_back(k);
      values.push_back(row(k));
    }
  }
  // Standard deviation of the noise, from differences.
  double Deviation() const {
    std::vector<double> steps;
    for (std::size_t n = 1; n < values.size(); ++n) {
      steps.push_back(std::abs(values[n] - values[n - 1]));
    }
    return steps.empty() ? 0.0 : kOfNormal * Median(steps) / std::sqrt(2.0);
  }
};

// Marks the samples that a channel has jumped at.
void AddJumps(const Eigen::RowVectorXd& row, double least,
              std::vector<int>& counts) {
  const KnownSamples known(row);
  const double limit = kDeviations * std::max(known.Deviation(), least);
  const auto size = static_cast<std::ptrdiff_t>(known.values.size());
  for (std::ptrdiff_t n = kBeside; n + kBeside <= size; ++n) {
    const auto here = known.values.begin() + n;
    if (std::abs(*here - *(here - 1)) <= limit ||
        known.at[n] - known.at[n - 1] > kLongestGap) {
      continue;
    }
    const double before = Median({here - kBeside, here});
    const double after = Median({here, here + kBeside});
    if (std::abs(after - before) > limit) ++counts[known.at[n]];
  }
}

}  // namespace

absl::StatusOr<std::optional<int>> FindRecordJump(
    const ProcessModel& model, const Record& record,
    const Eigen::VectorXd& least) {
  const int p = record.num_outputs();
  std::vector<int> jumps(static_cast<std::size_t>(record.samples()), 0);
  if (jumps.empty()) return std::nullopt;
  Eigen::MatrixXd inputs = WithoutGaps(record).inputs;
  inputs.colwise() -= Eigen::VectorXd(inputs.col(0));
  MLE_ASSIGN_OR_RETURN(const Eigen::MatrixXd response,
                       SimulateResponse(model, record.sample_time, inputs));
  for (int i = 0; i < p; ++i) {
    AddJumps(record.outputs.row(i) - response.row(i), least(i), jumps);
  }
  const int needed = p <= 2 ? p : std::max(2, (p + 1) / 2);
  for (int k = 1; k < record.samples(); ++k) {
    if (jumps[k] < needed) continue;
    if (p > 1 || inputs.col(k) != inputs.col(k - 1)) return k;
  }
  return std::nullopt;
}

}  // namespace mle
