// A step-response model's CSV or JSON: what is read is valid, and reads back
// the same from both forms.

#include "mle/exchange/step_response_model.h"
#include "tests/fuzz/fuzz.h"

namespace {

void ExpectSame(const mle::StepResponseModel& model, const std::string& text) {
  const auto again = mle::ParseStepResponseModel(text, "again");
  FUZZ_EXPECT(again.ok(), again.status().ToString());
  FUZZ_EXPECT(again->interval == model.interval);
  FUZZ_EXPECT(again->channels.name() == model.channels.name());
  FUZZ_EXPECT(again->pairs.size() == model.pairs.size());
  for (std::size_t p = 0; p < model.pairs.size(); ++p) {
    FUZZ_EXPECT(again->pairs[p].output == model.pairs[p].output);
    FUZZ_EXPECT(again->pairs[p].input == model.pairs[p].input);
    FUZZ_EXPECT(again->pairs[p].is_ramp == model.pairs[p].is_ramp);
    FUZZ_EXPECT(again->pairs[p].coefficients == model.pairs[p].coefficients);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const auto model = mle::ParseStepResponseModel(bytes.Rest(), "fuzz");
  if (!model.ok()) {
    FUZZ_EXPECT(model.status().message().find("fuzz: ") == 0);
    return 0;
  }
  FUZZ_EXPECT(model->Validate().ok(), model->Validate().ToString());
  ExpectSame(*model, mle::FormatStepResponseJson(*model));
  return 0;
}
