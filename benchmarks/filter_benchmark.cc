// filter_benchmark RUNS FIRST_SEED SAMPLES: how near filters estimated from
// records of SAMPLES samples come to the true ones, and what that is worth in a
// controller.
//
// A run has one of five published plants under mle::control::Mpc, tuned by
// published rules, with one bias filter for all outputs that is drawn at random
// (ρ from 0.01 to 10). Each output has white noise and one of: a random walk;
// steps at random times; coloured noise; the same behind a lag, as of a load at
// an input; a walk behind a lag; an oscillation. With a right model what it
// leaves of the outputs is this disturbance, whatever the controller does, so
// that it is drawn by itself. Filters are judged on 40,000 samples that they
// have not seen, by mean squared errors of predictions over the controller's
// horizon, and by
// the variance of the outputs in operation (control/expected_operation.h).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "benchmarks/tuned_plant.h"
#include "control/disturbance_observer.h"
#include "control/expected_operation.h"
#include "control/mpc.h"
#include "glog/logging.h"
#include "mle/base/parallel.h"
#include "mle/filter/bias_filter.h"
#include "mle/filter/output_filter.h"
#include "mle/filter/residual_prediction.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/ar_component.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kUnseen = 40'000;
constexpr int kForget = 2'000;

enum Family { kWalk, kSteps, kColour, kLoad, kIntegratedLoad, kOscillation };
constexpr int kFamilies = 6;
constexpr std::array<const char*, kFamilies> kFamilyNames = {
    "random walk",       "steps",      "coloured noise", "load behind a lag",
    "walk behind a lag", "oscillation"};

// What disturbs an output, and its true filter.
struct Disturbance {
  Family family = kWalk;
  NoiseEstimate noise;  // steps: of the walk with the same increments
  double steps_a_sample = 0.0;
  DisturbanceSystem system;  // every sample
};

class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double Draw() { return distribution_(engine_); }
  // Uniform in the logarithm.
  double Draw(double low, double high) {
    return low * std::exp(Draw() * std::log(high / low));
  }

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> distribution_;
};

// `lag`: of the plant, in samples.
Disturbance DrawDisturbance(double lag, Uniform& random) {
  Disturbance drawn;
  drawn.family = static_cast<Family>(
      std::min(static_cast<int>(kFamilies * random.Draw()), kFamilies - 1));
  NoiseEstimate& noise = drawn.noise;
  noise.variance = 1.0;
  noise.ratio = random.Draw(1e-6, 1e-4);
  const double size = random.Draw(0.3, 30.0);  // of its variance
  const auto colour = [&](double pole, double damping) {
    noise.ar_pole = pole;
    noise.ar_damping = damping;
    noise.ar_ratio = size / ArComponent(pole, damping).Stationary().aa;
  };
  switch (drawn.family) {
    case kWalk:
      noise.ratio = random.Draw(1e-3, 1.0);
      break;
    case kSteps:
      noise.ratio = random.Draw(1e-2, 1.0);
      drawn.steps_a_sample = random.Draw(0.005, 0.05);
      break;
    case kColour:
      colour(std::exp(-1.0 / (lag * random.Draw(0.2, 3.0))), 0.0);
      break;
    case kLoad: {
      const double memory = lag * random.Draw(0.3, 3.0);
      const double natural = std::sqrt(memory * lag);
      colour(std::exp(-1.0 / natural), 0.5 * (memory + lag) / natural);
      break;
    }
    case kIntegratedLoad:
      noise.ratio = random.Draw(1e-3, 0.3);
      break;
    case kOscillation:
      colour(std::exp(-1.0 / (lag * random.Draw(0.3, 2.0))),
             random.Draw(0.1, 0.5));
      break;
  }
  if (drawn.family != kIntegratedLoad) {
    drawn.system = SystemOf(noise, 1);
    return drawn;
  }
  drawn.system = SystemOf(noise, 1, lag);
  return drawn;
}

