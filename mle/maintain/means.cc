#include "mle/maintain/means.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "mle/base/double_limits.h"
#include "mle/data/sampling.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd Twice(const MatrixXd& rows) {
  MatrixXd twice(rows.rows(), 2 * rows.cols());
  for (Index k = 0; k < twice.cols(); ++k) twice.col(k) = rows.col(k / 2);
  return twice;
}

void HalveSampleTime(Record& record) {
  record.sample_time *= 0.5;
  record.inputs = Twice(record.inputs);
  if (record.set_points.size() > 0) {
    record.set_points = Twice(record.set_points);
  }
  record.outputs = Twice(record.outputs);
  for (Index k = 0; k < record.outputs.cols(); k += 2) {
    record.outputs.col(k).setConstant(kNaN);
  }
}

// What an output leaves, and what explanations cost, in M: by its own, or by
// those that the other competition has found.
double CostOf(const Competition& competition, const Competition& other,
              int output, double unit) {
  const double required = competition.outputs()[output].required;
  double least = kInfinity;
  for (const Competition* const found : {&competition, &other}) {
    std::vector<Explanation> explanations;
    for (const TakenExplanation& one : found->outputs()[output].taken) {
      explanations.push_back(one.explanation);
    }
    const double cost = competition.EnergyWith(output, explanations) / unit +
                        required * static_cast<double>(explanations.size());
    least = std::min(least, cost);
  }
  return least;
}

}  // namespace

bool MayBeMeans(const RecordData& data) {
  if (data.report.averaged || data.records.empty()) return false;
  if (std::any_of(data.sampling.begin(), data.sampling.end(),
                  [](const Sampling& one) { return !(one == Sampling()); })) {
    return false;
  }
  for (int i = 0; i < data.records.front().num_outputs(); ++i) {
    if (MeasuredEvery(data.records, i) != 1) return false;
  }
  return true;
}

RecordData AsMeans(RecordData data) {
  Sampling sampling;
  sampling.average = data.sample_time();
  for (Record& record : data.records) HalveSampleTime(record);
  for (SetPointWindow& window : data.windows) {
    HalveSampleTime(window.record);
    window.first_sample *= 2;
    for (SetPointChange& change : window.changes) change.sample *= 2;
  }
  for (RecordData::UnusedPart& part : data.unused) {
    part.first_sample *= 2;
    part.samples *= 2;
  }
  data.lead *= 2;
  data.report.sample_time *= 0.5;
  const auto outputs =
      static_cast<std::size_t>(data.windows.front().record.num_outputs());
  data.sampling.assign(outputs, sampling);
  return data;
}

bool AreMeans(const Competition& as_samples, const Competition& as_means) {
  double margin = 0.0;
  double required = 0.0;
  for (int i = 0; i < static_cast<int>(as_samples.outputs().size()); ++i) {
    const OutputExplanation& samples = as_samples.outputs()[i];
    const OutputExplanation& means = as_means.outputs()[i];
    if (!samples.judged() || !means.judged() || !samples.by_set_points) {
      continue;
    }
    // What is not explained adds to what seems to be chance.
    const double unit = std::min(samples.unit, means.unit);
    margin += CostOf(as_samples, as_means, i, unit) -
              CostOf(as_means, as_samples, i, unit);
    required = std::max(required, samples.required);
  }
  return required > 0.0 && margin > required;
}

}  // namespace mle
