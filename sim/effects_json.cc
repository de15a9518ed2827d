#include "sim/effects_json.h"

#include <set>
#include <utility>

#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/model/json_node.h"
#include "mle/model/strict_json.h"
#include "nlohmann/json.hpp"

namespace mle::sim {
namespace {

// Lists of rows such as [time, size], each with `columns` finite numbers.
absl::StatusOr<std::vector<std::vector<double>>> ReadRows(
    const JsonNode& object, const std::string& key, std::size_t columns,
    const char* form) {
  std::vector<std::vector<double>> rows;
  if (!object.Has(key)) return rows;
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       object.At(key).ElementsOrNone());
  for (const JsonNode& node : nodes) {
    MLE_ASSIGN_OR_RETURN(std::vector<double> row, node.Numbers());
    if (row.size() != columns) {
      return node.Fault("must be ", form);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

absl::StatusOr<std::vector<SignalStep>> ReadSteps(const JsonNode& object) {
  MLE_ASSIGN_OR_RETURN(const auto rows,
                       ReadRows(object, "steps", 2, "[time, size]"));
  std::vector<SignalStep> steps;
  for (const std::vector<double>& row : rows) {
    steps.push_back({.time = row[0], .size = row[1]});
  }
  return steps;
}

// Numbers, or pairs [real part, imaginary part].
absl::StatusOr<std::vector<std::complex<double>>> ReadRoots(
    const JsonNode& object, const std::string& key) {
  std::vector<std::complex<double>> roots;
  if (!object.Has(key)) return roots;
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       object.At(key).ElementsOrNone());
  for (const JsonNode& node : nodes) {
    if (node.json().is_array()) {
      MLE_ASSIGN_OR_RETURN(const std::vector<double> parts, node.Numbers());
      if (parts.size() != 2) {
        return node.Fault("must be a number, or [real part, imaginary part]");
      }
      roots.emplace_back(parts[0], parts[1]);
    } else {
      MLE_ASSIGN_OR_RETURN(const double root, node.Number());
      roots.emplace_back(root, 0.0);
    }
  }
  return roots;
}

absl::StatusOr<TagOptions> ReadTag(const JsonNode& node, int channel) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({}, {"exception", "compression", "max_interval",
                          "clock_offset", "step", "spikes"}));
  TagOptions tag;
  tag.channel = channel;
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "exception", kNotNegative, tag.exception));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "compression", kNotNegative, tag.compression));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "max_interval", kPositive, tag.max_interval));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "clock_offset", kAnyNumber, tag.clock_offset));
  MLE_RETURN_IF_ERROR(ReadBoolean(node, "step", tag.step));
  MLE_ASSIGN_OR_RETURN(const auto spikes,
                       ReadRows(node, "spikes", 2, "[time, size]"));
  for (const std::vector<double>& spike : spikes) {
    tag.spikes.push_back({.time = spike[0], .size = spike[1]});
  }
  return tag;
}

absl::Status ReadArma(const JsonNode& node, int output, Effects& effects) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({"variance"}, {"poles", "zeros"}));
  ArmaDisturbance arma;
  arma.output = output;
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "variance", kNotNegative, arma.noise.variance));
  MLE_ASSIGN_OR_RETURN(arma.noise.poles, ReadRoots(node, "poles"));
  MLE_ASSIGN_OR_RETURN(arma.noise.zeros, ReadRoots(node, "zeros"));
  MLE_RETURN_IF_ERROR(node.Check(arma.noise.Validate()));
  effects.arma.push_back(std::move(arma));
  return absl::OkStatus();
}

absl::Status ReadSines(const JsonNode& node, int output, Effects& effects) {
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> sines,
                       node.ElementsOrNone());
  for (const JsonNode& one : sines) {
    MLE_RETURN_IF_ERROR(one.CheckKeys({"amplitude", "period"}, {"phase"}));
    SineDisturbance sine;
    sine.output = output;
    MLE_RETURN_IF_ERROR(
        ReadNumber(one, "amplitude", kNotNegative, sine.amplitude));
    MLE_RETURN_IF_ERROR(ReadNumber(one, "period", kPositive, sine.period));
    if (one.Has("phase")) {
      MLE_ASSIGN_OR_RETURN(sine.phase, one.At("phase").Number());
    }
    effects.sines.push_back(sine);
  }
  return absl::OkStatus();
}

absl::Status ReadCurve(const JsonNode& node, OutputCurve& curve) {
  if (!node.Has("curve")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::string name, node.At("curve").String());
  for (const auto& [known, kind] :
       {std::pair("quadratic", OutputCurve::kQuadratic),
        std::pair("logarithm", OutputCurve::kLogarithm),
        std::pair("tanh", OutputCurve::kTanh)}) {
    if (name == known) curve = kind;
  }
  if (curve != OutputCurve::kNone) return absl::OkStatus();
  return node.At("curve").Fault(
      "must be \"quadratic\", \"logarithm\" or \"tanh\", but it is ",
      QuotedJson(name));
}

