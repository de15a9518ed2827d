#include "mle/data/lagged_series.h"

#include "glog/logging.h"

namespace mle {

LaggedSeries::LaggedSeries(const Record& record, int order,
                           const Eigen::VectorXd& offset)
    : order_(order), num_outputs_(record.num_outputs()) {
  CHECK_GE(order, 1);
  const int channels = record.num_outputs() + record.num_inputs();
  samples_.resize(channels, record.samples());
  samples_.topRows(num_outputs_) = record.outputs.rowwise().reverse();
  samples_.bottomRows(record.num_inputs()) = record.inputs.rowwise().reverse();
  if (offset.size() > 0) {
    CHECK_EQ(offset.size(), channels);
    samples_.colwise() -= offset;
  }
}

std::vector<RowRange> LaggedSeries::UsableRows() const {
  std::vector<RowRange> ranges;
  int run = 0;  // good samples up to and including k − 1
  for (int k = 0; k < samples(); ++k) {
    const auto sample = samples_.col(samples() - 1 - k);
    // The inputs of sample k act after it and are no part of row k.
    if (run >= order_ && sample.head(num_outputs_).allFinite()) {
      if (!ranges.empty() && ranges.back().last == k - 1) {
        ranges.back().last = k;
      } else {
        ranges.push_back({k, k});
      }
    }
    run = sample.allFinite() ? run + 1 : 0;
  }
  return ranges;
}

LaggedSeries::View LaggedSeries::Regressors(RowRange rows) const {
  CHECK_GE(rows.first, order_);
  CHECK_LT(rows.last, samples());
  const int c = num_channels();
  return View(
      samples_.data() + static_cast<Eigen::Index>(c) * (samples() - rows.last),
      num_regressors(), rows.rows(), Eigen::OuterStride<>(c));
}

LaggedSeries::View LaggedSeries::Samples(RowRange rows, int lag) const {
  CHECK_GE(rows.first - lag, 0);
  CHECK_LT(rows.last - lag, samples());
  const int c = num_channels();
  return View(samples_.data() + static_cast<Eigen::Index>(c) *
                                    (samples() - 1 - rows.last + lag),
              c, rows.rows(), Eigen::OuterStride<>(c));
}

LaggedSeries::View LaggedSeries::Outputs(RowRange rows) const {
  const int c = num_channels();
  return View(Samples(rows).data(), num_outputs_, rows.rows(),
              Eigen::OuterStride<>(c));
}

Eigen::VectorXd ChannelMeans(const std::vector<Record>& records) {
  if (records.empty()) return {};
  const int p = records.front().num_outputs();
  const int m = records.front().num_inputs();
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(p + m);
  // The second pass takes the rounding of the first away, so that the mean of a
  // held channel is its value.
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(p + m);
    Eigen::VectorXd count = Eigen::VectorXd::Zero(p + m);
    const auto add = [&](const Eigen::MatrixXd& values, int first_channel) {
      const Eigen::MatrixXd deviation =
          values.colwise() - mean.segment(first_channel, values.rows());
      const auto finite = deviation.array().isFinite();
      sum.segment(first_channel, values.rows()) +=
          finite.select(deviation, 0.0).matrix().rowwise().sum();
      count.segment(first_channel, values.rows()) +=
          finite.cast<double>().matrix().rowwise().sum();
    };
    for (const Record& record : records) {
      add(record.outputs, 0);
      add(record.inputs, p);
    }
    mean += sum.cwiseQuotient(count.cwiseMax(1.0));
  }
  return mean;
}

}  // namespace mle
