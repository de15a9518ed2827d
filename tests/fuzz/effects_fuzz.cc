// Effects' JSON: what is read is valid, and a closed loop can run under it.

#include "sim/closed_loop.h"
#include "sim/effects_json.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/tank.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const mle::ProcessModel& tank = mle::fuzz::Tank();
  const auto effects = mle::sim::ParseEffects(bytes.Rest(), "fuzz.json", tank);
  if (!effects.ok()) {
    FUZZ_EXPECT(effects.status().message().find("fuzz.json: ") == 0);
    return 0;
  }
  const mle::sim::ClosedLoopOptions options{.duration = 10.0};
  mle::sim::PlantConditions conditions;
  effects->AddTo(conditions);
  FUZZ_EXPECT(conditions.Validate(tank).ok());
  mle::sim::SetPointProfile profile;
  const absl::Status status =
      effects->AddTo(profile, options.duration, options.seed, options.stream);
  if (!status.ok()) return 0;
  FUZZ_EXPECT(profile.Validate(tank.num_outputs()).ok());
  const auto record = mle::sim::SimulateClosedLoop(
      tank, [](const auto&, const auto&, auto next) { next.setOnes(); },
      profile, options, conditions);
  FUZZ_EXPECT(!record.ok() || record->samples() == 51);
  return 0;
}