absl::Status ReadSensor(const JsonNode& node, int output, Effects& effects) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({}, {"curve", "curvature", "lag", "noise_variance", "min",
                          "max", "dead_from"}));
  SensorOptions sensor{.output = output};
  MLE_RETURN_IF_ERROR(ReadCurve(node, sensor.curve));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "curvature", kAnyNumber, sensor.curvature));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "lag", kNotNegative, sensor.lag));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "noise_variance", kNotNegative, sensor.noise_variance));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "min", kAnyNumber, sensor.min));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "max", kAnyNumber, sensor.max));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "dead_from", kAnyNumber, sensor.dead_from));
  if (!(sensor.min <= sensor.max)) {
    return node.Fault("min = ", sensor.min,
                      " must be at most max = ", sensor.max);
  }
  effects.sensors.push_back(sensor);
  return absl::OkStatus();
}

absl::Status ReadSetPoint(const JsonNode& node, int output, Effects& effects) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({}, {"ramps", "optimiser"}));
  MLE_ASSIGN_OR_RETURN(
      const auto ramps,
      ReadRows(node, "ramps", 3, "[time, duration ≥ 0, change]"));
  for (const std::vector<double>& ramp : ramps) {
    if (!(ramp[1] >= 0.0)) {
      return node.At("ramps").Fault("the duration of a ramp must be ≥ 0");
    }
    effects.ramps.push_back(
        {output, {.time = ramp[0], .size = ramp[2], .duration = ramp[1]}});
  }
  if (!node.Has("optimiser")) return absl::OkStatus();
  const JsonNode optimiser = node.At("optimiser");
  MLE_RETURN_IF_ERROR(optimiser.CheckKeys({"interval", "deviation"}, {}));
  OptimiserOptions moves{.output = output};
  MLE_RETURN_IF_ERROR(
      ReadNumber(optimiser, "interval", kPositive, moves.interval));
  MLE_RETURN_IF_ERROR(
      ReadNumber(optimiser, "deviation", kNotNegative, moves.deviation));
  effects.optimisers.push_back(moves);
  return absl::OkStatus();
}

absl::Status ReadOutput(const JsonNode& node, int output, Effects& effects) {
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {"name"}, {"arma", "sines", "steps", "sensor", "set_point", "archive"}));
  if (node.Has("arma")) {
    MLE_RETURN_IF_ERROR(ReadArma(node.At("arma"), output, effects));
  }
  if (node.Has("sines")) {
    MLE_RETURN_IF_ERROR(ReadSines(node.At("sines"), output, effects));
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<SignalStep> steps, ReadSteps(node));
  for (const SignalStep& step : steps) effects.steps.push_back({output, step});
  if (node.Has("sensor")) {
    MLE_RETURN_IF_ERROR(ReadSensor(node.At("sensor"), output, effects));
  }
  if (node.Has("set_point")) {
    MLE_RETURN_IF_ERROR(ReadSetPoint(node.At("set_point"), output, effects));
  }
  if (!node.Has("archive")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(TagOptions tag, ReadTag(node.At("archive"), output));
  effects.archive.outputs.push_back(std::move(tag));
  return absl::OkStatus();
}

absl::Status ReadLoad(const JsonNode& node, int input, Effects& effects) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({}, {"variance", "time_constant", "steps", "answered"}));
  InputLoad load;
  load.input = input;
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "variance", kNotNegative, load.variance));
  MLE_RETURN_IF_ERROR(
      ReadNumber(node, "time_constant", kPositive, load.time_constant));
  MLE_ASSIGN_OR_RETURN(load.steps, ReadSteps(node));
  MLE_RETURN_IF_ERROR(ReadNumber(node, "answered", kAnyNumber, load.answered));
  effects.loads.push_back(std::move(load));
  return absl::OkStatus();
}

absl::Status ReadActuator(const JsonNode& node, int input,
                          const ProcessModel& model, Effects& effects) {
  MLE_RETURN_IF_ERROR(node.CheckKeys(
      {}, {"stiction", "jump", "rangeability", "span", "position", "kink",
           "kink_slope", "min", "max", "rate"}));
  ActuatorOptions actuator{.input = input};
  for (const auto& [key, field] :
       {std::pair("stiction", &actuator.stiction),
        std::pair("jump", &actuator.slip_jump),
        std::pair("rangeability", &actuator.rangeability),
        std::pair("span", &actuator.span),
        std::pair("position", &actuator.position),
        std::pair("kink", &actuator.kink),
        std::pair("kink_slope", &actuator.kink_slope),
        std::pair("min", &actuator.min), std::pair("max", &actuator.max),
        std::pair("rate", &actuator.rate)}) {
    MLE_RETURN_IF_ERROR(ReadNumber(node, key, kAnyNumber, *field));
  }
  MLE_RETURN_IF_ERROR(node.Check(actuator.Validate(model)));
  effects.actuators.push_back(actuator);
  return absl::OkStatus();
}

