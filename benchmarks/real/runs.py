"""One run: a model, aged on purpose or not, corrected from a record and judged on others."""

import copy
import dataclasses
import json
import math
import pathlib
import re
import tempfile

import numpy as np

import least_squares
import plants  # of benchmarks/reality
import records
import responses
import transforms
import trials  # of benchmarks/reality

AGES = ({"gain": 0.6}, {"time_constant": 1.6}, {"delay": 0.3})  # the last in time constants
HORIZONS = (0.2, 1.0, 3.0)  # of the time constant and dead time of an output's largest element
MOST_OUTPUTS = 2  # whose largest element is aged
SAME = 1e-6  # relative, of a parameter that has not been changed


@dataclasses.dataclass(frozen=True)
class Run:
    case: records.Case
    age: tuple = ()  # (pair, parameter, by): factor of a gain or time constant, added dead time
    again: str = ""  # record that a corrected model is corrected from once more

    def name(self):
        parts = [self.case.plant, self.case.model.name, self.case.record.name,
                 " ".join(map(str, self.age)), self.again,
                 f"fitted to {self.case.fitted.name}" if self.case.fitted else ""]
        return "|".join(parts)


def pair_of(element):
    return f"{element['output']}/{element['input']}"


def largest_elements(model, stretches):
    """The largest element of each output, by response times range of the input over range of the
    output; the outputs whose largest is largest first."""
    def span(name):
        values = np.concatenate([stretch.columns[name] for stretch in stretches])
        known = values[np.isfinite(values)]
        return float(np.ptp(known)) if len(known) else 0.0
    largest = {}
    for place, element in enumerate(model["elements"]):
        size = responses.size_at_rest(element) * span(element["input"]) / \
            max(span(element["output"]), 1e-300)
        if size > largest.get(element["output"], (0.0, 0))[0]:
            largest[element["output"]] = (size, place)
    order = sorted(largest, key=lambda output: -largest[output][0])
    return {output: largest[output][1] for output in order}


def ages(model, stretches, plant):
    """What is aged on purpose, run by run."""
    if "aged" in plant:
        for change in plant["aged"]:
            if not any(pair_of(element) == change["pair"] for element in model["elements"]):
                raise records.Wrong(f"aged: the model has no element {change['pair']}")
            (parameter,) = set(change) - {"pair"}
            yield change["pair"], parameter, change[parameter]
        return
    places = list(largest_elements(model, stretches).values())[:MOST_OUTPUTS]
    for place in places:
        element = model["elements"][place]
        for change in AGES:
            ((parameter, by),) = change.items()
            if parameter == "delay":
                by *= responses.typical_time(element) - element["delay"]
            if parameter == "time_constant" and responses.typical_time(element) == \
                    element["delay"]:
                continue  # no lag
            yield pair_of(element), parameter, by


def aged(model, age):
    result = copy.deepcopy(model)
    if age:
        pair, parameter, by = age
        result["elements"] = [plants.aged(element, **{parameter: by})
                              if pair_of(element) == pair else element
                              for element in result["elements"]]
    return result


def read_model(file):
    model = json.loads(file.read_text())
    if "elements" not in model:
        raise records.Wrong(f"{file}: no \"elements\"; the benchmark reads transfer functions")
    return model


def horizons(model, stretches):
    """Times ahead, of each output; the longest at most a quarter of the record."""
    most = max(stretch.time[-1] - stretch.time[0] for stretch in stretches) / \
        (4.0 * max(HORIZONS))
    return {output: [factor * min(responses.typical_time(model["elements"][place]), most)
                     for factor in HORIZONS]
            for output, place in largest_elements(model, stretches).items()}