VectorXd DrawRecord(const Disturbance& of, int samples, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  const DisturbanceSystem& system = of.system;
  const Index n = system.order();
  VectorXd state = VectorXd::Zero(n);
  if (n > 1 && of.family != kIntegratedLoad) {
    const Eigen::MatrixXd stationary =
        StationaryCovariance(system.A.bottomRightCorner(n - 1, n - 1),
                             system.Q.bottomRightCorner(n - 1, n - 1));
    const Eigen::MatrixXd root = stationary.llt().matrixL();
    VectorXd shocks(n - 1);
    for (double& shock : shocks) shock = normal(engine);
    state.tail(n - 1) = root * shocks;
  }
  VectorXd record(samples);
  for (double& value : record) {
    value =
        system.C.dot(state) + std::sqrt(system.noise_variance) * normal(engine);
    state = (system.A * state).eval();
    for (Index i = 0; i < n; ++i) {
      const double variance = system.Q(i, i);
      if (variance == 0.0) continue;
      if (i == 0 && of.family == kSteps) {
        const double size = std::sqrt(variance / of.steps_a_sample);
        const double step = size * normal(engine);
        if (uniform(engine) < of.steps_a_sample) state(0) += step;
      } else {
        state(i) += std::sqrt(variance) * normal(engine);
      }
    }
  }
  return record;
}

// What the controller meets, by control period; a walk behind a lag has no
// covariances.
control::OutputConditions ConditionsOf(const Disturbance& of, int samples) {
  control::OutputConditions met;
  met.noise_variance = of.noise.variance;
  met.walk_variance = samples * of.noise.increment_variance();
  met.covariances = Autocovariances(of.noise, samples);
  return met;
}

using Plant = benchmarks::TunedPlant;

using Conditions = std::vector<control::OutputConditions>;

// Σ σ_i², all outputs having noise of variance 1; infinite of a loop that does
// not settle.
double VarianceUnder(const Plant& plant, const control::MpcOptions& tuning,
                     const Conditions& conditions) {
  const absl::StatusOr<control::Mpc> mpc =
      control::Mpc::Create(plant.prediction, tuning);
  CHECK(mpc.ok()) << mpc.status();
  const absl::StatusOr<control::ExpectedOperation> operation =
      control::ExpectOperation(*mpc, plant.model, conditions);
  if (!operation.ok()) return kInfinity;
  return operation->resting_variance.sum();
}

double VarianceWithBias(const Plant& plant, const VectorXd& ratios,
                        const Conditions& conditions) {
  control::MpcOptions tuning = plant.tuning;
  tuning.disturbance_variance_ratios = ratios;
  return VarianceUnder(plant, tuning, conditions);
}

double VarianceWith(const Plant& plant, const DisturbanceForm& form,
                    const Conditions& conditions) {
  control::MpcOptions tuning = plant.tuning;
  tuning.disturbance_model = form;
  return VarianceUnder(plant, tuning, conditions);
}

struct OutputScore {
  Family family = kWalk;
  bool estimated = false;
  bool kalman_better = false;
  bool bias_better = false;
  double kalman = 0.0;         // squared error over the true filter's
  double bias = 0.0;           // over the best bias filter's
  double kalman_in_use = 0.0;  // over that of the filter in use
  double bias_in_use = 0.0;
};

// Variances of the outputs in operation, over that under the true filters.
struct RunScore {
  std::vector<OutputScore> outputs;
  double in_use = 0.0;
  double kalman = 0.0;  // 0: none is better
  double bias = 0.0;
};