absl::Status ReadInput(const JsonNode& node, int input,
                       const ProcessModel& model, Effects& effects) {
  MLE_RETURN_IF_ERROR(
      node.CheckKeys({"name"}, {"load", "manual", "actuator", "archive"}));
  if (node.Has("load")) {
    MLE_RETURN_IF_ERROR(ReadLoad(node.At("load"), input, effects));
  }
  MLE_ASSIGN_OR_RETURN(
      const auto manual,
      ReadRows(node, "manual", 3, "[from, to > from, change]"));
  for (const std::vector<double>& row : manual) {
    ManualPeriod period{
        .input = input, .from = row[0], .to = row[1], .change = row[2]};
    MLE_RETURN_IF_ERROR(node.At("manual").Check(period.Validate(model)));
    effects.manual.push_back(period);
  }
  if (node.Has("actuator")) {
    MLE_RETURN_IF_ERROR(
        ReadActuator(node.At("actuator"), input, model, effects));
  }
  if (!node.Has("archive")) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(TagOptions tag, ReadTag(node.At("archive"), input));
  effects.archive.inputs.push_back(std::move(tag));
  return absl::OkStatus();
}

// Calls `read` with each element of the list `key` and the channel it names.
template <typename Channel, typename Read>
absl::Status ReadChannels(const JsonNode& top, const std::string& key,
                          const std::vector<Channel>& channels,
                          const Read& read) {
  if (!top.Has(key)) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(const std::vector<JsonNode> nodes,
                       top.At(key).ElementsOrNone());
  std::set<int> seen;
  for (const JsonNode& node : nodes) {
    if (!node.Has("name")) return node.Fault("key \"name\" is missing");
    MLE_ASSIGN_OR_RETURN(const std::string name, node.At("name").String());
    int channel = 0;
    const int count = static_cast<int>(channels.size());
    while (channel < count && channels[channel].name != name) ++channel;
    if (channel == count) {
      return node.Fault("the model has no channel ", QuotedJson(name),
                        " among its ", key);
    }
    if (!seen.insert(channel).second) {
      return node.Fault(QuotedJson(name), " is duplicated");
    }
    MLE_RETURN_IF_ERROR(read(node, channel));
  }
  return absl::OkStatus();
}

template <typename Part>
void Append(const std::vector<Part>& parts, std::vector<Part>& list) {
  list.insert(list.end(), parts.begin(), parts.end());
}

}  // namespace

void Effects::AddTo(PlantConditions& conditions) const {
  Append(arma, conditions.output_disturbance.arma);
  Append(sines, conditions.output_disturbance.sines);
  Append(steps, conditions.output_disturbance.steps);
  Append(loads, conditions.loads);
  Append(manual, conditions.manual);
  Append(actuators, conditions.actuators);
  Append(sensors, conditions.sensors);
  Append(archive.outputs, conditions.archive.outputs);
  Append(archive.inputs, conditions.archive.inputs);
}

absl::Status Effects::AddTo(SetPointProfile& profile, double duration,
                            std::uint64_t seed, std::uint64_t stream) const {
  constexpr double kMostMoves = 10000.0;
  Append(ramps, profile.moves);
  for (const OptimiserOptions& optimiser : optimisers) {
    if (!(duration / optimiser.interval <= kMostMoves)) {
      return InvalidArgument("optimiser: interval = ", optimiser.interval,
                             ", but a run of ", duration, " may have at most ",
                             kMostMoves, " moves");
    }
    Append(DrawOptimiserMoves(optimiser.output, optimiser.interval,
                              optimiser.deviation, duration, seed, stream),
           profile.moves);
  }
  return absl::OkStatus();
}

absl::StatusOr<Effects> ParseEffects(std::string_view json,
                                     std::string_view source,
                                     const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const nlohmann::json parsed,
                       ParseStrictJson(json, source));
  return ParseEffects(JsonNode(parsed, std::string(source)), model);
}

absl::StatusOr<Effects> ParseEffects(const JsonNode& node,
                                     const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(node.CheckKeys({}, {"outputs", "inputs"}));
  Effects effects;
  MLE_RETURN_IF_ERROR(ReadChannels(node, "outputs", model.outputs(),
                                   [&](const JsonNode& channel, int output) {
                                     return ReadOutput(channel, output,
                                                       effects);
                                   }));
  MLE_RETURN_IF_ERROR(ReadChannels(
      node, "inputs", model.inputs(), [&](const JsonNode& channel, int input) {
        return ReadInput(channel, input, model, effects);
      }));
  return effects;
}

absl::StatusOr<Effects> ReadEffects(const std::string& path,
                                    const ProcessModel& model) {
  MLE_ASSIGN_OR_RETURN(const std::string json, ReadFile(path));
  return ParseEffects(json, path, model);
}

}  // namespace mle::sim
