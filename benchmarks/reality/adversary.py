"""What plants and historians do that neither the model nor its noise foresees: an adversary's list.

Each family is a function that changes a Trial, the codes of the explanations that are true of it,
and whether plant and record stay linear and what they say they are. Records have set-point changes
up and down, of unlike sizes; where something has aged, it is one parameter of one element.
"""

import dataclasses
import math
import typing

import ageing
import effects
import plants

ROUNDS = 3  # changes of each set point

# Explanations that say that a parameter of an element has aged.
AGEING_CODES = ("gain", "time_constant", "dead_time")


@dataclasses.dataclass(frozen=True)
class Family:
    happen: typing.Callable
    codes: tuple = ()  # of the explanations that are true; none: nothing is to be explained
    linear: bool = False
    disturbed: bool = False  # needs a measured disturbance


def signed(trial, value, spread=1.4):
    return trial.random.choice((-1, 1)) * trial.about(value, spread)


def curve(trial, names, kind, amount):
    for name in names:
        trial.output(name).setdefault("sensor", {}).update(
            curve=kind, curvature=amount / trial.steps[name])


def curved_output(trial):
    curve(trial, trial.outputs, "quadratic", signed(trial, 0.12))


def logarithmic(trial):
    trial.where = trial.any_output()
    curve(trial, [trial.where], "logarithm", signed(trial, 0.4))


def s_shaped(trial):
    trial.where = trial.any_output()
    curve(trial, [trial.where], "tanh", trial.about(0.6))


def actuator(trial, **options):
    trial.where = trial.any_moved()
    trial.input(trial.where)["actuator"] = {
        key: value * trial.sizes[trial.where] if key in ("rate", "min", "max", "kink") else value
        for key, value in options.items()}


def rate_limit(trial):
    actuator(trial, rate=1.0 / trial.about(0.8, 1.6) / trial.time_constant)


def split_range(trial):
    actuator(trial, kink=trial.random.uniform(0.0, 0.3),
             kink_slope=trial.about(1.6, 1.2) ** trial.random.choice((-1, 1)))


def hidden_saturation(trial):
    actuator(trial, **{trial.random.choice(("min", "max")): trial.about(0.8)})
    options = trial.input(trial.where)["actuator"]
    if "min" in options:
        options["min"] *= -1.0


def load_with_set_points(trial):
    """One sign, whatever the set point does."""
    name = trial.any_moved()
    size = signed(trial, 0.2) * trial.sizes[name]
    trial.input(name)["load"] = {"steps": [[at, size] for _, at, _ in trial.changes()]}


def feed_with_set_points(trial):
    """The feed follows the set points, and nobody recorded it."""
    name = trial.any_moved()
    size = signed(trial, 0.3) * trial.sizes[name]
    before = dict.fromkeys(trial.outputs, 0.0)
    steps = []
    for output, at, value in trial.changes():
        steps.append([at, size * (value - before[output]) / trial.steps[output]])
        before[output] = value
    trial.input(name)["load"] = {"steps": steps}


def unmeasured_feedforward(trial):
    name = trial.any_moved()
    trial.input(name)["load"] = {
        "variance": (trial.about(0.3) * trial.sizes[name]) ** 2,
        "time_constant": trial.about(3, 2) * trial.time_constant,
        "answered": trial.about(0.8, 1.3)}


def third_order(trial):
    """Three equal lags; the model is the best of first order, by least squares of the step
    responses (0.667 and 0.374 of the sum of lags)."""
    for i, element in enumerate(trial.model["elements"]):
        if "gain" not in element:
            continue
        lag = element["time_constant"]
        trial.truth["elements"][i] = plants.with_factor(
            {**element, "time_constant": lag / 3}, [1.0],
            plants.product([lag / 3, 1.0], [lag / 3, 1.0]))
        element["time_constant"] = 0.667 * lag
        element["delay"] += 0.374 * lag


