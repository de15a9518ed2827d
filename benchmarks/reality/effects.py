"""What happens to a plant and to its record, whether something has aged or not, one at a time.

Each is a function that changes a Trial. Sizes are drawn from the trial's own random numbers, in
steps of the set points, inputs that make such steps, and the plant's time constant, so that
no scenario is ever the same twice and all plants are treated alike.
"""

import cmath
import math

import plants


def each_output(trial, size):
    """A list of sizes in steps of the outputs, as a flag has them."""
    return ",".join(f"{size * trial.steps[name]:.6g}" for name in trial.outputs)


def archive(trial, names, **options):
    """Historian's options of some tags; deviations in standard deviations of the noise."""
    for name in names:
        is_output = name in trial.outputs
        size = trial.deviations[name] if is_output else trial.plant.noise * trial.sizes[name]
        tag = (trial.output if is_output else trial.input)(name).setdefault("archive", {})
        for key, value in options.items():
            tag[key] = value * size if key in ("exception", "compression") else value


def white(trial):
    pass


def white_small(trial):
    trial.noise = trial.about(0.1)


def white_large(trial):
    trial.noise = trial.about(3.0)


def one_window(trial):
    trial.rounds = 0


def two_rounds(trial):
    trial.rounds = 2


def drift(trial):
    variance = trial.about(1e-6, 3)
    trial.flags["drift_variance"] = ",".join(
        f"{variance * trial.steps[name] ** 2:.6g}" for name in trial.outputs)


def quantised(trial):
    trial.flags["quantum"] = each_output(trial, trial.about(0.04))
    trial.flags["faults_only_in_record"] = True


def lost(trial):
    trial.flags["lost_probability"] = trial.about(0.05)
    trial.flags["lost_input_probability"] = trial.about(0.02)
    trial.flags["faults_only_in_record"] = True


def outliers(trial):
    trial.flags["outlier_probability"] = trial.about(0.01)
    trial.flags["outlier_size"] = each_output(trial, trial.about(1.5))
    trial.flags["faults_only_in_record"] = True


def frozen(trial):
    trial.flags["freeze_rate"] = trial.about(1.0) / trial.plant.settling
    trial.flags["freeze_duration"] = trial.about(5) * trial.plant.sample_time
    trial.flags["faults_only_in_record"] = True


def historian(trial):
    quantised(trial)
    lost(trial)
    outliers(trial)


def swinging_door(trial):
    archive(trial, trial.outputs, compression=trial.about(2))


def swinging_door_two_rounds(trial):
    two_rounds(trial)
    swinging_door(trial)


def swinging_door_fine(trial):
    archive(trial, trial.outputs, compression=trial.about(0.7))


def swinging_door_inputs(trial):
    swinging_door(trial)
    archive(trial, trial.inputs, compression=trial.about(1))


def exception(trial):
    archive(trial, trial.outputs, exception=trial.about(2))


def exception_and_door(trial):
    archive(trial, trial.outputs + trial.inputs, exception=trial.about(0.5),
            compression=trial.about(1))


def sines(trial, amplitude):
    for name in trial.outputs:
        trial.output(name)["sines"] = [{
            "amplitude": trial.about(amplitude) * trial.steps[name],
            "period": trial.about(2.5, 2) * trial.time_constant}]


def sine(trial):
    sines(trial, 0.2)


def sine_two_rounds(trial):
    two_rounds(trial)
    sines(trial, 0.1)


def sine_slow(trial):
    name = trial.any_output()
    trial.output(name)["sines"] = [{"amplitude": trial.about(0.3) * trial.steps[name],
                                    "period": trial.about(15) * trial.time_constant}]


def loads(trial, deviation):
    memory = trial.about(5, 2) * trial.time_constant
    for name in trial.inputs:
        trial.input(name)["load"] = {
            "variance": (trial.about(deviation) * trial.sizes[name]) ** 2,
            "time_constant": memory}


def load(trial):
    loads(trial, 0.15)


def load_two_rounds(trial):
    two_rounds(trial)
    loads(trial, 0.15)


def load_small(trial):
    loads(trial, 0.04)


def load_steps(trial):
    name = trial.any_input()
    at = trial.random.uniform(0.2, 0.9) * trial.duration()
    trial.input(name)["load"] = {"steps": [[at, trial.about(0.3) * trial.sizes[name]]]}