RunScore Run(const Plant& plant, int samples, std::uint64_t seed) {
  Uniform random(seed);
  const int p = plant.model.num_outputs();
  const double ratio_in_use = random.Draw(0.01, 10.0);
  const double gain_in_use = control::StationaryGain(ratio_in_use);
  std::vector<Disturbance> disturbances;
  Eigen::MatrixXd record(p, samples);
  for (int i = 0; i < p; ++i) {
    disturbances.push_back(DrawDisturbance(plant.lag, random));
    record.row(i) =
        DrawRecord(disturbances[i], samples, seed * 100 + i).transpose();
  }
  FilterOptions options;
  options.control_period = plant.tuning.control_period;
  options.horizon =
      plant.tuning.prediction_horizon * plant.tuning.control_period;
  options.gains_in_use = VectorXd::Constant(p, gain_in_use);
  const std::vector<OutputFilter> filters =
      FindFilters({record}, plant.sample_time, std::vector<bool>(p, false), 0.0,
                  options, 1);
  RunScore score;
  VectorXd ratios = VectorXd::Constant(p, ratio_in_use);
  std::vector<control::OutputConditions> conditions;
  bool has_conditions = true;
  std::vector<OutputFilter> true_filters(p);
  const PredictionGrid grid{.samples = plant.samples_of_period,
                            .horizon = plant.tuning.prediction_horizon};
  for (int i = 0; i < p; ++i) {
    const Disturbance& disturbance = disturbances[i];
    const OutputFilter& filter = filters[i];
    conditions.push_back(ConditionsOf(disturbance, grid.samples));
    has_conditions = has_conditions && disturbance.family != kIntegratedLoad;
    true_filters[i].noise = disturbance.noise;
    true_filters[i].kalman.better = true;
    OutputScore& output = score.outputs.emplace_back();
    output.family = disturbance.family;
    output.estimated = filter.estimated();
    if (!filter.estimated()) continue;
    if (filter.bias.better) {
      ratios(i) =
          filter.bias_gain * filter.bias_gain / (1.0 - filter.bias_gain);
    }
    const VectorXd unseen =
        DrawRecord(disturbance, kUnseen, seed * 100 + 50 + i);
    const auto bias = [&](double gain) {
      return Together(BiasErrors(unseen, gain, grid, kForget, kUnseen)).mean();
    };
    const auto kalman = [&](const DisturbanceSystem& system,
                            const StationaryFilter& stationary) {
      return Together(KalmanErrors(unseen, system, stationary, grid, kForget,
                                   kUnseen))
          .mean();
    };
    const double in_use = bias(gain_in_use);
    const double found = kalman(filter.Every(1), filter.stationary);
    const double found_bias = bias(filter.bias_gain);
    double best_bias = found_bias;
    for (double log = -8.0; log <= 0.0; log += 0.5) {
      best_bias = std::min(best_bias, bias(std::exp(log)));
    }
    output.kalman = found / kalman(disturbance.system,
                                   SolveStationaryFilter(disturbance.system));
    output.bias = found_bias / best_bias;
    output.kalman_better = filter.kalman.better;
    output.bias_better = filter.bias.better;
    output.kalman_in_use = found / in_use;
    output.bias_in_use = found_bias / in_use;
  }
  if (!has_conditions) return score;
  const double truth = VarianceWith(
      plant, CombineFilters(true_filters, grid.samples), conditions);
  const VectorXd in_use = VectorXd::Constant(p, ratio_in_use);
  score.in_use = VarianceWithBias(plant, in_use, conditions) / truth;
  if (!std::isfinite(score.in_use)) score.in_use = 0.0;  // not one in use
  if (ratios != in_use) {
    score.bias = VarianceWithBias(plant, ratios, conditions) / truth;
  }
  const DisturbanceForm form = CombineFilters(filters, grid.samples);
  if (form.A.size() > 0) {
    score.kalman = VarianceWith(plant, form, conditions) / truth;
  }
  return score;
}

std::string Quantiles(std::vector<double> values) {
  if (values.empty()) return "–";
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(
        share * static_cast<double>(values.size() - 1))];
  };
  char text[64];
  std::snprintf(text, sizeof text, "%.3f %.3f %.3f", at(0.5), at(0.9), at(1.0));
  return text;
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

