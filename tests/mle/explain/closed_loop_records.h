// Two outputs under loops of their own whose set points move, and what happens
// to plant or record, for the tests of the competition.

#ifndef TESTS_MLE_EXPLAIN_CLOSED_LOOP_RECORDS_H_
#define TESTS_MLE_EXPLAIN_CLOSED_LOOP_RECORDS_H_

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"

namespace mle {

inline ProcessModel TwoLoops() {
  ProcessModel model("two loops", "min", {{"valve", "%"}, {"heat", "%"}},
                     {{"level", "m"}, {"warmth", "K"}});
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 2.0);
  model.element(0, 1) = TransferFunction::FirstOrder(0.6, 14.0, 3.0);
  model.element(1, 0) = TransferFunction::FirstOrder(-0.9, 12.0, 4.0);
  model.element(1, 1) = TransferFunction::FirstOrder(1.5, 8.0, 1.0);
  return model;
}

struct Happening {
  // What the plant gets of an input asked for, and what is measured of an
  // output that is so far from where it began.
  std::function<double(int input, double asked)> input = [](int, double asked) {
    return asked;
  };
  std::function<double(int output, double z)> output = [](int, double z) {
    return z;
  };
  // What acts beside an input and is not recorded.
  std::function<double(int input, const Eigen::Vector2d& set_points)> load =
      [](int, const Eigen::Vector2d&) { return 0.0; };
  double noise = 0.02;
  double drift = 0.01;  // increments of a random walk, AR(1) with 0.98
  int samples = 1600;
};

// PI controllers of one output each, by the sample of a minute; set points move
// every 120 samples or so, one after the other, up and down.
inline Record CloseLoops(const ProcessModel& plant, unsigned seed,
                         const Happening& happening = {}) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const int n = happening.samples;
  Record record;
  record.sample_time = 1.0;
  record.outputs = Eigen::MatrixXd::Zero(2, n);
  record.inputs = Eigen::MatrixXd::Zero(2, n);
  record.set_points = Eigen::MatrixXd::Zero(2, n);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(2, 2);
  Eigen::Vector2d integral = Eigen::Vector2d::Zero();
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();
  Eigen::Vector2d target = Eigen::Vector2d::Zero();
  Eigen::MatrixXd got = Eigen::MatrixXd::Zero(2, n);
  for (int k = 0; k < n; ++k) {
    if (k % 120 == 60) {
      const int moved = (k / 120) % 2;
      target[moved] = target[moved] == 0.0 ? 1.0 + 0.5 * ((k / 240) % 2) : 0.0;
    }
    for (int i = 0; i < 2; ++i) {
      drift[i] = 0.98 * drift[i] + happening.drift * normal(random);
      record.outputs(i, k) = happening.output(i, state.row(i).sum()) +
                             drift[i] + happening.noise * normal(random);
      record.set_points(i, k) = target[i];
    }
    for (int j = 0; j < 2; ++j) {
      const double error = target[j] - record.outputs(j, k);
      const double gain = j == 0 ? 0.8 : 1.0;
      integral[j] += gain * error / (j == 0 ? 10.0 : 8.0);
      record.inputs(j, k) = gain * error + integral[j];
      got(j, k) =
          happening.input(j, record.inputs(j, k)) + happening.load(j, target);
    }
    // Held from this sample to the next, exactly.
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        const TransferFunction& element = plant.element(i, j);
        const int whole = static_cast<int>(element.delay());
        const double part = element.delay() - whole;
        const auto input = [&](int at) { return at < 0 ? 0.0 : got(j, at); };
        const auto kept = [&](double time) {
          return std::exp(-time / element.TimeConstant());
        };
        // The one before until `part` of the sample has passed.
        const double gain = element.StaticGain();
        const double early = kept(part) * state(i, j) +
                             (1.0 - kept(part)) * gain * input(k - whole - 1);
        state(i, j) = kept(1.0 - part) * early +
                      (1.0 - kept(1.0 - part)) * gain * input(k - whole);
      }
    }
  }
  return record;
}

}  // namespace mle

#endif  // TESTS_MLE_EXPLAIN_CLOSED_LOOP_RECORDS_H_