def coloured(trial):
    variance = trial.about(0.1, 1.3) ** 2
    trial.flags["coloured_variance"] = ",".join(
        f"{variance * trial.steps[name] ** 2:.6g}" for name in trial.outputs)
    trial.flags["coloured_time_constant"] = trial.about(1.3, 2) * trial.time_constant


def coloured_two_rounds(trial):
    two_rounds(trial)
    coloured(trial)


def coloured_one_window(trial):
    one_window(trial)
    coloured(trial)


def resonant(trial):
    """A pair of poles with a period of some time constants."""
    period = trial.about(2) * trial.time_constant / trial.plant.sample_time
    pole = 0.98 * cmath.exp(2j * cmath.pi / period)
    for name in trial.outputs:
        trial.output(name)["arma"] = {"poles": [[pole.real, pole.imag]],
                                      "variance": (trial.about(0.06) * trial.steps[name]) ** 2}


def random_steps(trial):
    trial.flags["disturbance_step_rate"] = trial.about(0.7) / trial.plant.settling
    trial.flags["disturbance_step_deviation"] = each_output(trial, trial.about(0.25))


def one_step(trial):
    name = trial.any_output()
    at = trial.random.uniform(0.2, 0.95) * trial.duration()
    trial.output(name)["steps"] = [[at, trial.about(0.3) * trial.steps[name]]]


def backlash(trial):
    for name in trial.inputs:
        trial.input(name)["actuator"] = {"stiction": trial.about(0.07) * trial.sizes[name]}


def stiction(trial):
    name = trial.any_input()
    size = trial.about(0.08) * trial.sizes[name]
    trial.input(name)["actuator"] = {"stiction": size, "jump": trial.about(0.5) * size}


def equal_percentage(trial):
    """The gain changes by some tens of per cent over the range of the record."""
    name = trial.any_input()
    trial.input(name)["actuator"] = {"rangeability": trial.about(30),
                                     "span": trial.about(10) * trial.sizes[name]}


def sensor_lag(trial):
    """The lag has always been there: model and plant have it, which the sensor adds."""
    name = trial.any_output()
    lag = trial.about(0.2) * trial.time_constant
    trial.output(name)["sensor"] = {"lag": lag}
    trial.model["elements"] = plants.lagged(trial.model["elements"], name, lag)
    trial.sensor_lag = (name, lag)


def clock_output(trial):
    archive(trial, [trial.any_output()],
            clock_offset=trial.random.choice((-1, 1)) * trial.about(3) * trial.plant.sample_time)


def clock_input(trial):
    archive(trial, [trial.any_input()], step=True,
            clock_offset=trial.random.choice((-1, 1)) * round(trial.about(3)) *
            trial.plant.sample_time)


def input_spike(trial):
    """One sample of an input is wrong, where the controller moves."""
    name = trial.any_input()
    _, at, _ = trial.random.choice(trial.changes())
    at += trial.plant.control_period
    archive(trial, [name], step=True,
            spikes=[[at, trial.random.choice((-1, 1)) * trial.about(5) * trial.sizes[name]]])


def output_spike(trial):
    name = trial.any_output()
    at = trial.random.uniform(0.1, 0.9) * trial.duration()
    archive(trial, [name], spikes=[[at, trial.about(10) * trial.steps[name]]])


def dead_sensor(trial):
    at = trial.random.choice((0.0, trial.random.uniform(0.2, 0.7) * trial.duration()))
    trial.output(trial.any_output())["sensor"] = {"dead_from": at}
    trial.flags["faults_only_in_record"] = True


def clipped_sensor(trial):
    name = trial.any_output()
    sign = 1 if trial.plant.steps[trial.outputs.index(name)] > 0 else -1
    limit = sign * trial.random.uniform(0.5, 0.9) * trial.steps[name]
    trial.output(name)["sensor"] = {"max" if sign > 0 else "min": limit}
    trial.flags["faults_only_in_record"] = True


def limited_inputs(trial):
    part = trial.random.uniform(0.4, 0.8)
    limits = [part * trial.sizes[name] for name in trial.inputs]
    trial.flags["max_input"] = ",".join(f"{limit:.6g}" for limit in limits)
    trial.flags["min_input"] = ",".join(f"{-limit:.6g}" for limit in limits)


