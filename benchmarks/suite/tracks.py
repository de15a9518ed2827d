"""The tracks of the suite: what happens in each, on which plants.

A track is a function (form, repeats, arguments) that yields cases; a new effect is a line of
benchmarks/reality/effects.py or adversary.py, a new plant a line of benchmarks/reality/plants.py.
"""

import copy
import functools
import importlib.machinery
import importlib.util
import json
import random
import sys

import cases  # first: it names the folders of the others
import adversary  # of benchmarks/reality
import ageing
import effects
import plants
import runs  # of benchmarks/real
import scenarios
import trial as trials


def imported(name, path):
    """A script without the ending of a module."""
    loader = importlib.machinery.SourceFileLoader(name, str(path))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    sys.modules[name] = module
    loader.exec_module(module)
    return module


plant_size = imported("plant_size", cases.ROOT / "benchmarks/plant_size/run")

REPORTING = plants.SETS["reporting"][0]
PUBLISHED = ("wood_berry", "vinante_luyben", "wardle_wood", "ogunnaike_ray", "doukas_luyben",
             "shell_fractionator", "four_rooms", "reactor", "tanks", "neutralisation")
LABORATORY = ("laboratory", "laboratory, held", "analyser, 10 samples", "analyser, 30 samples")
SIZES = {"smoke": ("2x2",), "short": ("4x4", "7x7"),
         "full": ("4x4", "7x7", "12x12", "20x20", "20x30", "40x80")}
# Limits beyond which mismatch costs the loop of the Wood-Berry column 70 % more integral error
# (Tufa and Ka, Procedia Engineering 148, 2016, 1008-1014), of each element; dead times in parts of
# themselves.
LIMITS = {"gain": ((-0.20, 0.40), (-0.13, 0.07), (-0.40, 0.31), (-0.07, 0.27)),
          "delay": ((-0.40, 0.40), (-0.40, 0.22), (-0.20, 0.17), (-0.29, 0.27)),
          "time_constant": ((-0.40, 0.15), (-0.20, 0.40), (-0.23, 0.40), (-0.28, 0.36))}
PARTS = (0.0, 0.2, 0.5, 1.0, 2.0)  # of a limit


# The Wood-Berry column as the paper has it (configs/paper.flags): one step of each set point.
PAPER = plants.Plant("configs/wood_berry.json", (1, 1), 200, 0.2, 1, 30, noise=1e-3**0.5)
PAPER_FLAGS = {"control_horizon": 5, "output_weight": 0.2, "move_weight": 0.1}
PAPER_HORIZON = 100


def paper_trial(case, seed):
    trial = trials.Trial(PAPER, random.Random(seed))
    trial.flags.update(PAPER_FLAGS)
    name = trial.inputs[{"gain": 0, "delay": 1}[case.name]]
    for place, element in enumerate(trial.truth["elements"]):
        if case.kind == "aged" and element["input"] == name:
            how = {"gain": {"gain": 0.5}, "delay": {"delay": 4.0}}[case.name]
            ageing.change(trial, place, **how)
    return trial


def paper(form, repeats, arguments):
    for repeat in repeats:
        for name in ("gain", "delay"):
            for kind in ("none", "aged"):
                yield cases.Simulated("paper", name, "wood_berry", kind, repeat, paper_trial,
                                      PAPER_HORIZON)


# Of plants with equations, what ages.
NONLINEAR_AGEING = {"reactor": ("catalyst and jacket",), "tanks": ("pumps, valves, outlets",),
                    "neutralisation": ("streams, outlet, electrode",)}


def published_trial(case, seed):
    trial = trials.Trial(plants.PLANTS[case.plant], random.Random(seed))
    trial.rounds = 2
    if case.plant in scenarios.NONLINEAR:
        if case.kind == "aged":
            scenarios.age_nonlinear(trial, scenarios.NONLINEAR[case.plant])
    elif case.kind == "aged":
        ageing.AGEING[case.name](trial)
    return trial


