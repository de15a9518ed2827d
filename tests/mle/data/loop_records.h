// Records of a plant of two inputs and two outputs as control makes them, and
// what historians do to them.

#ifndef TESTS_MLE_DATA_LOOP_RECORDS_H_
#define TESTS_MLE_DATA_LOOP_RECORDS_H_

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "Eigen/Core"
#include "Eigen/LU"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"

namespace mle::testing {

inline ProcessModel LoopModel() {
  ProcessModel model("loop", "min", {{"u1", "%"}, {"u2", "%"}},
                     {{"y1", "K"}, {"y2", "K"}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 15.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-1.0, 20.0, 3.0);
  model.element(1, 0) = TransferFunction::FirstOrder(0.8, 10.0, 5.0);
  model.element(1, 1) = TransferFunction::FirstOrder(-3.0, 12.0, 2.0);
  return model;
}

struct LoopOptions {
  int samples = 4000;
  double noise = 0.02;
  // Standard deviation of an output's random walk, for each sample.
  double walk = 0.0;
  // Standard deviation of an output's first-order coloured disturbance, and its
  // factor from sample to sample.
  double coloured = 0.0;
  double memory = 0.9;
  int period = 5;  // of the controller, in samples
  unsigned seed = 1;
  // Between the inputs recorded and those that act on the plant.
  Eigen::Vector2d play = Eigen::Vector2d::Zero();
};

// Integral control of the plant by the inverse of its gains, so slow that it is
// stable for plants that have aged; the set points change by turns every 500
// samples of 0.25 min.
inline Record LoopRecord(const ProcessModel& plant, const LoopOptions& options,
                         const Eigen::Matrix2d& controller_gains) {
  constexpr double kSampleTime = 0.25;
  constexpr double kResetTime = 60.0;
  std::mt19937_64 engine(options.seed);
  std::normal_distribution<double> normal;
  std::mt19937_64 coloured_engine(options.seed + 1000000);
  ProcessSimulator simulator = *ProcessSimulator::Create(plant, kSampleTime);
  const Eigen::Matrix2d inverse = controller_gains.inverse();
  Record record;
  record.sample_time = kSampleTime;
  record.outputs.resize(2, options.samples);
  record.inputs.resize(2, options.samples);
  record.set_points = Eigen::MatrixXd::Zero(2, options.samples);
  Eigen::Vector2d integral = Eigen::Vector2d::Zero();
  Eigen::Vector2d input = Eigen::Vector2d::Zero();
  Eigen::Vector2d walk = Eigen::Vector2d::Zero();
  Eigen::Vector2d coloured = Eigen::Vector2d::Zero();
  Eigen::Vector2d valve = Eigen::Vector2d::Zero();
  const double fresh =
      options.coloured * std::sqrt(1.0 - options.memory * options.memory);
  for (int k = 0; k < options.samples; ++k) {
    const int part = k / 500;
    const Eigen::Vector2d set_point((part + 1) / 2 % 2, part / 2 % 2);
    for (int i = 0; i < 2; ++i) {
      walk(i) += options.walk * normal(engine);
      record.outputs(i, k) =
          simulator.outputs()(i) + walk(i) + options.noise * normal(engine);
      if (options.coloured > 0.0) {
        coloured(i) =
            options.memory * coloured(i) + fresh * normal(coloured_engine);
        record.outputs(i, k) += coloured(i);
      }
    }
    if (k % options.period == 0) {
      const Eigen::Vector2d error = set_point - record.outputs.col(k);
      integral += error * (options.period * kSampleTime / kResetTime);
      input = inverse * (0.3 * error + 2.0 * integral);
    }
    record.set_points.col(k) = set_point;
    record.inputs.col(k) = input;
    valve = valve.cwiseMax(input - options.play / 2.0)
                .cwiseMin(input + options.play / 2.0);
    simulator.Advance(valve);
  }
  return record;
}

inline Record LoopRecord(const LoopOptions& options = {}) {
  return LoopRecord(LoopModel(), options, StaticGains(LoopModel()));
}

inline void Quantise(double quantum, Eigen::Ref<Eigen::MatrixXd> samples) {
  samples = (samples / quantum).array().round() * quantum;
}

// Bristol's swinging door: a sample is archived once no line from the archived
// one before keeps within `deviation` of all samples between; the samples
// between are interpolated.
inline int Compress(double deviation, Eigen::Ref<Eigen::RowVectorXd> row) {
  const auto n = static_cast<int>(row.size());
  int archived = 0;
  int count = 1;
  double low = -std::numeric_limits<double>::infinity();
  double high = -low;
  const auto interpolate = [&](int from, int to) {
    const double start = row(from);
    const double slope = (row(to) - start) / (to - from);
    for (int k = from + 1; k < to; ++k) row(k) = start + slope * (k - from);
    archived = to;
    ++count;
    low = -std::numeric_limits<double>::infinity();
    high = -low;
  };
  for (int k = 1; k < n; ++k) {
    for (int again = 0; again < 2; ++again) {
      const double new_low =
          std::max(low, (row(k) - deviation - row(archived)) / (k - archived));
      const double new_high =
          std::min(high, (row(k) + deviation - row(archived)) / (k - archived));
      if (new_low <= new_high || k - archived < 2) {
        low = new_low;
        high = new_high;
        break;
      }
      interpolate(archived, k - 1);
    }
  }
  if (n - 1 > archived) interpolate(archived, n - 1);
  return count;
}

// Exception reporting: a value is held until one differs by `deviation`.
inline int Hold(double deviation, Eigen::Ref<Eigen::RowVectorXd> row) {
  int count = 1;
  for (Eigen::Index k = 1; k < row.size(); ++k) {
    if (std::abs(row(k) - row(k - 1)) < deviation) {
      row(k) = row(k - 1);
    } else {
      ++count;
    }
  }
  return count;
}

}  // namespace mle::testing

#endif  // TESTS_MLE_DATA_LOOP_RECORDS_H_
