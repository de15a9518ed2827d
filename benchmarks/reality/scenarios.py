"""The scenarios of the benchmark: what happens, and on which plants, with something aged or not."""

import random

import adversary
import effects
import plants
import reactor
from ageing import AGEING, some_aged
from effects import EFFECTS
from trial import Trial

# On the reactor alone.
REACTOR = {
    "reactor at one point": effects.small_steps,
    "reactor, tour of set points": effects.tour,
    "reactor, far set points": effects.far_steps,
}


GROUPS = ("routine", "adversary")


def names(kind, group="routine"):
    if group == "adversary":
        return list(adversary.FAMILIES)
    common = [*EFFECTS, *REACTOR]
    return {"none": common, "aged": [*common, *AGEING]}[kind]


def plant_of(name, of_set, i, group="routine"):
    """The plant of the i-th run of a scenario, on the plants of a set in turn."""
    of_set_plants, _ = plants.SETS[of_set]
    if group == "adversary":
        return adversary.plant_of(name, [*of_set_plants, *plants.ADVERSARY[of_set]], i)
    return "reactor" if name in REACTOR else of_set_plants[i % len(of_set_plants)]


def age_reactor(trial):
    trial.reactor = {"activity": trial.random.uniform(0.8, 0.95),
                     "heat_transfer": trial.random.uniform(0.6, 1.0)}
    trial.truth = reactor.model(**trial.reactor)


def make(plant, kind, name, seed, group="routine"):
    """The trial of a scenario: kind is `none` or `aged`."""
    trial = Trial(plants.PLANTS[plant], random.Random(f"{kind}/{name}/{plant}/{seed}"))
    if group == "adversary":
        adversary.make(trial, kind, name)
    elif name in REACTOR:
        REACTOR[name](trial)
        if kind == "aged":
            age_reactor(trial)
    elif name in EFFECTS:
        EFFECTS[name](trial)
        if kind == "aged":
            some_aged(trial)
    else:
        AGEING[name](trial)
    return trial
