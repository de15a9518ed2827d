"""How the plants of the benchmark age. Each is a function that changes a Trial."""

import plants
from effects import two_rounds


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


def new_path(trial):
    """An element that the model does not have: of an output with more, not its largest."""
    def weight(place):
        element = trial.model["elements"][place]
        return abs(plants.static_gain(element)) * trial.sizes[element["input"]]

    elements = trial.model["elements"]
    rows = [[i for i, element in enumerate(elements) if element["output"] == output]
            for output in sorted({element["output"] for element in elements})]
    places = [max((i for i in row if i != max(row, key=weight)), key=weight)
              for row in rows if len(row) > 1]
    del elements[trial.random.choice(places)]


def schedule(trial, place, factor, points):
    """A gain that changes while the record is made; true is what holds at its end."""
    element = trial.truth["elements"][place]
    gains = [[at * trial.duration(), 1.0 + part * (factor - 1.0)] for at, part in points]
    trial.schedule.append({"output": element["output"], "input": element["input"], "gain": gains})
    trial.true_gains[place] = gains[-1][1]


def scheduled(trial, points):
    place = some_elements(trial, 1)[0]
    schedule(trial, place, gain_factor(trial), points)


def step_in_record(trial):
    two_rounds(trial)
    at = trial.random.uniform(0.35, 0.65)
    scheduled(trial, [(at, 0), (at, 1)])


def drift_in_record(trial):
    two_rounds(trial)
    scheduled(trial, [(0, 0), (1, 1)])


# What has aged, where nothing else happens.
AGEING = {
    "gains": gains_aged,
    "time constants": time_constants_aged,
    "dead times": delays_aged,
    "a gain by 8 %": small_gain,
    "a little lead": lead,
    "second order": second_order,
    "a new path": new_path,
    "a gain steps during the record": step_in_record,
    "a gain drifts during the record": drift_in_record,
}
