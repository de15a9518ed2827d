// A process model's JSON: what is read is valid, and reads back the same.

#include <cmath>

#include "mle/model/process_model.h"
#include "tests/fuzz/fuzz.h"

namespace mle {
namespace {

// The magnitudes of real processes: beyond these responses may overflow.
bool IsOfModestSize(const TransferFunction& g) {
  const auto modest = [](double value) {
    return value == 0.0 || (std::abs(value) > 1e-9 && std::abs(value) < 1e9);
  };
  for (const double value : g.numerator()) {
    if (!modest(value)) return false;
  }
  for (const double value : g.denominator()) {
    if (!modest(value)) return false;
  }
  return modest(g.delay()) && g.denominator().size() <= 6;
}

void CheckElement(const TransferFunction& g) {
  FUZZ_EXPECT(g.Validate().ok(), g.Validate().ToString());
  if (!IsOfModestSize(g)) return;
  FUZZ_EXPECT(std::isfinite(g.StaticGain()));
  FUZZ_EXPECT(g.SlowestTimeConstant() >= 0.0);
  FUZZ_EXPECT(g.StepResponse(0.2, 40).allFinite());
}

// Where it holds, there are numbers, which rise.
void CheckTransform(const Transform& transform) {
  for (const double x : {-1e60, -1.0, transform.at, 3.0, 1e60}) {
    FUZZ_EXPECT(std::isnan(transform.Linear(x)) != transform.Holds(x));
    FUZZ_EXPECT(!(transform.Slope(x) < 0.0));
    FUZZ_EXPECT(std::isnan(transform.Slope(x)) != transform.Holds(x));
    transform.Engineering(x);
  }
  FUZZ_EXPECT(transform.Linear(transform.at) == transform.at);
  FUZZ_EXPECT(transform.Slope(transform.at) == 1.0);
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const auto model = mle::ParseProcessModel(bytes.Rest(), "fuzz.json");
  if (!model.ok()) {
    FUZZ_EXPECT(model.status().message().find("fuzz.json: ") == 0);
    return 0;
  }
  FUZZ_EXPECT(model->Validate().ok(), model->Validate().ToString());
  const std::string text = mle::FormatProcessModel(*model);
  const auto again = mle::ParseProcessModel(text, "again.json");
  FUZZ_EXPECT(again.ok(), again.status().ToString());
  FUZZ_EXPECT(mle::FormatProcessModel(*again) == text, text);
  for (const mle::InputChannel& input : model->inputs()) {
    if (!input.transform.IsNone()) mle::CheckTransform(input.transform);
  }
  for (const mle::OutputChannel& output : model->outputs()) {
    if (!output.transform.IsNone()) mle::CheckTransform(output.transform);
  }
  if (model->num_inputs() * model->num_outputs() > 16) return 0;
  for (int i = 0; i < model->num_outputs(); ++i) {
    for (int j = 0; j < model->num_inputs(); ++j) {
      mle::CheckElement(model->element(i, j));
    }
  }
  return 0;
}
