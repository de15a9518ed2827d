"""What is in a folder of real records: declarations of plants, their models and records.

DIR has a folder for each plant. What is in it is said in plants.json beside this file, and for
other plants in DIR/plants.json, which has the same form and comes first (docs/reality.md).
"""

import csv
import dataclasses
import datetime
import json
import math
import pathlib
import re

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
KEYS = {"records": str, "models": list, "truth": str, "known": list, "aged": list, "cross": bool,
        "fit": str, "ahead": (int, float), "sample_time": (int, float), "part": (int, float),
        "flags": str}
SECONDS = {"ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}
LONGEST_GAP = 5  # samples that are bridged
SHARE = 2.0 / 3.0  # of the only record of a model, which it is corrected from


class Wrong(ValueError):
    """Of files that users write; what is wrong, and where."""


@dataclasses.dataclass(frozen=True)
class Case:
    """A model, the record that it is corrected from, and those that it is judged on."""

    plant: str
    model: pathlib.Path
    record: pathlib.Path
    held_out: tuple  # of paths; of one record alone its last part
    truth: pathlib.Path = None
    own: bool = True  # whether the record belongs to the model
    fitted: pathlib.Path = None  # record that the model is fitted to before anything is done


def declarations(data):
    """Plants by name, those of the folder first."""
    result = {}
    for file in (HERE / "plants.json", data / "plants.json"):
        if file.exists():
            result.update(read_declarations(file))
    return result


def read_declarations(file):
    try:
        plants = json.loads(file.read_text())
    except json.JSONDecodeError as error:
        raise Wrong(f"{file}: {error}") from error
    if not isinstance(plants, dict):
        raise Wrong(f"{file}: an object of plants is wanted, each named as its folder")
    for name, plant in plants.items():
        check_declaration(f"{file}: {name}", plant)
    return plants


def check_declaration(place, plant):
    if not isinstance(plant, dict):
        raise Wrong(f"{place}: an object is wanted")
    for key, value in plant.items():
        if key not in KEYS:
            raise Wrong(f"{place}: unknown key \"{key}\"; choose from {', '.join(KEYS)}")
        if not isinstance(value, KEYS[key]) or isinstance(value, bool) != (KEYS[key] is bool):
            raise Wrong(f"{place}: {key} is {json.dumps(value)}")
    for key in ("records", "models"):
        if key not in plant:
            raise Wrong(f"{place}: \"{key}\" is missing")
    if not 0.0 < plant.get("part", SHARE) < 1.0:
        raise Wrong(f"{place}: part is {plant['part']}; it must be between 0 and 1")
    if not plant.get("ahead", 1) > 0 or not plant.get("sample_time", 1) > 0:
        raise Wrong(f"{place}: ahead and sample_time must be above 0")
    for pattern in [plant["records"], plant.get("fit", ""), *(known.get("records", "") for known in
                                        plant.get("known", []))]:
        try:
            re.compile(pattern)
        except re.error as error:
            raise Wrong(f"{place}: \"{pattern}\": {error}") from error
    for change in plant.get("aged", []):
        if len(change) != 2 or "pair" not in change or \
                not set(change) & {"gain", "time_constant", "delay"}:
            raise Wrong(f"{place}: aged has {json.dumps(change)}; wanted are \"pair\" and one of "
                        "\"gain\", \"time_constant\" (factors) and \"delay\" (added)")
    for known in plant.get("known", []):
        if set(known) != {"records", "input", "parameter", "from", "to"}:
            raise Wrong(f"{place}: known has {json.dumps(known)}; wanted are \"records\", "
                        "\"input\", \"parameter\", \"from\" and \"to\"")


def cases(folder, name, plant):
    """The cases of a plant; models in the order of the declaration, records by name."""
    matches = {file.name: re.fullmatch(plant["records"], file.name)
               for file in sorted(folder.iterdir()) if file.is_file()}
    matches = {file: match for file, match in matches.items() if match}

    def named(template, match):
        try:
            return folder / match.expand(template)
        except (re.error, IndexError) as error:
            raise Wrong(f"{folder}: \"{template}\" of plant {name}: {error}") from error

    owners = {}  # records of each model
    for template in plant["models"]:
        for file, match in matches.items():
            owners.setdefault(named(template, match), []).append(file)
    result = []
    for model, own in owners.items():
        if not model.exists():
            raise Wrong(f"{model}: no such model; records that belong to it: {', '.join(own)}")
        for file, match in matches.items():
            if file not in own and not plant.get("cross"):
                continue
            truth = named(plant["truth"], match) if "truth" in plant else None
            if truth and not truth.exists():
                raise Wrong(f"{truth}: no such file of true step responses, for {file}")
            others = matches if plant.get("cross") else own
            held_out = () if truth else tuple(folder / other for other in others if other != file)
            result.append(Case(name, model, folder / file, held_out, truth, file in own))
    return result


def fitted_cases(cases_of_plant, pattern):
    """The own model of a record, fitted to that record, for the next one; judged on all records
    of the pattern but the one that it is corrected from."""
    own = [case for case in cases_of_plant if case.own and re.fullmatch(pattern, case.record.name)]
    if len(own) < 2:
        return []
    return [dataclasses.replace(case, record=following.record, fitted=case.record,
                                held_out=tuple(other.record for other in own
                                               if other.record != following.record))
            for case, following in zip(own, own[1:] + own[:1])]


def read_columns(file):
    """Columns of numbers; what is not a number, apart from times, is not known."""
    with file.open(newline="", encoding="utf-8-sig") as stream:
        rows = [row for row in csv.reader(stream) if row]
    header, rows = rows[0], rows[1:]
    if any(len(row) != len(header) for row in rows):
        line = next(i for i, row in enumerate(rows, 2) if len(row) != len(header))
        raise Wrong(f"{file}, line {line}: {len(rows[line - 2])} fields, the header has "
                    f"{len(header)}")
    return dict(zip(header, zip(*rows)))


def number(text):
    try:
        value = float(text)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def times_in(texts, unit, file):
    try:
        return np.array([float(text) for text in texts])
    except ValueError:
        pass
    try:
        dates = [datetime.datetime.fromisoformat(text.strip().replace("Z", "+00:00"))
                 for text in texts]
    except ValueError as error:
        raise Wrong(f"{file}: times are neither numbers nor ISO 8601: {error}") from error
    return np.array([(date - dates[0]).total_seconds() for date in dates]) / SECONDS[unit]


class Stretch:
    """Evenly sampled, without gaps: inputs held, outputs not a number where not known."""

    def __init__(self, interval, time, columns):
        self.interval, self.time, self.columns, self._spectra = interval, time, columns, {}

    def spectrum(self, name, values, size):
        if name not in self._spectra:
            self._spectra[name] = np.fft.rfft(values - values[0], size)
        return self._spectra[name]


def held(values):
    """Each unknown value is that before it, at the beginning the first known one."""
    known = np.flatnonzero(np.isfinite(values))
    if not len(known):
        return np.zeros(len(values))
    last = np.maximum(np.searchsorted(known, np.arange(len(values)), side="right") - 1, 0)
    return values[known[last]]


def stretches(file, model):
    """The record on an even grid, cut where there are no samples for long."""
    texts = read_columns(file)
    inputs = [channel["name"] for channel in model["inputs"]]
    outputs = [channel["name"] for channel in model["outputs"]]
    for name in ("time", *inputs, *outputs):
        if name not in texts:
            raise Wrong(f"{file}: no column \"{name}\"; the model has it")
    time = times_in(texts["time"], model.get("time_unit", "min"), file)
    steps = np.diff(time)
    if len(time) < 10 or not np.all(steps > 0.0):
        raise Wrong(f"{file}: ten samples or more at ascending times are wanted")
    interval = float(np.median(steps))
    places = np.rint((time - time[0]) / interval).astype(int)
    columns = {name: np.array([number(text) for text in texts[name]])
               for name in (*inputs, *outputs)}
    result = []
    cuts = np.flatnonzero(np.diff(places) > LONGEST_GAP) + 1
    for part in np.split(np.arange(len(time)), cuts):
        grid = places[part] - places[part[0]]
        even = {}
        for name, values in columns.items():
            even[name] = np.full(grid[-1] + 1, math.nan)
            even[name][grid] = values[part]
            if name in inputs:
                even[name] = held(even[name])
        result.append(Stretch(interval, time[part[0]] + interval * np.arange(grid[-1] + 1), even))
    return result


def last_time(file, model, share):
    """The time at which that share of the record's rows ends."""
    times = times_in(read_columns(file)["time"], model.get("time_unit", "min"), file)
    return float(times[int(share * len(times))])


def first_rows(file, share, out):
    """Writes the first rows of a record as they stand."""
    lines = file.read_text(encoding="utf-8-sig").splitlines(keepends=True)
    out.write_text("".join(lines[:1 + int(share * (len(lines) - 1))]))