def late(trial, names, whole=False):
    trial.where = trial.random.choice(names)
    period = trial.plant.sample_time
    offset = signed(trial, 0.15) * trial.time_constant
    if whole:
        offset = math.copysign(max(1, round(abs(offset) / period)) * period, offset)
    effects.archive(trial, [trial.where], step=whole, clock_offset=offset)


def late_output(trial):
    late(trial, trial.outputs)


def late_input(trial):
    late(trial, trial.moved, whole=True)


def fast_analyser(trial):
    """All dead times of an output are shorter by the same."""
    dead = {name: min(element["delay"] for element in trial.model["elements"]
                      if element["output"] == name) for name in trial.outputs}
    trial.where = max(dead, key=dead.get)
    shift = trial.random.uniform(0.7, 1.0) * dead[trial.where]
    for element in trial.truth["elements"]:
        if element["output"] == trial.where:
            element["delay"] -= shift


def gains_fall(trial):
    """All gains of an output, from the first change to the end."""
    trial.where = trial.any_output()
    factor = trial.random.uniform(0.55, 0.75)
    for place, element in enumerate(trial.truth["elements"]):
        if element["output"] == trial.where:
            ageing.schedule(trial, place, factor, [(0, 0), (1, 1)])


def temporary_change(trial):
    """A gain that is back when the record ends."""
    place = ageing.some_elements(trial, 1)[0]
    trial.where = trial.truth["elements"][place]["output"]
    start = trial.random.uniform(0.2, 0.4)
    end = start + trial.random.uniform(0.2, 0.35)
    ageing.schedule(trial, place, ageing.gain_factor(trial),
                    [(start, 0), (start, 1), (end, 1), (end, 0)])


def recycle(trial):
    """Positive feedback through a long lag, from an output to itself: the model was found in
    tests that were shorter."""
    trial.where = trial.any_output()
    lag = trial.about(6) * trial.time_constant
    share = trial.random.uniform(0.2, 0.4)
    trial.truth["elements"] = [
        plants.with_factor(element, [lag, 1.0], [lag, 1.0 - share])
        if element["output"] == trial.where else element for element in trial.truth["elements"]]


def slow_loads(trial):
    for name in trial.moved:
        trial.input(name)["load"] = {"variance": (trial.about(0.25) * trial.sizes[name]) ** 2,
                                     "time_constant": trial.about(25) * trial.time_constant}


def sine_and_rounding(trial):
    effects.sine(trial)
    effects.quantised(trial)


def output_steps(trial, places, size):
    trial.where = trial.any_output()
    duration = trial.duration()
    trial.output(trial.where)["steps"] = [
        [place * duration, size * trial.steps[trial.where] / len(places)] for place in places]


def sensor_drift(trial):
    output_steps(trial, [k / 500 for k in range(1, 500)], signed(trial, 0.8))


def recalibration(trial):
    output_steps(trial, [trial.random.uniform(0.25, 0.75)], signed(trial, 0.5))


def controller_off(trial):
    start = trial.random.uniform(0.2, 0.5)
    effects.manual(trial, trial.moved, start, 1 / 3, 0.0)
    # While it is off nobody moves its set points.
    trial.set_points = [change for change in trial.changes()
                        if not start <= change[1] / trial.duration() <= start + 1 / 3 + 0.02]


def input_overrides(trial):
    for k in range(3):
        effects.manual(trial, [trial.any_moved()], (k + trial.random.uniform(0.2, 0.6)) / 3,
               trial.random.uniform(0.04, 0.08), signed(trial, 0.4))


def shutdown(trial):
    start = trial.random.uniform(0.3, 0.6)
    effects.manual(trial, trial.moved, start, trial.about(0.1), -trial.about(2))