class Judge:
    """Errors of models on the records that had no part in the correction."""

    def __init__(self, case, model, plant, begin=None):
        self.case, self.plant, self.pairs = case, plant, {pair_of(e) for e in model["elements"]}
        self.begin = begin
        files = [case.record] if begin is not None else case.held_out
        self.unseen = {file.name: records.stretches(file, model) for file in files}

    def errors(self, model, times):
        """By output: the errors at each horizon and of the simulation, over all records; the fit
        of each record."""
        return {output: self.errors_of(model, output, ahead)
                for output, ahead in times.items()}

    def errors_of(self, model, output, ahead):
        moves, simulated, fits, fixed = [[] for _ in ahead], [], {}, []
        for name, stretches in self.unseen.items():
            errors, measured = [], []
            for stretch in stretches:
                error = transforms.errors_of(model, stretch, output)
                if self.begin is not None:
                    error = np.where(stretch.time >= self.begin, error, math.nan)
                if not np.any(np.isfinite(error)):
                    continue
                for some, horizon in zip(moves, ahead):
                    some.append(changes(error, stretch, horizon))
                if "ahead" in self.plant:
                    fixed.append(changes(error, stretch, self.plant["ahead"]))
                errors.append(error - np.nanmean(error))
                measured.append(stretch.columns[output] - np.nanmean(stretch.columns[output]))
            simulated += [error[np.isfinite(error)] for error in errors]
            if errors:
                fits[name] = responses.fit(np.concatenate(errors), np.concatenate(measured))
        if not simulated:
            raise records.Wrong(f"{', '.join(self.unseen)}: nothing is measured of {output}")
        result = {"ahead": [responses.root_mean_square(np.concatenate(some)) for some in moves],
                  "simulated": responses.root_mean_square(np.concatenate(simulated)),
                  "fits": fits}
        if fixed:
            result["fixed"] = responses.root_mean_square(np.concatenate(fixed))
        return result

    def distances(self, model):
        """By pair: ‖s − ŝ‖² / ‖s‖² of the step responses, s the true ones."""
        truth = {name: np.array([records.number(text) for text in column])
                 for name, column in records.read_columns(self.case.truth).items()}
        interval = truth["time"][1] - truth["time"][0]
        elements = {pair_of(element): element for element in model["elements"]}
        result = {}
        for pair in sorted(self.pairs | set(elements)):
            if pair not in truth:
                raise records.Wrong(f"{self.case.truth}: no column \"{pair}\"")
            ours = responses.step_response(elements[pair], interval, len(truth["time"])) \
                if pair in elements else np.zeros(len(truth["time"]))
            result[pair] = float(np.sum((ours - truth[pair])**2) / np.sum(truth[pair]**2))
        return result

    def judge(self, model, times):
        if self.case.truth:
            return {"distances": self.distances(model)}
        return {"outputs": self.errors(model, times)}


def changes(error, stretch, horizon):
    return responses.changes(error, least_squares.steps_ahead(stretch, horizon))


def changed(before, after):
    """Which parameters of which elements differ: [pair, parameter, by, size], `by` the factor of a
    gain or a time constant or what was added to a dead time, `size` its logarithm or its share of
    time constant and dead time."""
    old = {pair_of(element): element for element in before["elements"]}
    new = {pair_of(element): element for element in after["elements"]}
    result = []
    for pair in sorted(set(old) | set(new)):
        if pair not in old or pair not in new:
            result.append([pair, "path", None, math.inf])
            continue
        one, other = old[pair], new[pair]
        if "gain" in one and "gain" in other:
            for key in ("gain", "time_constant"):
                by = other.get(key, 0.0) / one[key] if one.get(key) else 1.0
                size = abs(math.log(by)) if by > 0.0 else math.inf
                result += [[pair, key, by, size]] if size > SAME else []
        elif responses.polynomials(one) != responses.polynomials(other):
            result.append([pair, "shape", None, math.inf])
        by = other["delay"] - one["delay"]
        size = abs(by) / responses.typical_time(one)
        result += [[pair, "delay", by, size]] if size > SAME else []
    return result


