"""The scenarios of the benchmark: what happens to a plant and to its record, one at a time.

A scenario is a function that changes a Trial. Sizes are drawn from the trial's own random numbers,
in steps of the set points, inputs that make such steps, and the plant's time constant, so that
no scenario is ever the same twice and all plants are treated alike.
"""

import cmath
import copy
import dataclasses
import random

import plants


@dataclasses.dataclass
class Trial:
    """One run: what the controller believes, what is true, and what happens."""

    plant: plants.Plant
    random: random.Random
    model: dict = None
    truth: dict = None
    flags: dict = None
    correct: dict = dataclasses.field(default_factory=dict)
    effects: dict = dataclasses.field(default_factory=lambda: {"outputs": {}, "inputs": {}})
    schedule: list = dataclasses.field(default_factory=list)
    rounds: float = 1  # each output steps so many times; 0: the first alone
    noise: float = 1.0  # of the plant's
    set_points: list = None  # instead of rounds
    length: float = None  # of the run, instead of what the steps need
    sensor_lag: tuple = None  # (output, time constant)
    true_gain: tuple = None  # (element, factor) at the end of a schedule

    def __post_init__(self):
        self.model = self.plant.read()
        self.truth = copy.deepcopy(self.model)
        self.flags = self.plant.flags()
        self.inputs = [channel["name"] for channel in self.model["inputs"]]
        self.outputs = [channel["name"] for channel in self.model["outputs"]]
        self.sizes = dict(zip(self.inputs, plants.input_sizes(self.model, self.plant.steps)))
        self.steps = dict(zip(self.outputs, (abs(step) for step in self.plant.steps)))
        self.deviations = {name: self.plant.noise * step for name, step in self.steps.items()}
        times = sorted(plants.times_of(element) for element in self.model["elements"])
        self.time_constant = times[len(times) // 2]

    def about(self, value, spread=1.4):
        """A value between value / spread and value · spread."""
        return value * spread ** self.random.uniform(-1.0, 1.0)

    def output(self, name):
        return self.effects["outputs"].setdefault(name, {})

    def input(self, name):
        return self.effects["inputs"].setdefault(name, {})

    def any_output(self):
        return self.random.choice(self.outputs)

    def any_input(self):
        return self.random.choice(self.inputs)

    def changes(self):
        """(output, time, value) of the set points' steps, and the length of the run."""
        if self.set_points is not None:
            return self.set_points
        settling = self.plant.settling
        steps = []
        count = max(1, round(self.rounds * len(self.outputs)))
        for i in range(count):
            place = i % len(self.outputs)
            up = (i // len(self.outputs)) % 2 == 0
            steps.append((self.outputs[place], settling * (i + 0.6),
                          self.plant.steps[place] if up else 0))
        return steps

    def duration(self):
        if self.length is not None:
            return self.length
        return max((time for _, time, _ in self.changes()), default=0) + self.plant.settling

    def record_flags(self):
        flags = dict(self.flags)
        flags["setpoints"] = ",".join(f"{name}:{time:.10g}:{value:.10g}"
                                      for name, time, value in self.changes())
        flags["duration"] = f"{self.duration():.10g}"
        flags["noise_variance"] = 0  # the sensors have their own
        return flags

    def true_model(self):
        """What the controller's model would have to be at the end of the record: the plant, with
        the lag of its sensor."""
        truth = copy.deepcopy(self.truth)
        if self.true_gain is not None:
            place, factor = self.true_gain
            truth["elements"][place] = plants.aged(truth["elements"][place], gain=factor)
        if self.sensor_lag is not None:
            truth["elements"] = lagged(truth["elements"], *self.sensor_lag)
        return truth

    def effects_file(self):
        """The effects with the white noise of every output, which differs between outputs."""
        effects = copy.deepcopy(self.effects)
        for name in self.outputs:
            sensor = effects["outputs"].setdefault(name, {}).setdefault("sensor", {})
            sensor["noise_variance"] = (self.noise * self.deviations[name]) ** 2
        return {kind: [{"name": name, **what} for name, what in channels.items()]
                for kind, channels in effects.items() if channels}


def lagged(elements, output, lag):
    return [plants.with_factor(element, [1.0], [lag, 1.0]) if element["output"] == output
            else element for element in elements]


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


# ---- what happens, whether something has aged or not ----------------------------------------

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
    trial.model["elements"] = lagged(trial.model["elements"], name, lag)
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


def fast_sampling(trial):
    trial.flags["sample_time"] = trial.plant.sample_time / 4


def slow_sampling(trial):
    trial.flags["sample_time"] = trial.plant.control_period * 2
    trial.flags["control_period"] = trial.plant.control_period * 2
    trial.flags["prediction_horizon"] = trial.plant.horizon // 2


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


# ---- how plants age --------------------------------------------------------------------------

def change(trial, place, **how):
    trial.truth["elements"][place] = plants.aged(trial.truth["elements"][place], **how)


def gain_factor(trial):
    return trial.random.choice((trial.random.uniform(0.5, 0.75), trial.random.uniform(1.3, 1.6)))


def some_elements(trial, largest=3):
    """Places of elements that matter: those whose input does something to their output."""
    weights = [abs(plants.static_gain(element)) * trial.sizes[element["input"]] /
               trial.steps[element["output"]] for element in trial.model["elements"]]
    places = [i for i, weight in enumerate(weights) if weight > 0.1]
    return trial.random.sample(places, min(len(places), trial.random.randint(1, largest)))


def gains_aged(trial):
    for place in some_elements(trial):
        change(trial, place, gain=gain_factor(trial))


def time_constants_aged(trial):
    for place in some_elements(trial):
        change(trial, place, time_constant=trial.random.choice((
            trial.random.uniform(0.6, 0.75), trial.random.uniform(1.35, 1.7))))


def delays_aged(trial):
    for place in some_elements(trial):
        change(trial, place, delay=trial.random.uniform(0.2, 0.4) * trial.time_constant)


def some_aged(trial):
    """Some elements, each in one of three ways."""
    for place in some_elements(trial):
        kind = trial.random.randrange(3)
        if kind == 0:
            change(trial, place, gain=gain_factor(trial))
        elif kind == 1:
            change(trial, place, time_constant=trial.random.uniform(1.35, 1.7))
        else:
            change(trial, place, delay=trial.random.uniform(0.2, 0.4) * trial.time_constant)


def small_gain(trial):
    change(trial, some_elements(trial, 1)[0], gain=trial.random.choice((0.92, 1.08)))


def lead(trial):
    """A shape that changes a little and no parameter of the structure."""
    place = some_elements(trial, 1)[0]
    element = trial.truth["elements"][place]
    time = trial.about(0.25) * plants.times_of(element)
    trial.truth["elements"][place] = plants.with_factor(element, [time, 1.0], [0.5 * time, 1.0])


def second_order(trial):
    place = some_elements(trial, 1)[0]
    element = trial.truth["elements"][place]
    time = trial.about(0.5) * plants.times_of(element)
    trial.truth["elements"][place] = plants.with_factor(element, [1.0], [time, 1.0])


def scheduled(trial, points):
    """A gain that changes while the record is made; true is what holds at its end."""
    place = some_elements(trial, 1)[0]
    element = trial.truth["elements"][place]
    factor = gain_factor(trial)
    trial.schedule.append({"output": element["output"], "input": element["input"],
                           "gain": [[at * trial.duration(), 1.0 + part * (factor - 1.0)]
                                    for at, part in points]})
    trial.true_gain = (place, factor)


def step_in_record(trial):
    two_rounds(trial)
    at = trial.random.uniform(0.35, 0.65)
    scheduled(trial, [(at, 0), (at, 1)])


def drift_in_record(trial):
    two_rounds(trial)
    scheduled(trial, [(0, 0), (1, 1)])


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
    "clock of an output": clock_output,
    "clock of an input": clock_input,
    "spike in an input at a move": input_spike,
    "spike in an output": output_spike,
    "dead sensor": dead_sensor,
    "clipped sensor": clipped_sensor,
    "inputs at limits": limited_inputs,
    "ramps": ramps,
    "optimiser and steps": optimiser,
    "optimiser alone": optimiser_only,
    "fast sampling": fast_sampling,
    "slow sampling": slow_sampling,
    "many things": everything,
}

# Where nothing stands between the method and its own world.
CLEAN = {"white noise", "random walk", "quantised", "lost samples", "outliers",
         "quantised, losses, outliers"}

# What has aged, where nothing else happens.
AGEING = {
    "gains": gains_aged,
    "time constants": time_constants_aged,
    "dead times": delays_aged,
    "a gain by 8 %": small_gain,
    "a little lead": lead,
    "second order": second_order,
    "a gain steps during the record": step_in_record,
    "a gain drifts during the record": drift_in_record,
}


def make(plant, kind, name, seed):
    """The trial of a scenario: kind is `none` or `aged`."""
    trial = Trial(plants.PLANTS[plant], random.Random(f"{kind}/{name}/{plant}/{seed}"))
    if kind == "none":
        EFFECTS[name](trial)
    elif name in AGEING:
        AGEING[name](trial)
    else:
        EFFECTS[name](trial)
        some_aged(trial)
    return trial
