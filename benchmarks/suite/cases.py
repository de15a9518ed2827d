"""Cases of the suite: what a method is given, and what is true of it.

A case writes model.json and record.csv to a folder and returns a Truth, which judges models: by
their step responses, by predictions of records held out, and by the loop that they make.
"""

import contextlib
import copy
import csv
import dataclasses
import hashlib
import json
import math
import pathlib
import random
import shutil
import sys
import tempfile
import types

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "benchmarks/real"), str(ROOT / "benchmarks/reality")]
import adversary  # noqa: E402
import mistakes  # noqa: E402
import plants  # noqa: E402
import records  # noqa: E402
import responses  # noqa: E402
import runs  # noqa: E402
import trials  # noqa: E402
from trial import Trial  # noqa: E402

CHANGED = 0.02  # of the norm of a step response, from which an element has been changed
LOOP_FLAGS = ("sample_time", "control_period", "prediction_horizon", "control_horizon",
              "output_weight", "move_weight", "min_input", "max_input")


class NoRecord(RuntimeError):
    """The loop is unstable, however often the case is drawn."""


def number_of(*parts):
    """A number of 31 bits that nobody can guess who does not know the seed."""
    digest = hashlib.sha256("/".join(map(str, parts)).encode()).digest()
    return int.from_bytes(digest[:4], "big") >> 1


@dataclasses.dataclass
class Truth:
    """What is known of a case; what is not is None."""

    given: dict
    true: dict = None  # the model that the controller should have
    interval: float = 1.0  # of the step responses that are compared, and their length
    horizon: float = 1.0
    aged: set = None  # (output, input)
    held: object = None  # runs.Judge of a record that had no part
    times: dict = None  # horizons of its predictions, by output
    loop: dict = None  # flags of mle_simulate, and variances of the noise
    loop_error: object = None  # of a model
    reason_true: object = None  # of a list of reasons
    kind: str = "aged"

    def steps(self, model):
        """Step responses by (output, input), elements of a pair together."""
        samples = round(self.horizon / self.interval) + 1
        result = {}
        for element in model["elements"]:
            pair = element["output"], element["input"]
            result[pair] = result.get(pair, 0.0) + responses.step_response(
                element, self.interval, samples)
        return result

    def distance(self, model):
        """E, and relative E."""
        if self.true is None:
            if self.held is None or not self.held.case.truth:
                return None
            return None, sum(self.held.distances(model).values())
        true, given, tried = self.steps(self.true), self.steps(self.given), self.steps(model)
        total = relative = 0.0
        for pair in sorted(set(true) | set(tried)):
            error = np.sum((true.get(pair, 0.0) - tried.get(pair, 0.0))**2)
            size = next(np.sum(some[pair]**2) for some in (true, given, tried) if pair in some)
            total, relative = total + error, relative + error / size
        return float(total), float(relative)

    def changed(self, model):
        """Pairs whose response differs from that of the model given, and by what at most."""
        before, after = self.steps(self.given), self.steps(model)
        result, largest = set(), 0.0
        for pair in set(before) | set(after):
            old, new = before.get(pair, 0.0), after.get(pair, 0.0)
            size = np.linalg.norm(old) or np.linalg.norm(new) or 1.0
            change = float(np.linalg.norm(new - old) / size)
            largest = max(largest, change)
            if change > CHANGED:
                result.add(pair)
        return result, largest

    def several_step(self, model):
        """Errors of predictions of the record held out, by output."""
        if self.held is None or self.held.case.truth:
            return None
        return self.held.errors(model, self.times)


def pairs_that_differ(given, true):
    return {tuple(change[0].split("/", 1)) for change in runs.changed(given, true)}


def errors_at_set_points(record, outputs, steps):
    """Mean square of outputs less set points, in steps of these, summed over outputs."""
    with record.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return sum(((float(row[name]) - float(row[f"{name}_setpoint"])) / steps[name])**2
               for row in rows for name in outputs if row[name]) / len(rows)


@dataclasses.dataclass(frozen=True)
class Case:
    track: str
    name: str
    plant: str
    kind: str  # "none" or "aged"
    repeat: int

    def key(self):
        return "/".join(map(str, (self.track, self.name, self.plant, self.kind, self.repeat)))

    def files(self):
        """What it is made of, beside the sources."""
        return ()


