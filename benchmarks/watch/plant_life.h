// The life of a plant under predictive control, day by day: quiet days for the
// reference, then days with set-point changes while the plant ages or does not.
//
// Each day is a record of its own that begins at rest: what goes on between the
// days that are looked at tells the watch nothing. The plant is the Wood–Berry
// column, sampled every minute.

#ifndef BENCHMARKS_WATCH_PLANT_LIFE_H_
#define BENCHMARKS_WATCH_PLANT_LIFE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "control/mpc.h"
#include "mle/model/process_model.h"
#include "mle/monitor/model_watch.h"

namespace mle::benchmarks {

// What the plant does besides following its inputs.
enum class Effect {
  kWhiteNoise,   // of variance 1e-3, which all others have too
  kDrift,        // a random walk of the outputs, 1e-5 a minute
  kColoured,     // variance 0.01, time constant 10 min
  kInputLoad,    // unmeasured, variance 1e-4, time constant 200 min
  kSine,         // amplitude 0.1, period 20 min
  kOutliers,     // one sample of 500, up to 1
  kCompression,  // swinging door of the historian, two standard deviations
  kHeavyTails,   // kColoured and kOutliers and lost samples
  kSteps,        // unmeasured, at the outputs: 0.1, one in 800 min
  kStiction,     // valves that stick over 0.005, about 5 % of their travel
  kSaturation,   // valves that end at ± 0.1
  kNoisier,      // noise whose variance is 1 to 4 times as large, by day
};
inline constexpr int kNumEffects = 12;
std::string NameOf(Effect effect);

enum class Ageing {
  kNone,
  kGain,          // −30 % in a year, evenly
  kDelay,         // + 50 % at once
  kTimeConstant,  // × 1.5 at once
};
inline constexpr int kNumAgeings = 4;
std::string NameOf(Ageing ageing);

struct LifeOptions {
  Effect effect = Effect::kWhiteNoise;
  Ageing ageing = Ageing::kNone;
  std::uint64_t seed = 1;
  int days = 420;
  int reference_days = 14;
  double changes_per_day = 1.0 / 3.0;  // days with set-point changes
};

struct AgeingElement {
  int output = 0;
  int input = 0;
  int begin = 0;  // day
};

class PlantLife {
 public:
  PlantLife(const ProcessModel& model, const LifeOptions& options);

  const AgeingElement& ageing() const { return ageing_; }
  // Whether set points change on that day.
  bool Moves(int day) const { return moves_[day]; }
  // The record of the day, from `lead` minutes before it.
  WatchBatch Day(int day, int lead) const;
  // With that element as it is `days` after the begin of its ageing.
  ProcessModel PlantAfter(Ageing ageing, const AgeingElement& element,
                          int days) const;

 private:
  ProcessModel model_;
  LifeOptions options_;
  control::Mpc controller_;  // at rest
  AgeingElement ageing_;
  std::vector<bool> moves_;
};

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_WATCH_PLANT_LIFE_H_