def set_point_overrides(trial):
    changes = list(trial.changes())
    for _ in range(4):
        name = trial.any_output()
        at = trial.random.uniform(0.05, 0.9) * trial.duration()
        before = [value for output, time, value in changes if output == name and time <= at]
        base = before[-1] if before else 0.0
        changes += [(name, at, base + signed(trial, 0.6) * trial.steps[name]),
                    (name, at + trial.about(0.15) * trial.plant.settling, base)]
        changes.sort(key=lambda change: change[1])
    trial.set_points = changes


def retuned(trial):
    """A controller far from the tuning of the others."""
    factor = trial.random.choice((0.03, 30.0))
    weights = [factor * float(weight) for weight in trial.flags["move_weight"].split(",")]
    trial.flags["move_weight"] = ",".join(f"{weight:.6g}" for weight in weights)


def start_up(trial):
    """The record begins while the plant comes from elsewhere."""
    settling = trial.plant.settling
    trial.set_points = [
        *((name, 0.02 * settling, -signed(trial, 1.5) * trial.steps[name])
          for name in trial.outputs),
        *((name, at + settling, value) for name, at, value in trial.changes())]
    begin = (0.02 + trial.random.uniform(0.05, 0.1)) * settling

    def change(case):
        first = next(k for k, time in enumerate(case.columns["time"]) if float(time) >= begin)
        case.columns = {name: values[first:] for name, values in case.columns.items()}
    trial.spoil.append(change)


def jitter(trial):
    period = trial.plant.sample_time

    def change(case):
        case.columns["time"] = [
            f"{float(time) + trial.random.uniform(-0.3, 0.3) * period:.6f}"
            for time in case.columns["time"]]
    trial.spoil.append(change)


def add_noise(trial, draw):
    """Noise of the record alone: draw(time as a part of the record) in standard deviations."""
    def change(case):
        duration = float(case.columns["time"][-1])
        times = [float(time) / duration for time in case.columns["time"]]
        for name in trial.outputs:
            case.columns[name] = [
                repr(float(value) + trial.deviations[name] * draw(time)) if value else value
                for time, value in zip(times, case.columns[name])]
    trial.spoil.append(change)


def heavy_tails(trial):
    """Student's t with two degrees of freedom."""
    trial.noise = 0.3
    add_noise(trial, lambda time: trial.random.gauss(0.0, 1.0) /
              math.sqrt(trial.random.gammavariate(1.0, 1.0)))


def changing_variance(trial):
    start = trial.random.uniform(0.1, 0.6)
    add_noise(trial, lambda time: (4.0 if start < time < start + 0.35 else 0.5) *
              trial.random.gauss(0.0, 1.0))


def collinear(trial):
    """All set points move together."""
    settling = trial.plant.settling
    directions = [trial.random.choice((-1, 1)) for _ in trial.outputs]
    trial.set_points = [(name, settling * (i + 0.6), value * direction * trial.steps[name])
                        for i, value in enumerate(levels(trial, 2 * ROUNDS))
                        for name, direction in zip(trial.outputs, directions)]


def one_output(trial):
    name = trial.any_output()
    trial.set_points = [(name, trial.plant.settling * (i + 0.6), value * trial.steps[name])
                        for i, value in enumerate(levels(trial, 2 * ROUNDS))]


def measured_disturbance(trial):
    steps = []
    for name in trial.disturbances:
        steps += [f"{name}:{at + 0.5 * trial.plant.settling:.6g}:"
                  f"{value * 2 * trial.sizes[name]:.6g}"
                  for (_, at, _), value in zip(trial.changes(),
                                               levels(trial, len(trial.changes())))]
    trial.flags["disturbances"] = ",".join(steps)


def slower_downwards(trial):
    place = ageing.some_elements(trial, 1)[0]
    element = trial.truth["elements"][place]
    trial.where = element["output"]
    trial.schedule.append({"output": element["output"], "input": element["input"],
                           "falling": trial.about(1.6, 1.2)})


def backlash(trial):
    actuator(trial)
    trial.input(trial.where)["actuator"]["stiction"] = (
        trial.about(0.12) * trial.sizes[trial.where])