@dataclasses.dataclass(frozen=True)
class Simulated(Case):
    """A trial of benchmarks/reality."""

    make_trial: object = dataclasses.field(default=None, compare=False)
    horizon: float = None  # of step responses; None: the time between set points

    def write(self, apps, seed, public):
        for attempt in range(10):
            number = number_of(seed, self.key(), attempt)
            trial = self.make_trial(self, number)
            with tempfile.TemporaryDirectory() as folder:
                scratch = pathlib.Path(folder)
                if not trials.simulate(apps, trial, number, scratch):
                    continue
                if trial.spoil:
                    mistakes.spoil(trial.spoil, trial, scratch / "model.json",
                                   scratch / "record.csv")
                self.publish(trial, scratch, public)
                return self.truth(trial, apps, number, json.loads(
                    (public / "model.json").read_text()))
        raise NoRecord(self.key())

    def publish(self, trial, scratch, public):
        for name in ("model.json", "record.csv"):
            shutil.copy(scratch / name, public / name)
        if "mode_tag" in trial.correct:
            tag, _, channel = trial.correct["mode_tag"].partition("=")
            header, _, rows = (public / "record.csv").read_text().partition("\n")
            names = [f"{channel}_mode" if name.strip() == tag else name.strip()
                     for name in header.split(",")]
            (public / "record.csv").write_text(",".join(names) + "\n" + rows)

    def truth(self, trial, apps, number, given):
        sensible = after_the_record(trial)
        aged = None
        if trial.aged:
            aged = {(trial.aged["output"], trial.aged["input"])}
        elif not trial.plant.simulated and self.track != "adversary":
            aged = pairs_that_differ(trial.model, trial.true_model())
        truth = Truth(given=given, true=trial.true_model(), interval=trial.plant.sample_time,
                      horizon=self.horizon or trial.plant.settling,
                      aged=aged if self.kind == "aged" else None, kind=self.kind,
                      loop=loop_flags(trial))
        with tempfile.TemporaryDirectory() as folder:
            scratch = pathlib.Path(folder)
            if trials.simulate(apps, sensible, number_of(number, "held"), scratch):
                truth.held, truth.times = judge_of(scratch / "record.csv", trial.model)
        truth.loop_error = lambda model: loop_error(apps, sensible, model)
        truth.reason_true = lambda reasons: reason_true(trial, reasons)
        return truth


def judge_of(record, model):
    """The judge by a record held out, which is read at once."""
    case = types.SimpleNamespace(record=record, held_out=[record], truth=None)
    judge = runs.Judge(case, model, {})
    return judge, runs.horizons(model, list(judge.unseen.values())[0])


def reason_true(trial, reasons):
    told = [{"explanation": row[0], **{f"of{i}": part for i, part in enumerate(row[1:])}}
            for row in reasons if row]
    return adversary.reason_true(trial, {"explanations": told})


def after_the_record(trial):
    """The plant at the end of the record, its loads, valves and sensors, without what the
    historian does; set points change the other way round."""
    other = copy.copy(trial)
    other.random = random.Random("after")
    other.truth = copy.deepcopy(trial.truth)
    for place, factor in trial.true_gains.items():
        other.truth["elements"][place] = plants.aged(other.truth["elements"][place], gain=factor)
    other.true_gains, other.spoil = {}, []
    other.schedule = [change for change in trial.schedule if "falling" in change]
    other.flags = {key: value for key, value in trial.flags.items()
                   if not key.startswith(("quantum", "lost_", "outlier_", "freeze_",
                                          "faults_only"))}
    other.effects = {kind: {name: historian_removed(what) for name, what in channels.items()}
                     for kind, channels in trial.effects.items()}
    if trial.plant.simulated is None and trial.changes():
        order = dict(zip(trial.outputs, reversed(trial.outputs)))
        points = [(order[name], at, -value / trial.steps[name] * trial.steps[order[name]])
                  for name, at, value in trial.changes()]
        other.length = trial.duration()
        other.set_points = points
    return other


def historian_removed(what):
    kept = {key: copy.deepcopy(value) for key, value in what.items()
            if key not in ("archive", "manual")}
    if "sensor" in kept:
        kept["sensor"] = {key: value for key, value in kept["sensor"].items()
                          if key in ("lag", "curve", "curvature")}
    return kept


def loop_flags(trial):
    """What methods are told that are told the control law."""
    flags = {key: value for key, value in trial.record_flags().items() if key in LOOP_FLAGS}
    return {"flags": flags, "noise_variance": {
        name: (trial.noise * trial.deviations[name])**2 for name in trial.outputs}}


def loop_error(apps, trial, model):
    """The squared error of the loop without noise, each set point stepping once; infinite if it
    is unstable."""
    other = copy.copy(trial)
    other.set_points = other.length = None
    other.rounds, other.noise = 1, 0.0
    kept = (*LOOP_FLAGS, "operating_inputs")
    other.flags = {key: value for key, value in trial.flags.items() if key in kept}
    other.effects = {"inputs": {name: {"actuator": what["actuator"]}
                                for name, what in trial.effects["inputs"].items()
                                if "actuator" in what},
                     "outputs": {name: {"sensor": dict(what["sensor"])}
                                 for name, what in trial.effects["outputs"].items()
                                 if what.get("sensor")}}
    other.model = model
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        with contextlib.suppress(trials.Failed):  # a model that mle_simulate refuses
            if trials.simulate(apps, other, 1, scratch):
                return errors_at_set_points(scratch / "record.csv", trial.outputs, trial.steps)
    return math.inf


