// An ageing schedule's JSON: what is read is valid, and a plant can be aged
// by it.

#include "sim/ageing_json.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/tank.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const mle::ProcessModel& tank = mle::fuzz::Tank();
  const auto ageing =
      mle::sim::ParseAgeingSchedule(bytes.Rest(), "fuzz.json", tank);
  if (!ageing.ok()) {
    FUZZ_EXPECT(ageing.status().message().find("fuzz.json: ") == 0);
    return 0;
  }
  FUZZ_EXPECT(ageing->Validate(tank).ok());
  for (const double time : {-1e9, 0.0, 0.3, 1e3, 1e9}) {
    const absl::Status status =
        mle::sim::AgedModel(tank, *ageing, time).Validate();
    FUZZ_EXPECT(status.ok(), status.ToString());
  }
  return 0;
}