def stiction(trial):
    backlash(trial)
    options = trial.input(trial.where)["actuator"]
    options["jump"] = trial.about(0.5) * options["stiction"]


def equal_percentage(trial):
    actuator(trial, rangeability=trial.about(30))
    trial.input(trial.where)["actuator"]["span"] = trial.about(6) * trial.sizes[trial.where]


def reversed_sign(trial):
    trial.where = trial.any_moved()
    trial.spoil.append(lambda case: case.scale(trial.where, -1.0))


FAMILIES = {
    "nothing else": Family(lambda trial: None, linear=True),
    "curved output": Family(curved_output, ("curved_output",)),
    "logarithmic output": Family(logarithmic, ("curved_output",)),
    "S-shaped output": Family(s_shaped, ("curved_output",)),
    "rate limit": Family(rate_limit, ("rate_limit",)),
    "split range": Family(split_range, ("curved_input",)),
    "hidden saturation": Family(hidden_saturation, ("saturation", "curved_input")),
    "load at set-point changes": Family(
        load_with_set_points, ("load_with_set_points", "missing")),
    "feed with set points": Family(feed_with_set_points, ("load_with_set_points", "missing")),
    "unmeasured feedforward": Family(unmeasured_feedforward, ("load_with_set_points", "missing")),
    "averages stamped at their end": Family(
        effects.averages_at_end, ("averaged", "output_clock", "input_clock")),
    "averages stamped at their start": Family(
        effects.averages_at_start, ("averaged", "output_clock", "input_clock")),
    "third order": Family(third_order, ("higher_order",)),
    "late output": Family(late_output, ("output_clock",)),
    "late input": Family(late_input, ("input_clock",)),
    "fast analyser": Family(fast_analyser, ("output_clock", "dead_time"), linear=True),
    "gains fall during the record": Family(
        gains_fall, ("level_change", "change_during_record", "gain")),
    "temporary change": Family(temporary_change, ("level_change", "change_during_record")),
    "recycle": Family(recycle, ("higher_order", "missing")),
    "slow loads": Family(slow_loads, ("drift",), linear=True),
    "sine and rounding": Family(sine_and_rounding, linear=True),
    "sensor drift": Family(sensor_drift, ("drift",), linear=True),
    "recalibration": Family(recalibration, ("step", "drift"), linear=True),
    "controller off": Family(controller_off, linear=True),
    "inputs overridden": Family(input_overrides, linear=True),
    "set points overridden": Family(set_point_overrides, linear=True),
    "retuned controller": Family(retuned, linear=True),
    "start-up": Family(start_up, linear=True),
    "shutdown": Family(shutdown, linear=True),
    "jitter": Family(jitter, linear=True),
    "heavy tails": Family(heavy_tails, linear=True),
    "changing variance": Family(changing_variance, linear=True),
    "collinear set points": Family(collinear, linear=True),
    "one output excited": Family(one_output, linear=True),
    "measured disturbance": Family(measured_disturbance, linear=True, disturbed=True),
    "slower downwards, three rounds": Family(slower_downwards, ("direction",)),
    "backlash of one valve": Family(backlash, ("backlash",)),
    "stiction of one valve": Family(stiction, ("backlash", "stiction")),
    "equal percentage": Family(equal_percentage, ("curved_input",)),
    "reversed sign": Family(reversed_sign, ("reversed", "mistake")),
}


def levels(trial, count):
    """Levels in [-1.2, 1.2], each at least a half from the one before."""
    values = [0.0]
    while len(values) <= count:
        value = trial.random.uniform(-1.2, 1.2)
        if abs(value - values[-1]) >= 0.5:
            values.append(value)
    return values[1:]


def set_points(trial):
    """Each output in turn, up and down."""
    moves = {name: levels(trial, ROUNDS) for name in trial.outputs}
    return [(name, trial.plant.settling * (len(trial.outputs) * i + k + 0.6),
             moves[name][i] * trial.steps[name])
            for i in range(ROUNDS) for k, name in enumerate(trial.outputs)]


