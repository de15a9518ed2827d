"""The scenarios of the benchmark: what happens, and on which plants, with something aged or not."""

import random

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


def names(kind):
    common = [*EFFECTS, *REACTOR]
    return {"none": common, "aged": [*common, *AGEING]}[kind]


def plant_of(name, plant):
    return "reactor" if name in REACTOR else plant


def age_reactor(trial):
    trial.reactor = {"activity": trial.random.uniform(0.8, 0.95),
                     "heat_transfer": trial.random.uniform(0.6, 1.0)}
    trial.truth = reactor.model(**trial.reactor)


def make(plant, kind, name, seed):
    """The trial of a scenario: kind is `none` or `aged`."""
    trial = Trial(plants.PLANTS[plant], random.Random(f"{kind}/{name}/{plant}/{seed}"))
    if name in REACTOR:
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