def ramps(trial):
    length = trial.about(0.25) * trial.plant.settling
    for name, at, value in trial.changes():
        change = trial.steps[name] * (1 if value else -1)
        trial.output(name).setdefault("set_point", {}).setdefault("ramps", []).append(
            [at, length, change])
    trial.length = trial.duration()
    trial.set_points = []


def optimiser(trial):
    """Small moves of all set points beside the large ones."""
    for name in trial.outputs:
        trial.output(name)["set_point"] = {"optimiser": {
            "interval": trial.about(0.1) * trial.plant.settling,
            "deviation": trial.about(0.1) * trial.steps[name]}}


def optimiser_only(trial):
    optimiser(trial)
    trial.length = 4 * trial.plant.settling
    trial.set_points = []


def slower_downwards(trial):
    """An element is heated and cools by itself."""
    element = trial.random.choice(trial.truth["elements"])
    trial.schedule.append({"output": element["output"], "input": element["input"],
                           "falling": trial.about(1.4, 1.2)})


def tour(trial, ranges):
    """Set points over the ranges in which a linear controller holds a non-linear plant."""
    trial.set_points = [
        (trial.outputs[i % 2], trial.plant.settling * (i + 0.6),
         trial.random.uniform(*ranges[i % 2]))
        for i in range(8)]


def far_steps(trial, steps):
    """Two windows, far from the operating point and from each other."""
    trial.set_points = [
        (trial.outputs[output], at * trial.plant.settling, trial.random.uniform(*change))
        for at, (output, change) in zip((0.2, 1.6, 2.8), steps)]


def fast_sampling(trial):
    trial.flags["sample_time"] = trial.plant.sample_time / 4


def slow_sampling(trial):
    trial.flags["sample_time"] = trial.plant.control_period * 2
    trial.flags["control_period"] = trial.plant.control_period * 2
    trial.flags["prediction_horizon"] = trial.plant.horizon // 2


def manual(trial, names, start, length, change):
    """Inputs in manual, times in parts of the record."""
    duration = trial.duration()
    for name in names:
        trial.input(name).setdefault("manual", []).append(
            [start * duration, (start + length) * duration, change * trial.sizes[name]])


def averages(trial, at_end, declared=False):
    """All tags are means in time over a third of a time constant, stamped at its end or beginning:
    of inputs held from row to row, of outputs on lines between rows; set points are what holds at
    the stamp. Where it is declared, the model says so."""
    period = trial.plant.control_period
    length = max(2, round(trial.about(0.3, 1.3) * trial.time_constant / period))
    samples = length * round(period / trial.plant.sample_time)

    def change(case):
        columns = case.columns
        blocks = range(0, len(columns["time"]) - samples, samples)
        for name in columns:
            values = columns[name]
            if name == "time" or name.endswith("_setpoint"):
                columns[name] = [values[k + samples if at_end else k] for k in blocks]
                continue
            numbers = [float(value) for value in values]
            if name in trial.outputs:
                numbers = [0.5 * (a + b) for a, b in zip(numbers, numbers[1:])]
            columns[name] = [repr(math.fsum(numbers[k:k + samples]) / samples) for k in blocks]
        for channel in (case.model["inputs"] + case.model["outputs"]) * declared:
            channel["sampling"] = {"average": length * period,
                                   "stamp": "end" if at_end else "start"}
    trial.spoil.append(change)


def averages_at_end(trial):
    averages(trial, True)


def averages_at_start(trial):
    averages(trial, False)


def declared_averages_at_end(trial):
    averages(trial, True, declared=True)


def declared_averages_at_start(trial):
    averages(trial, False, declared=True)


def measured_every(trial, samples, held):
    """Outputs are measured every so many samples, to within a thousandth of a step, and held, or
    the fields between are empty."""
    trial.rounds = 4

    def change(case):
        for name in trial.outputs:
            values = case.columns[name]
            digits = 3 - math.floor(math.log10(trial.steps[name]))
            values = [f"{float(value):.{digits}f}" for value in values]
            case.columns[name] = [values[k - k % samples] if held or k % samples == 0 else ""
                                  for k in range(len(values))]
    trial.spoil.append(change)


def laboratory(trial, held):
    """A sample in about a time constant, as every four hours of a slow column."""
    measured_every(trial, round(trial.about(1) * trial.time_constant / trial.plant.sample_time),
                   held)


