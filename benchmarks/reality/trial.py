"""One trial of the benchmark: a plant, what the controller believes of it, and what happens."""

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
    true_gains: dict = dataclasses.field(default_factory=dict)  # factors at the end, by element
    factors: dict = None  # how a plant with equations has aged
    spoil: list = dataclasses.field(default_factory=list)  # changes of a mistakes.Case, in turn
    codes: tuple = ()  # of the explanations that are true, beside ageing
    where: str = None  # the channel of which they are true
    aged: dict = None  # the only parameter that has aged

    def __post_init__(self):
        self.model = self.plant.read()
        self.truth = copy.deepcopy(self.model)
        self.flags = self.plant.flags()
        self.inputs = [channel["name"] for channel in self.model["inputs"]]
        self.disturbances = plants.disturbances(self.model)
        self.moved = [name for name in self.inputs if name not in self.disturbances]
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

    def any_moved(self):
        return self.random.choice(self.moved)

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

    def ageing_file(self):
        if self.plant.simulated:
            return self.factors or {}
        return {"elements": self.schedule}

    def true_model(self):
        """What the controller's model would have to be at the end of the record: the plant, with
        the lag of its sensor."""
        truth = copy.deepcopy(self.truth)
        for place, factor in self.true_gains.items():
            truth["elements"][place] = plants.aged(truth["elements"][place], gain=factor)
        if self.sensor_lag is not None:
            truth["elements"] = plants.lagged(truth["elements"], *self.sensor_lag)
        return truth

    def effects_file(self):
        """The effects with the white noise of every output, which differs between outputs."""
        effects = copy.deepcopy(self.effects)
        for name in self.outputs:
            sensor = effects["outputs"].setdefault(name, {}).setdefault("sensor", {})
            sensor["noise_variance"] = (self.noise * self.deviations[name]) ** 2
        return {kind: [{"name": name, **what} for name, what in channels.items()]
                for kind, channels in effects.items() if channels}
