// What stands in flags: set points and limits by name, lists of numbers, dates.

#include <cmath>
#include <limits>

#include "apps/common/option_values.h"
#include "apps/simulate/request.h"
#include "mle/data/civil_time.h"
#include "mle/data/time_format.h"
#include "tests/fuzz/fuzz.h"

namespace mle {
namespace {

void CheckSteps(std::string_view text) {
  const std::vector<std::string> names = {"level", "a:b", "temperature"};
  const auto steps = simulate::ParseNamedSteps("setpoints", text, names);
  if (!steps.ok()) {
    FUZZ_EXPECT(steps.status().message().find("--setpoints") == 0);
    return;
  }
  for (const simulate::NamedStep& step : *steps) {
    FUZZ_EXPECT(step.channel >= 0 && step.channel < 3);
    FUZZ_EXPECT(std::isfinite(step.time) && std::isfinite(step.value));
  }
}

void CheckNumbers(std::string_view text) {
  const auto numbers = ParseNumbers(text, kNotNegative);
  if (numbers.ok()) {
    FUZZ_EXPECT(numbers->size() > 0 && numbers->allFinite());
    FUZZ_EXPECT(numbers->minCoeff() >= 0.0);
    const auto fitted = FitToChannels(*numbers, 3);
    FUZZ_EXPECT(!fitted.ok() || fitted->size() == 3);
  }
  const double infinity = std::numeric_limits<double>::infinity();
  const auto limits = ParseNumbers(text, kAnyNumber, infinity);
  FUZZ_EXPECT(!limits.ok() || !limits->hasNaN());
}

void CheckTimes(std::string_view text) {
  for (const TimeForm& form : TimeForms()) {
    const auto civil = ReadCivilTime(text, form);
    if (!civil.has_value()) continue;
    const double seconds = SecondsSinceEpoch(*civil);
    FUZZ_EXPECT(std::isfinite(seconds));
    if (civil->year < 2 || civil->year > 9998) continue;
    // What is written reads back, to the second it shows.
    const auto again =
        ReadCivilTime(FormatIsoTime(seconds), FormOf(TimeFormat::kIso));
    FUZZ_EXPECT(again.has_value(), text);
    FUZZ_EXPECT(std::abs(SecondsSinceEpoch(*again) - seconds) <= 1.0, text);
  }
}

// Any text is a pattern or an error; a pattern reads any text.
void CheckPattern(std::string_view text) {
  const auto pattern = TimePattern::Create(text.substr(0, text.size() / 2));
  if (!pattern.ok()) return;
  const auto civil = pattern->Read(text.substr(text.size() / 2));
  FUZZ_EXPECT(!civil.has_value() || Exists(*civil));
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  const std::string_view text = mle::fuzz::Bytes(data, size).Rest();
  mle::CheckSteps(text);
  mle::CheckNumbers(text);
  mle::CheckTimes(text);
  mle::CheckPattern(text);
  for (const std::string& part : mle::ParseList(text)) {
    FUZZ_EXPECT(part.find(',') == std::string::npos);
  }
  return 0;
}
