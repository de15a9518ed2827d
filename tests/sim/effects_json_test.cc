#include "sim/effects_json.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::sim {
namespace {

using ::mle::testing::MixedModel;
using ::testing::HasSubstr;

absl::StatusOr<Effects> ParseEffectsOf(const std::string& json) {
  return ParseEffects(json, "effects.json", MixedModel());
}

TEST(EffectsJsonTest, EveryEffectComesToItsChannel) {
  const absl::StatusOr<Effects> effects = ParseEffectsOf(R"({
    "outputs": [
      {"name": "y2",
       "arma": {"poles": [0.9, [0.5, 0.2]], "zeros": [0.3], "variance": 0.01},
       "sines": [{"amplitude": 0.1, "period": 20},
                 {"amplitude": 0.2, "period": 5, "phase": 1}],
       "steps": [[100, 0.2]],
       "sensor": {"curve": "logarithm", "curvature": -0.3, "lag": 1.5, "noise_variance": 0.001, "min": -1, "max": 2,
                  "dead_from": 300},
       "set_point": {"ramps": [[100, 60, 1.5]],
                     "optimiser": {"interval": 5, "deviation": 0.05}},
       "archive": {"exception": 0.01, "compression": 0.02, "max_interval": 60,
                   "clock_offset": -0.6, "step": true, "spikes": [[120, 5]]}}],
    "inputs": [
      {"name": "u3",
       "load": {"variance": 0.04, "time_constant": 40, "steps": [[200, 0.1]],
                "answered": 0.7},
       "manual": [[20, 30, -0.5], [40, 45, 0]],
       "actuator": {"stiction": 0.05, "jump": 0.02, "rangeability": 30,
                    "span": 2, "position": 0.4, "kink": 0.3,
                    "kink_slope": -2, "min": -4, "max": 5, "rate": 0.6},
       "archive": {"compression": 0.3}}]})");
  ASSERT_TRUE(effects.ok()) << effects.status();
  PlantConditions conditions;
  effects->AddTo(conditions);
  EXPECT_TRUE(conditions.Validate(MixedModel()).ok());

  const OutputDisturbanceOptions& disturbance = conditions.output_disturbance;
  ASSERT_EQ(disturbance.arma.size(), 1u);
  EXPECT_EQ(disturbance.arma[0].output, 1);
  EXPECT_EQ(disturbance.arma[0].noise.poles[1], std::complex(0.5, 0.2));
  EXPECT_EQ(disturbance.arma[0].noise.zeros[0], std::complex(0.3, 0.0));
  EXPECT_EQ(disturbance.arma[0].noise.variance, 0.01);
  ASSERT_EQ(disturbance.sines.size(), 2u);
  EXPECT_EQ(disturbance.sines[0].phase, std::nullopt);
  EXPECT_EQ(disturbance.sines[1].phase, 1.0);
  EXPECT_EQ(disturbance.sines[1].amplitude, 0.2);
  EXPECT_EQ(disturbance.sines[1].period, 5.0);
  ASSERT_EQ(disturbance.steps.size(), 1u);
  EXPECT_EQ(disturbance.steps[0].step.time, 100.0);
  EXPECT_EQ(disturbance.steps[0].step.size, 0.2);

  ASSERT_EQ(conditions.sensors.size(), 1u);
  const SensorOptions& sensor = conditions.sensors[0];
  EXPECT_EQ(sensor.output, 1);
  EXPECT_EQ(sensor.curve, OutputCurve::kLogarithm);
  EXPECT_EQ(sensor.curvature, -0.3);
  EXPECT_EQ(sensor.lag, 1.5);
  EXPECT_EQ(sensor.noise_variance, 0.001);
  EXPECT_EQ(sensor.min, -1.0);
  EXPECT_EQ(sensor.max, 2.0);
  EXPECT_EQ(sensor.dead_from, 300.0);

  ASSERT_EQ(conditions.loads.size(), 1u);
  EXPECT_EQ(conditions.loads[0].input, 2);
  EXPECT_EQ(conditions.loads[0].variance, 0.04);
  EXPECT_EQ(conditions.loads[0].time_constant, 40.0);
  EXPECT_EQ(conditions.loads[0].steps.at(0).size, 0.1);
  EXPECT_EQ(conditions.loads[0].answered, 0.7);
  ASSERT_EQ(conditions.manual.size(), 2u);
  EXPECT_EQ(conditions.manual[0].input, 2);
  EXPECT_EQ(conditions.manual[0].from, 20.0);
  EXPECT_EQ(conditions.manual[0].to, 30.0);
  EXPECT_EQ(conditions.manual[0].change, -0.5);
  ASSERT_EQ(conditions.actuators.size(), 1u);
  const ActuatorOptions& actuator = conditions.actuators[0];
  EXPECT_EQ(actuator.input, 2);
  EXPECT_EQ(actuator.stiction, 0.05);
  EXPECT_EQ(actuator.slip_jump, 0.02);
  EXPECT_EQ(actuator.rangeability, 30.0);
  EXPECT_EQ(actuator.span, 2.0);
  EXPECT_EQ(actuator.position, 0.4);
  EXPECT_EQ(actuator.kink, 0.3);
  EXPECT_EQ(actuator.kink_slope, -2.0);
  EXPECT_EQ(actuator.min, -4.0);
  EXPECT_EQ(actuator.max, 5.0);
  EXPECT_EQ(actuator.rate, 0.6);