def published(form, repeats, arguments):
    names = ("gains", "time constants", "dead times")
    for repeat in repeats:
        for plant in PUBLISHED if form != "smoke" else PUBLISHED[:1]:
            for name in NONLINEAR_AGEING.get(plant, names):
                yield cases.Simulated("published", name, plant, "aged", repeat, published_trial)
            yield cases.Simulated("published", "nothing", plant, "none", repeat, published_trial)


def routine_trial(case, seed):
    return scenarios.make(case.plant, case.kind, case.name, seed)


def adversary_trial(case, seed):
    return scenarios.make(case.plant, case.kind, case.name, seed, "adversary")


def kinds(form, i):
    """Both, of the short form in turn."""
    return ("none", "aged") if form == "full" else (("none", "aged")[i % 2],)


def effects_of(form, repeats, arguments):
    names = [name for name in effects.EFFECTS if name not in LABORATORY]
    names = {"smoke": ["white noise"], "short": names, "full": names}[form]
    for repeat in repeats:
        for i, name in enumerate(names):
            for kind in kinds(form, i + repeat):
                yield cases.Simulated("effects", name, REPORTING[(i // 2 + repeat) % 4], kind,
                                      repeat, routine_trial)


def adversary_of(form, repeats, arguments):
    names = list(adversary.FAMILIES)[:1 if form == "smoke" else None]
    for repeat in repeats:
        for i, name in enumerate(names):
            plant = adversary.plant_of(name, [*REPORTING, *plants.ADVERSARY["reporting"]], repeat)
            for kind in kinds(form, i + repeat):
                yield cases.Simulated("adversary", name, plant, kind, repeat, adversary_trial)


def laboratory(form, repeats, arguments):
    for repeat in repeats:
        for i, name in enumerate(LABORATORY[:1 if form == "smoke" else None]):
            for kind in ("none", "aged"):
                yield cases.Simulated("laboratory", name, REPORTING[(i + repeat) % 4], kind,
                                      repeat, routine_trial)


def real(form, repeats, arguments):
    """Every model with every record of its own, as it is and aged; in the short form each aged in
    one way, in turn."""
    if arguments.data is None:
        return
    wanted, declared, _ = runs.wanted(arguments.data, arguments.plants, None)
    of_case = {}
    for run in wanted:
        if run.case.own and not run.again and not run.case.fitted:
            of_case.setdefault((run.case.plant, run.case.model, run.case.record), []).append(run)
    for i, some in enumerate(of_case.values()):
        aged = [run for run in some if run.age]
        if form != "full" and aged:
            aged = [aged[i % len(aged)]]
        for run in [some[0], *aged]:
            name = " ".join(map(str, (run.case.model.stem, run.case.record.stem, *run.age)))
            known = runs.known_of(run.case, declared[run.case.plant])
            yield cases.Real("real", name, run.case.plant,
                             "aged" if run.age or known else "none", 0, run,
                             declared[run.case.plant])


def draw_size(case, source):
    size = plant_size.SIZES[case.plant]
    model = plant_size.draw_model(size, source)
    plant, aged = plant_size.draw_aged(model, source)
    if case.kind == "none":
        plant, aged = model, None
    outputs = [channel["name"] for channel in reversed(model["outputs"][:4])]
    held = {"setpoints": ",".join(f"{name}:{400 * i}:-1" for i, name in enumerate(outputs, 1)),
            "duration": 2000}
    return cases.Drawn(model, plant, aged, {
        **plant_size.LOOP, "setpoints": plant_size.set_points(size), "duration": size.samples},
        held, 1.0, 300.0)


def size_of(form, repeats, arguments):
    for repeat in repeats:
        for name in SIZES[form]:
            for kind in ("none", "aged"):
                yield cases.ByFlags("size", name, name, kind, repeat, draw_size)


LEVELS = {
    "level": (("level", "outflow"), {
        "setpoints": "level:60:5,level:220:0", "disturbances": "inflow:140:2,inflow:300:0",
        "duration": 400, "sample_time": 0.2, "noise_variance": 0.01}, 40.0),
    "column_level": (("sump level", "bottoms"), {
        "setpoints": "top impurity:200:-0.5,sump level:550:3,bottom temperature:900:2",
        "duration": 1250, "sample_time": 0.5, "control_period": 2, "prediction_horizon": 40,
        "control_horizon": 6, "output_weight": 1, "move_weight": 0.5, "noise_variance": 4e-4},
        100.0)}


def draw_level(case, source):
    """The valve of the level has another gain."""
    pair, flags, horizon = LEVELS[case.plant]
    model = json.loads((plants.ROOT / f"configs/{case.plant}.json").read_text())
    plant, aged = copy.deepcopy(model), None
    if case.kind == "aged":
        aged = {pair}
        for element in plant["elements"]:
            if (element["output"], element["input"]) == pair:
                element["gain"] *= source.choice((source.uniform(0.5, 0.75),
                                                  source.uniform(1.3, 1.6)))
    reverse = ",".join(f"{name}:{time}:{-float(value):g}" for name, time, value in (
        point.split(":") for point in flags["setpoints"].split(",")))
    return cases.Drawn(model, plant, aged, {**flags, "drift_variance": case.name},
                       {"setpoints": reverse}, flags["sample_time"], horizon)


def levels(form, repeats, arguments):
    for repeat in repeats:
        for plant in LEVELS:
            for drift in ("0", "1e-06"):
                for kind in kinds(form, repeat + (drift != "0")):
                    yield cases.ByFlags("levels", drift, plant, kind, repeat, draw_level)


def limit(draw):
    """Parameter, element and limit of a draw: all 24 in turn, in any six of each parameter two."""
    i = 7 * draw % 24
    key, place = list(LIMITS)[i % 3], i // 6
    return key, place, LIMITS[key][place][i // 3 % 2]


def power_trial(part, draw, case, seed):
    """One parameter of one element is off by a part of its limit."""
    trial = trials.Trial(plants.PLANTS["wood_berry"], random.Random(seed))
    trial.rounds = 2
    key, place, by = limit(draw)
    if part:
        element = trial.truth["elements"][place]
        ageing.change(trial, place, **{key: part * by * element["delay"] if key == "delay" else
                                       max(1.0 + part * by, 0.1)})
    return trial


def power(form, repeats, arguments):
    draws = {"smoke": 1, "short": 6, "full": 24}[form]
    elements = plants.PLANTS["wood_berry"].read()["elements"]
    for repeat in repeats:
        for part in PARTS:
            for draw in range(draws * repeat, draws * (repeat + 1)):
                key, place, by = limit(draw)
                name = (f"{part:g} of {100 * by:+.0f} %, {key} of {elements[place]['output']} to "
                        f"{elements[place]['input']}" if part else "0")
                yield cases.Simulated("power", name, "wood_berry", "aged" if part else "none",
                                      draw, functools.partial(power_trial, part, draw))


TRACKS = {"paper": paper, "published": published, "effects": effects_of,
          "adversary": adversary_of, "laboratory": laboratory, "levels": levels, "real": real,
          "size": size_of, "power": power}
ABOUT = {
    "paper": "Wood-Berry column as the paper simulates it: first input's gains halved, second "
             "input's dead times 4 min longer",
    "published": "ten published plants; gains, time constants or dead times of one to three "
                 "elements have aged",
    "effects": "what loops, valves, sensors and historians do (benchmarks/reality/effects.py)",
    "adversary": "made to mislead; at most one parameter has aged "
                 "(benchmarks/reality/adversary.py)",
    "laboratory": "outputs that are measured rarely",
    "levels": "a drum and a column's sump, whose levels integrate; the gain of a valve has aged",
    "real": "records of real plants, models aged on purpose; judged on records held out",
    "size": "plants drawn at random, to 40 outputs and 80 inputs; one gain in eight is 30 % off",
    "power": "Wood-Berry column, one parameter off by a part of the limit at which it matters",
    "watch": "lives of the Wood-Berry column under watch; benchmarks/watch",
}


def chosen(names, form, repeats, arguments):
    """Cases of all tracks in turn, so that a study that is stopped has something of each."""
    lists = [list(TRACKS[name](form, range(repeats), arguments)) for name in names
             if name in TRACKS]
    order = sorted((i / len(some), number, i) for number, some in enumerate(lists)
                   for i in range(len(some)))
    return [lists[number][i] for _, number, i in order]