def call(command, flags, model, files, scratch, form="model.json"):
    """The decision, the reason, and the corrected model if there is one."""
    scratch.mkdir(exist_ok=True)
    (scratch / "given.json").write_text(json.dumps(model))
    out = scratch / "out"
    try:
        done = trials.call((0, 1, 2), command, f"--model={scratch}/given.json",
                           f"--data={','.join(map(str, files))}", f"--out={out}",
                           "--figures=false", "--threads=1", *flags)
    except trials.Failed as error:
        return "crashed", str(error).splitlines()[1], None
    if not (out / "result.json").exists():
        return "no_answer", done.err.strip().splitlines()[-1][:300], None
    result = json.loads((out / "result.json").read_text())
    reason = (result["verdict"] or [""])[0][:300].replace(str(scratch), "")
    corrected = json.loads((out / form).read_text()) \
        if result["decision"] == "corrected" else None
    return result["decision"], reason, corrected


def flags_of(plant, arguments):
    flags = [*plant.get("flags", "").split(), *arguments.flags.split()]
    if "sample_time" in plant:
        flags.append(f"--sample_time={plant['sample_time']:.10g}")
    return flags


def make(run, plant, arguments):
    """The row of a run, without what its name says."""
    honest = read_model(run.case.model)
    if run.case.fitted:
        seen = records.stretches(run.case.fitted, honest)
        honest = least_squares.correct(honest, seen, horizons(honest, seen))
    given = aged(honest, run.age)
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        record, begin = run.case.record, None
        if not run.case.held_out and not run.case.truth:
            share = plant.get("part", records.SHARE)
            begin = records.last_time(record, honest, share)
            record = scratch / record.name
            records.first_rows(run.case.record, share, record)
        seen = records.stretches(record, honest)
        times = horizons(honest, seen)
        decision, reason, corrected = call(arguments.command, flags_of(plant, arguments),
                                           given, [record], scratch,
                                           "fopdt.json" if run.again else "model.json")
        case = run.case
        if run.again and corrected is None:
            decision = "not_given"
        elif run.again:
            given, record = corrected, case.record.with_name(run.again)
            case = dataclasses.replace(case, held_out=tuple(
                file for file in case.held_out if file != record))
            decision, reason, corrected = call(arguments.command, flags_of(plant, arguments),
                                               given, [record], scratch / "again")
    judge = Judge(case, honest, plant, begin)
    row = {"decision": decision, "reason": reason, "honest": judge.judge(honest, times),
           "given": judge.judge(given, times)}
    if corrected is None:
        row.update(corrected=row["given"], changed=[])
    else:
        row.update(corrected=judge.judge(corrected, times), changed=changed(given, corrected))
    return row


def wanted(data, pattern, arguments):
    """All runs, and lines about what was left out."""
    runs, left_out = [], []
    declared = records.declarations(data)
    for name, plant in declared.items():
        if not pattern.search(name):
            continue
        if not (data / name).is_dir():
            left_out.append(f"{name}: skipped, no folder {data / name}")
            continue
        cases = records.cases(data / name, name, plant)
        if not cases:
            left_out.append(f"{name}: skipped, no record \"{plant['records']}\" there")
        for case in cases:
            runs += runs_of(case, plant)
        if "fit" in plant:
            for case in records.fitted_cases(cases, plant["fit"]):
                runs += runs_of(case, plant)
    left_out += [f"{folder.name}: skipped, no entry in plants.json"
                 for folder in sorted(data.iterdir())
                 if folder.is_dir() and folder.name not in declared
                 and pattern.search(folder.name)]
    return runs, declared, left_out


def known_of(case, plant):
    """What is known to have aged in a record."""
    for known in plant.get("known", []):
        if re.fullmatch(known["records"], case.record.name):
            return known
    return None


def runs_of(case, plant):
    model = read_model(case.model)
    result = [Run(case)]
    if case.own:
        if plant.get("cross") and not case.fitted:
            others = [file.name for file in case.held_out]
            following = [name for name in others if name > case.record.name] or others
            result += [Run(case, again=following[0])] if others else []
        if known_of(case, plant) is None and bool(case.fitted) == ("fit" in plant):
            result += [Run(case, age) for age in
                       ages(model, records.stretches(case.record, model), plant)]
    return result
