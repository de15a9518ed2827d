#include "mle/maintain/explained.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "gtest/gtest.h"
#include "mle/mle.h"
#include "tests/mle/explain/closed_loop_records.h"

namespace mle {
namespace {

// The level shows that the valve has backlash, the warmth another gain: what
// happens to a valve happens to both.
TEST(ExplainedTest, OutputsThatContradictEachOtherCannotTell) {
  const ProcessModel model = TwoLoops();
  ProcessModel plant = model;
  plant.element(1, 0) = TransferFunction::FirstOrder(-1.4, 12.0, 4.0);
  Record record = CloseLoops(plant, 7);
  constexpr double kPlay = 0.15;
  double position = 0.0;
  double missing = 0.0;
  const TransferFunction& element = model.element(0, 0);
  const double kept = std::exp(-1.0 / element.TimeConstant());
  const int delay = static_cast<int>(element.delay());
  for (int k = delay; k < record.outputs.cols(); ++k) {
    record.outputs(0, k) += missing;
    const double asked = record.inputs(0, k - delay);
    position = std::clamp(position, asked - kPlay, asked + kPlay);
    missing = kept * missing +
              (1.0 - kept) * element.StaticGain() * (position - asked);
  }
  CorrectOptions options;
  options.make_arx = false;
  options.threads = 1;
  const auto result = CorrectFromRecords(model, {record}, options);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->decision, Decision::kCannotTell);
  const Message& reason = result->reasons.back();
  EXPECT_EQ(reason.place, "warmth");
  EXPECT_NE(reason.text.find("gain of warmth ← valve has changed, or valve "
                             "sticks or has backlash"),
            std::string::npos)
      << reason.text;
  EXPECT_NE(reason.text.find("as level shows"), std::string::npos);
  EXPECT_EQ(result->model.element(1, 0).StaticGain(), -0.9);
}

}  // namespace
}  // namespace mle