def laboratory_empty(trial):
    laboratory(trial, held=False)


def laboratory_held(trial):
    laboratory(trial, held=True)


def analyser_10(trial):
    measured_every(trial, 10, held=True)


def analyser_30(trial):
    measured_every(trial, 30, held=True)


def by_hand(trial):
    """An input is put in manual and moved three times, as its mode says."""
    name = trial.any_moved()
    for k in range(3):
        manual(trial, [name], (k + trial.random.uniform(0.2, 0.6)) / 3,
               trial.random.uniform(0.04, 0.08),
               trial.random.choice((-1, 1)) * trial.about(0.4))
    periods = [period[:2] for period in trial.input(name)["manual"]]

    def change(case):
        case.columns["mode"] = [
            "MAN" if any(begin <= float(time) < end for begin, end in periods) else "CAS"
            for time in case.columns["time"]]
        case.header.append("mode")
    trial.spoil.append(change)
    trial.correct["mode_tag"] = f"mode={name}"


def limited_moves(trial):
    """Inputs reach limits while they move, and not where they come to rest."""
    limits = [trial.random.uniform(1.05, 1.3) * trial.sizes[name] for name in trial.inputs]
    trial.flags["max_input"] = ",".join(f"{limit:.6g}" for limit in limits)
    trial.flags["min_input"] = ",".join(f"{-limit:.6g}" for limit in limits)


def white_and_walk(trial):
    white_large(trial)
    drift(trial)


def everything(trial):
    """A little of many things, as an ordinary plant has it."""
    coloured(trial)
    quantised(trial)
    lost(trial)
    backlash(trial)
    two_rounds(trial)


EFFECTS = {
    "white noise": white,
    "white noise, small": white_small,
    "white noise, large": white_large,
    "white noise, one window": one_window,
    "white noise, two rounds": two_rounds,
    "random walk": drift,
    "large noise and random walk": white_and_walk,
    "quantised": quantised,
    "lost samples": lost,
    "outliers": outliers,
    "frozen": frozen,
    "quantised, losses, outliers": historian,
    "swinging door, 2σ": swinging_door,
    "swinging door, 2σ, two rounds": swinging_door_two_rounds,
    "swinging door, 0.7σ": swinging_door_fine,
    "swinging door, inputs too": swinging_door_inputs,
    "exception reporting, 2σ": exception,
    "exceptions and door, all tags": exception_and_door,
    "sine, 0.2": sine,
    "sine, 0.1, two rounds": sine_two_rounds,
    "slow sine, one output": sine_slow,
    "AR(1) loads": load,
    "AR(1) loads, two rounds": load_two_rounds,
    "AR(1) loads, small": load_small,
    "step of a load": load_steps,
    "coloured": coloured,
    "coloured, two rounds": coloured_two_rounds,
    "coloured, one window": coloured_one_window,
    "resonant ARMA": resonant,
    "unmeasured steps": random_steps,
    "one unmeasured step": one_step,
    "backlash": backlash,
    "stiction": stiction,
    "equal-percentage valve": equal_percentage,
    "sensor lag": sensor_lag,
    "slower downwards": slower_downwards,
    "clock of an output": clock_output,
    "clock of an input": clock_input,
    "spike in an input at a move": input_spike,
    "spike in an output": output_spike,
    "dead sensor": dead_sensor,
    "clipped sensor": clipped_sensor,
    "inputs at limits": limited_inputs,
    "inputs at limits while they move": limited_moves,
    "ramps": ramps,
    "optimiser and steps": optimiser,
    "optimiser alone": optimiser_only,
    "fast sampling": fast_sampling,
    "slow sampling": slow_sampling,
    "averages stamped at their end": averages_at_end,
    "averages stamped at their start": averages_at_start,
    "averages stamped at their end, declared": declared_averages_at_end,
    "averages stamped at their start, declared": declared_averages_at_start,
    "laboratory": laboratory_empty,
    "laboratory, held": laboratory_held,
    "analyser, 10 samples": analyser_10,
    "analyser, 30 samples": analyser_30,
    "by hand, with a mode": by_hand,
    "many things": everything,
}

# Where nothing stands between the method and its own world.
CLEAN = {"white noise", "white noise, small", "white noise, two rounds", "random walk",
         "quantised", "lost samples", "outliers", "quantised, losses, outliers"}