  const TagOptions& tag = conditions.archive.outputs.at(0);
  EXPECT_EQ(tag.channel, 1);
  EXPECT_EQ(tag.exception, 0.01);
  EXPECT_EQ(tag.compression, 0.02);
  EXPECT_EQ(tag.max_interval, 60.0);
  EXPECT_EQ(tag.clock_offset, -0.6);
  EXPECT_TRUE(tag.step);
  EXPECT_EQ(tag.spikes.at(0).time, 120.0);
  EXPECT_EQ(tag.spikes.at(0).size, 5.0);
  EXPECT_EQ(conditions.archive.inputs.at(0).channel, 2);
  EXPECT_EQ(conditions.archive.inputs.at(0).compression, 0.3);

  SetPointProfile profile;
  EXPECT_TRUE(effects->AddTo(profile, 51.0, 1, 0).ok());
  ASSERT_EQ(profile.moves.size(), 1u + 10u);  // at 5, 10, … 50
  EXPECT_EQ(profile.moves[0].output, 1);
  EXPECT_EQ(profile.moves[0].change.time, 100.0);
  EXPECT_EQ(profile.moves[0].change.duration, 60.0);
  EXPECT_EQ(profile.moves[0].change.size, 1.5);
  EXPECT_EQ(profile.moves[10].change.time, 50.0);
  EXPECT_FALSE(effects->AddTo(profile, 51000.0, 1, 0).ok());
}

TEST(EffectsJsonTest, AnEmptyFileHasNoEffects) {
  const absl::StatusOr<Effects> effects = ParseEffectsOf("{}");
  ASSERT_TRUE(effects.ok());
  PlantConditions conditions;
  effects->AddTo(conditions);
  EXPECT_TRUE(conditions.sensors.empty());
}

TEST(EffectsJsonTest, MistakesAreNamed) {
  const auto message = [](const std::string& json) {
    const absl::Status status = ParseEffectsOf(json).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << json;
    return std::string(status.message());
  };
  const auto output = [&](const std::string& rest) {
    return message(R"({"outputs": [{"name": "y1", )" + rest + "}]}");
  };
  const auto input = [&](const std::string& rest) {
    return message(R"({"inputs": [{"name": "u1", )" + rest + "}]}");
  };
  EXPECT_THAT(message("{"), HasSubstr("effects.json: line 1"));
  EXPECT_THAT(message(R"({"output": []})"),
              HasSubstr("unknown key \"output\""));
  EXPECT_THAT(message(R"({"outputs": 1})"), HasSubstr("outputs: must be"));
  EXPECT_THAT(message(R"({"outputs": [{}]})"),
              HasSubstr("outputs[0]: key \"name\" is missing"));
  EXPECT_THAT(message(R"({"outputs": [{"steps": [[100, 0.2]]}]})"),
              HasSubstr("outputs[0]: key \"name\" is missing"));
  EXPECT_THAT(message(R"({"outputs": [{"name": "u1"}]})"),
              HasSubstr("no channel \"u1\" among its outputs"));
  EXPECT_THAT(message(R"({"inputs": [{"name": "u1"}, {"name": "u1"}]})"),
              HasSubstr("inputs[1]: \"u1\" is duplicated"));
  EXPECT_THAT(output(R"("arma": {"poles": [1.2], "variance": 1})"),
              HasSubstr("outputs[0].arma: the pole 1.2"));
  EXPECT_THAT(output(R"("arma": {"poles": [[1]], "variance": 1})"),
              HasSubstr("arma.poles[0]: must be a number, or [real part"));
  EXPECT_THAT(output(R"("sines": [{"amplitude": 1, "period": 0}])"),
              HasSubstr("sines[0].period"));
  EXPECT_THAT(output(R"("steps": [[1, 2, 3]])"),
              HasSubstr("steps[0]: must be [time, size]"));
  EXPECT_THAT(output(R"("sensor": {"min": 2, "max": 1})"),
              HasSubstr("sensor: min = 2 must be at most max = 1"));
  EXPECT_THAT(output(R"("sensor": {"curve": "square"})"),
              HasSubstr("sensor.curve: must be \"quadratic\""));
  EXPECT_THAT(input(R"("manual": [[2, 1, 0]])"),
              HasSubstr("inputs[0].manual: manual from 2 to 1"));
  EXPECT_THAT(input(R"("actuator": {"rate": 0})"), HasSubstr("rate = 0"));
  EXPECT_THAT(output(R"("set_point": {"ramps": [[1, -2, 3]]})"),
              HasSubstr("set_point.ramps: the duration"));
  EXPECT_THAT(output(R"("set_point": {"optimiser": {"interval": 1}})"),
              HasSubstr("key \"deviation\" is missing"));
  EXPECT_THAT(output(R"("archive": {"compression": -1})"),
              HasSubstr("archive.compression"));
  EXPECT_THAT(output(R"("load": {})"), HasSubstr("unknown key \"load\""));
  EXPECT_THAT(input(R"("load": {"variance": -1})"),
              HasSubstr("inputs[0].load.variance"));
  EXPECT_THAT(input(R"("actuator": {"span": -1})"), HasSubstr("span = -1"));
  EXPECT_THAT(input(R"("archive": {"max_interval": 0})"),
              HasSubstr("archive.max_interval"));
}

}  // namespace
}  // namespace mle::sim
