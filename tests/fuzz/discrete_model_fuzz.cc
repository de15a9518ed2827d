// A discrete model's JSON, transfer functions or a state space: what is read is
// valid, and reads back the same.

#include "mle/exchange/discrete_model.h"
#include "mle/model/state_space_json.h"
#include "tests/fuzz/fuzz.h"

namespace {

void CheckStateSpace(std::string_view text) {
  const auto named = mle::ParseStateSpace(text, "fuzz");
  if (!named.ok()) {
    FUZZ_EXPECT(named.status().message().find("fuzz: ") == 0);
    return;
  }
  const std::string written = mle::FormatStateSpace(*named);
  const auto again = mle::ParseStateSpace(written, "again");
  FUZZ_EXPECT(again.ok(), again.status().ToString());
  FUZZ_EXPECT(mle::FormatStateSpace(*again) == written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const std::string_view text = bytes.Rest();
  CheckStateSpace(text);
  const auto model = mle::ParseDiscreteModel(text, "fuzz");
  if (!model.ok()) {
    FUZZ_EXPECT(model.status().message().find("fuzz: ") == 0);
    return 0;
  }
  FUZZ_EXPECT(model->Validate().ok(), model->Validate().ToString());
  const std::string written = mle::FormatDiscreteModel(*model);
  const auto again = mle::ParseDiscreteModel(written, "again");
  FUZZ_EXPECT(again.ok(), again.status().ToString());
  FUZZ_EXPECT(mle::FormatDiscreteModel(*again) == written);
  return 0;
}