@dataclasses.dataclass
class Drawn:
    """A plant with the flags of mle_simulate."""

    given: dict
    plant: dict
    aged: set  # (output, input)
    flags: dict
    held: dict  # flags of the record held out that differ
    interval: float
    horizon: float


@dataclasses.dataclass(frozen=True)
class ByFlags(Case):
    """A plant that is no trial of benchmarks/reality."""

    draw: object = dataclasses.field(default=None, compare=False)  # of the case and random numbers

    def write(self, apps, seed, public):
        number = number_of(seed, self.key())
        drawn = self.draw(self, random.Random(number))
        (public / "model.json").write_text(json.dumps(drawn.given))
        simulate_flags(apps, drawn.given, drawn.plant, {**drawn.flags, "seed": number},
                       public / "record.csv")
        truth = Truth(given=drawn.given, true=drawn.plant, interval=drawn.interval,
                      horizon=drawn.horizon, aged=drawn.aged or None, kind=self.kind,
                      loop={"flags": {key: value for key, value in drawn.flags.items()
                                      if key in LOOP_FLAGS},
                            "noise_variance": {channel["name"]: drawn.flags["noise_variance"]
                                               for channel in drawn.given["outputs"]}})
        with tempfile.TemporaryDirectory() as folder:
            record = pathlib.Path(folder) / "record.csv"
            flags = {**drawn.flags, **drawn.held, "seed": number_of(number, "held")}
            simulate_flags(apps, drawn.given, drawn.plant, flags, record)
            truth.held, truth.times = judge_of(record, drawn.given)
        truth.loop_error = lambda model: loop_error_by_flags(apps, drawn, model)
        return truth


def simulate_flags(apps, model, plant, flags, record):
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (("model", model), ("plant", plant)):
            pathlib.Path(folder, f"{name}.json").write_text(json.dumps(content))
        trials.call((0,), apps / "mle_simulate", f"--model={folder}/model.json",
                    f"--plant={folder}/plant.json", f"--out={record}", *trials.flags_of(flags))


def loop_error_by_flags(apps, drawn, model):
    kept = (*LOOP_FLAGS, "setpoints", "duration")
    flags = {key: value for key, value in drawn.flags.items() if key in kept}
    with tempfile.TemporaryDirectory() as folder:
        record = pathlib.Path(folder) / "record.csv"
        try:
            simulate_flags(apps, model, drawn.plant, {**flags, "noise_variance": 0}, record)
        except trials.Failed:  # unstable, or refused
            return math.inf
        columns = records.read_columns(record)
        outputs = [channel["name"] for channel in model["outputs"]]
        steps = {name: max(abs(float(value)) for value in columns[f"{name}_setpoint"])
                 for name in outputs}
        return errors_at_set_points(record, [name for name in outputs if steps[name]], steps)


@dataclasses.dataclass(frozen=True)
class Real(Case):
    """A run of benchmarks/real: a model, aged on purpose or not, and records."""

    run: object = dataclasses.field(default=None, compare=False)
    declared: dict = dataclasses.field(default=None, compare=False)

    def files(self):
        case = self.run.case
        return [path for path in (case.model, case.record, *case.held_out, case.truth) if path]

    def write(self, apps, seed, public):
        case = self.run.case
        honest = runs.read_model(case.model)
        given = runs.aged(honest, self.run.age)
        (public / "model.json").write_text(json.dumps(given))
        record, begin = public / "record.csv", None
        if case.held_out or case.truth:
            shutil.copy(case.record, record)
        else:
            share = self.declared.get("part", records.SHARE)
            begin = records.last_time(case.record, honest, share)
            records.first_rows(case.record, share, record)
        times = runs.horizons(honest, records.stretches(record, honest))
        known = runs.known_of(case, self.declared)
        aged = None
        if self.run.age:
            aged = {tuple(self.run.age[0].split("/", 1))}
        elif known:
            aged = {(element["output"], element["input"]) for element in honest["elements"]
                    if element["input"] == known["input"]}
        longest = max(time for some in times.values() for time in some)
        return Truth(given=given, held=runs.Judge(case, honest, self.declared, begin),
                     times=times, aged=aged, kind=self.kind, horizon=longest,
                     interval=longest / 300.0)
