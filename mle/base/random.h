// Seeded random numbers, and the one list of the streams they are drawn from.
//
// A generator belongs to a seed, a stream and a substream, so that the parts
// of an experiment (its runs, the excitation of the conversion, …) draw
// independently and none depends on how much another has drawn.
//
//   GaussianNoise noise(seed, kConversionStream, kExcitationNoise);
//   noise.DrawMatrix(p, samples, std::sqrt(variance));

#ifndef MLE_BASE_RANDOM_H_
#define MLE_BASE_RANDOM_H_

#include <cstdint>
#include <random>

#include "Eigen/Core"

namespace mle {

// Streams of a seed: one for each run or part of an experiment. They are
// allotted in blocks of a million, of which a part uses the first, or one for
// each of its repetitions from the first on. A new part takes the next free
// block; a number once given stays, because published figures hang on it. Where
// two parts have the same block, no command draws for both from the same seed
// and substream for quantities that are compared.

// Closed loops and records: + 0, 1, … for each run.
inline constexpr std::uint64_t kRunStream = 0;
// Excitation of the model that is converted to ARX.
inline constexpr std::uint64_t kConversionStream = 1'000'000;
// Closed loops in which models are compared: + the output stepped.
inline constexpr std::uint64_t kComparisonStream = 2'000'000;
// Records simulated to calibrate a test: + the replicate.
inline constexpr std::uint64_t kCalibrationStream = 3'000'000;
// Random plants of a study, and how they age (a substream for each change).
inline constexpr std::uint64_t kPlantStream = 2'000'000;
inline constexpr std::uint64_t kAgeingStream = 3'000'000;
// A plant's life: its set-point changes begin at kRunStream + 1, step tests and
// times of watching here, each + the change that comes next.
inline constexpr std::uint64_t kStepTestStream = 1'000'000;
inline constexpr std::uint64_t kWatchStream = 2'000'000;

// The uses of a stream, each with a generator of its own: switching one on
// leaves the draws of all others as they were.
enum Substream : std::uint32_t {
  kMeasurementNoise = 0,  // of a closed loop
  kExcitationInputs = 1,
  kExcitationNoise = 2,
  kColouredDisturbance = 10,
  kDriftDisturbance = 11,
  kStepTimes = 12,
  kStepSizes = 13,
  kSinePhases = 14,
  kInputDisturbance = 20,
  kOutliers = 30,
  kFrozenChannels = 31,
  kLostOutputs = 32,
  kLostInputs = 33,
  kSetPointTimes = 100,
  kSetPointSizes = 101,
  kSlowDisturbance = 102,
  kPlanPlants = 103,
  kStampErrors = 104,
  kArmaNoise = 1000,       // + the output
  kSensorNoise = 1500,     // + the output
  kInputLoad = 2000,       // + the input
  kOptimiserMoves = 3000,  // + the output
};

std::mt19937_64 SeededEngine(std::uint64_t seed, std::uint64_t stream,
                             std::uint32_t substream);

// Uniform in [0, 1).
double DrawUniform(std::mt19937_64& engine);

class GaussianNoise {
 public:
  GaussianNoise(std::uint64_t seed, std::uint64_t stream,
                std::uint32_t substream = kMeasurementNoise);

  // One draw of mean 0 and the given standard deviation ≥ 0.
  double Draw(double standard_deviation);
  // rows × cols independent draws, column by column.
  Eigen::MatrixXd DrawMatrix(int rows, int cols, double standard_deviation);

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace mle

#endif  // MLE_BASE_RANDOM_H_
