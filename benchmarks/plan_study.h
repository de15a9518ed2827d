// What plan_benchmark runs plans and tests on: plants, their loops, and how
// well a test tells of them.

#ifndef BENCHMARKS_PLAN_STUDY_H_
#define BENCHMARKS_PLAN_STUDY_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "Eigen/Core"
#include "benchmarks/tuned_plant.h"
#include "control/mpc.h"
#include "mle/plan/plan.h"
#include "sim/closed_loop.h"

namespace mle::benchmarks {

struct Site {
  TunedPlant plant;
  sim::PlantConditions conditions;
  NoiseEstimate noise;
  double settling = 0.0;

  sim::ClosedLoopOptions Loop(Eigen::Index samples, std::uint64_t seed,
                              bool noisy) const {
    sim::ClosedLoopOptions options;
    options.sample_time = plant.sample_time;
    options.control_period = plant.tuning.control_period;
    options.duration = plant.sample_time * static_cast<double>(samples - 1);
    options.noise_variance = noisy ? noise.variance : 0.0;
    options.seed = seed;
    return options;
  }
};

struct Study {
  Site site;
  control::Mpc mpc;
  PlanProblem problem;
  PlanOptions options;
  Eigen::MatrixXd window_set_points;
  // Over which squared errors are averaged: as expected, and as drawn.
  std::vector<ProcessModel> plants;
  std::vector<Eigen::MatrixXd> known;  // p, by the window
};

// Outputs in units of their noise, with a window of one set-point change.
Study MakeStudy(const char* path, std::uint64_t seed);

// The plants that the plan averages errors over, and what the window tells.
void ChoosePlants(Study& study);

// Of `plant` under the controller of the study, from rest. FailedPrecondition
// where it does not hold it.
absl::StatusOr<Record> RunLoop(const Site& site, const control::Mpc& tuned,
                               const ProcessModel& plant,
                               const Eigen::MatrixXd& set_points,
                               std::uint64_t seed, bool noisy);

struct Answers {
  double worst = 0.0;          // the largest error over that wanted
  std::vector<double> errors;  // of each question
  double cost = 0.0;
};

// Of a test that runs as `test` says with each plant.
Answers AnswersOf(
    const Study& study,
    const std::function<absl::StatusOr<Record>(const ProcessModel&)>& test);

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_PLAN_STUDY_H_