def age(trial):
    """One parameter of one element that matters; the smallest changes are those of ageing.py."""
    place = ageing.some_elements(trial, 1)[0]
    code = trial.random.choice(AGEING_CODES)
    if code == "gain":
        ageing.change(trial, place, gain=ageing.gain_factor(trial))
    elif code == "time_constant":
        ageing.change(trial, place, time_constant=trial.random.choice(
            (trial.random.uniform(0.6, 0.75), trial.random.uniform(1.35, 1.7))))
    else:
        ageing.change(trial, place, delay=trial.random.uniform(0.2, 0.4) * trial.time_constant)
    element = trial.truth["elements"][place]
    trial.aged = {"output": element["output"], "input": element["input"], "code": code}


def plant_of(name, names, i):
    """The plants in turn, others first for every family."""
    if FAMILIES[name].disturbed:
        names = [plant for plant in names if plants.PLANTS[plant].disturbances()]
    return names[(i + list(FAMILIES).index(name)) % len(names)]


def make(trial, kind, name):
    trial.set_points = set_points(trial)
    if trial.disturbances:
        trial.flags["disturbance_variance"] = ",".join(
            f"{(0.2 * trial.sizes[name]) ** 2:.6g}" for name in trial.inputs)
        trial.flags["disturbance_time_constant"] = 3 * trial.time_constant
    FAMILIES[name].happen(trial)
    if kind == "aged":
        age(trial)
    trial.codes = FAMILIES[name].codes


def told_by(result):
    """The explanations, and the mistakes in tags, signs and units that it takes for reasons; None
    of a result without explanations."""
    if result is None or "explanations" not in result:
        return None
    return result["explanations"] + [
        {"explanation": "mistake", "text": reason["text"]}
        for reason in result.get("reasons", []) if reason["code"] == "mistake"]


def names_it(told, code, *places):
    """Whether an explanation that was told is this one, of all these channels."""
    where = [part for value in told.values() if isinstance(value, str)
             for part in [value, *value.split("/")]]
    return told["explanation"] == code and all(
        place is None or place in where or f" {place} " in told.get("text", "")
        for place in places)


def reason_true(trial, result):
    """Whether what is told is true: of what is no ageing, if that is told. None where nothing is
    told, and nothing is to be told."""
    told = told_by(result)
    if told is None:
        return None
    others = [one for one in told if one["explanation"] not in AGEING_CODES]
    true = [(code, trial.where) for code in trial.codes]
    if trial.aged and not others:
        true.append((trial.aged["code"], trial.aged["output"], trial.aged["input"]))
    if not true and not told:
        return None
    return any(names_it(one, *what) for one in others or told for what in true)


def gives_reasons(row):
    """Whether an answer needs one beside ageing: it cannot tell, or it tells one."""
    return (row["decision"] in ("cannot_tell", "no_answer") or
            any(one["explanation"] not in AGEING_CODES for one in row.get("told") or []))


def judged(trial, result):
    """The columns of a row that tell whether the right thing was said."""
    told = told_by(result) or []
    return {"codes": list(trial.codes), "aged": trial.aged, "named": named(trial, result),
            "told": told, "reason_true": reason_true(trial, result)}


def named(trial, result, threshold=0.02):
    """Whether the elements that are written anew are the one that has aged."""
    if not trial.aged:
        return ""
    changed = set()
    if result is not None and result["decision"] == "corrected":
        outputs, inputs = trial.outputs, trial.inputs
        changed = {(outputs[i], inputs[j])
                   for i, line in enumerate(result["distance"]["elements"])
                   for j, value in enumerate(line) if value is not None and value > threshold}
    aged = (trial.aged["output"], trial.aged["input"])
    if not changed:
        return "missed"
    if aged not in changed:
        return "not named, another is"
    return "named exactly" if len(changed) == 1 else "named with others"