void PrintFamily(const char* name, const std::vector<RunScore>& runs,
                 int family) {
  std::vector<double> kalman;
  std::vector<double> bias;
  int kalman_better = 0;
  int kalman_worse = 0;
  int bias_better = 0;
  int bias_worse = 0;
  int count = 0;
  for (const RunScore& run : runs) {
    for (const OutputScore& output : run.outputs) {
      if (family >= 0 && output.family != family) continue;
      ++count;
      if (!output.estimated) continue;
      kalman.push_back(output.kalman);
      bias.push_back(output.bias);
      kalman_better += output.kalman_better ? 1 : 0;
      bias_better += output.bias_better ? 1 : 0;
      kalman_worse +=
          output.kalman_better && output.kalman_in_use > 1.0 ? 1 : 0;
      bias_worse += output.bias_better && output.bias_in_use > 1.0 ? 1 : 0;
    }
  }
  std::printf("%-18s %5d  %.3f  %s  %5d %3d   %.3f  %s  %5d %3d\n", name, count,
              Mean(kalman), Quantiles(kalman).c_str(), kalman_better,
              kalman_worse, Mean(bias), Quantiles(bias).c_str(), bias_better,
              bias_worse);
}

void PrintOperation(const char* name, const std::vector<RunScore>& runs,
                    double RunScore::*of) {
  std::vector<double> variance;
  int worse = 0;
  int above_truth = 0;
  for (const RunScore& run : runs) {
    if (!(run.in_use > 0.0) || !(run.*of > 0.0)) continue;
    variance.push_back(run.*of);
    if (!(run.*of > run.in_use)) continue;
    ++worse;
    above_truth += run.in_use < 1.0 ? 1 : 0;
  }
  std::printf(
      "variance in operation over that under the true filters, %s: %zu runs, "
      "mean %.3f, median, 90 %% and max %s; %d worse than the filter in use, "
      "in %d of which that is better than the true filters, too\n",
      name, variance.size(), Mean(variance), Quantiles(variance).c_str(), worse,
      above_truth);
}

void Print(const std::vector<RunScore>& runs) {
  std::printf(
      "squared errors: of the Kalman gain over the true one's, of the bias "
      "filter over the best one's\n"
      "%-18s %5s  %-25s  %5s %3s   %-25s  %5s %3s\n",
      "disturbance", "count", "mean   median 90 %  max", "taken", "bad",
      "mean   median 90 %  max", "taken", "bad");
  for (int family = 0; family < kFamilies; ++family) {
    PrintFamily(kFamilyNames[family], runs, family);
  }
  PrintFamily("all", runs, -1);
  PrintOperation("filter in use", runs, &RunScore::in_use);
  PrintOperation("bias filters", runs, &RunScore::bias);
  PrintOperation("Kalman gains", runs, &RunScore::kalman);
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s RUNS FIRST_SEED SAMPLES\n", argv[0]);
    return 2;
  }
  const int runs = std::atoi(argv[1]);
  const auto first = static_cast<std::uint64_t>(std::atoll(argv[2]));
  const int samples = std::atoi(argv[3]);
  std::vector<mle::Plant> plants;
  for (const char* name :
       {MLE_CONFIG_DIR "/wood_berry.json", MLE_CONFIG_DIR "/splitter.json",
        MLE_PLANT_DIR "/vinante_luyben.json", MLE_PLANT_DIR "/wardle_wood.json",
        MLE_PLANT_DIR "/ogunnaike_ray.json"}) {
    plants.push_back(mle::benchmarks::ReadTunedPlant(name));
  }
  std::vector<mle::RunScore> scores(runs);
  mle::ParallelFor(runs, /*threads=*/0, [&](int r) {
    const auto seed = first + static_cast<std::uint64_t>(r);
    scores[r] = mle::Run(plants[seed % plants.size()], samples, seed);
  });
  mle::Print(scores);
  return 0;
}
