// An ARX model's JSON: what is read is valid, and reads back the same.

#include "mle/model/arx_model_json.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const auto named = mle::ParseArxModel(bytes.Rest(), "fuzz.json");
  if (!named.ok()) {
    FUZZ_EXPECT(named.status().message().find("fuzz.json: ") == 0);
    return 0;
  }
  FUZZ_EXPECT(named->Validate().ok(), named->Validate().ToString());
  const std::string text = mle::FormatArxModel(*named);
  const auto again = mle::ParseArxModel(text, "again.json");
  FUZZ_EXPECT(again.ok(), again.status().ToString());
  FUZZ_EXPECT(again->model.R == named->model.R);
  FUZZ_EXPECT(again->outputs == named->outputs);
  FUZZ_EXPECT(again->inputs == named->inputs);
  FUZZ_EXPECT(named->model.ComputeStepResponse(40).values.allFinite());
  return 0;
}
