"""The scenarios of the benchmark: what happens, and on which plants, with something aged or not."""

import random

import adversary
import effects
import linearise
import ph_neutralisation
import plants
import quadruple_tank
import reactor
from ageing import AGEING, some_aged
from effects import EFFECTS
from trial import Trial

# Plants with equations, and the scenarios that each has for itself.
NONLINEAR = {"reactor": reactor, "tanks": quadruple_tank, "neutralisation": ph_neutralisation}
OF_ONE_PLANT = {
    name: plant for plant in NONLINEAR
    for name in (f"{plant} at one point", f"{plant}, tour of set points",
                 f"{plant}, far set points")}


GROUPS = ("routine", "adversary")


def names(kind, group="routine"):
    if group == "adversary":
        return list(adversary.FAMILIES)
    common = [*EFFECTS, *OF_ONE_PLANT]
    return {"none": common, "aged": [*common, *AGEING]}[kind]


def plant_of(name, of_set, i, group="routine"):
    """The plant of the i-th run of a scenario, on the plants of a set in turn."""
    of_set_plants, _ = plants.SETS[of_set]
    if group == "adversary":
        return adversary.plant_of(name, [*of_set_plants, *plants.ADVERSARY[of_set]], i)
    return OF_ONE_PLANT.get(name) or of_set_plants[i % len(of_set_plants)]


def age_nonlinear(trial, equations):
    """One to three of the things that age in it, both where there are two."""
    names = list(equations.AGEING)
    if len(names) > 2:
        names = trial.random.sample(names, trial.random.randint(1, 3))
    trial.factors = {name: trial.random.uniform(*equations.AGEING[name]) for name in names}
    _, inputs = linearise.at_rest(equations, **trial.factors)
    trial.flags["operating_inputs"] = ",".join(f"{value:.10g}" for value in inputs)
    trial.truth = linearise.model(trial.plant, equations, **trial.factors)


def of_one_plant(trial, kind, name, equations):
    if name.endswith("at one point"):
        effects.two_rounds(trial)
    elif name.endswith("tour of set points"):
        effects.tour(trial, equations.TOUR)
    else:
        effects.far_steps(trial, equations.FAR)
    if kind == "aged":
        age_nonlinear(trial, equations)


def make(plant, kind, name, seed, group="routine"):
    """The trial of a scenario: kind is `none` or `aged`."""
    trial = Trial(plants.PLANTS[plant], random.Random(f"{kind}/{name}/{plant}/{seed}"))
    if group == "adversary":
        adversary.make(trial, kind, name)
    elif name in OF_ONE_PLANT:
        of_one_plant(trial, kind, name, NONLINEAR[plant])
    elif name in EFFECTS:
        EFFECTS[name](trial)
        if kind == "aged":
            some_aged(trial)
    else:
        AGEING[name](trial)
    return trial
