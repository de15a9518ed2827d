"""check_reality.py SOURCE BUILD: the arithmetic of benchmarks/reality, and its smallest runs."""

import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
sys.dont_write_bytecode = True
sys.path.insert(0, str(source / "benchmarks/reality"))
import adversary  # noqa: E402
import effects  # noqa: E402
import hardware  # noqa: E402
import linearise  # noqa: E402
import mistakes  # noqa: E402
import plants  # noqa: E402
import scenarios  # noqa: E402
import tables  # noqa: E402
from trial import Trial  # noqa: E402


def close(a, b, tolerance):
    assert len(a) == len(b), (a, b)
    for x, y in zip(a, b):
        assert abs(x - y) <= tolerance * max(abs(value) for value in b), (a, b)


def value_at(element, s):
    """The element without its dead time, at s."""
    def polynomial(coefficients):
        result = 0.0
        for coefficient in coefficients:
            result = result * s + coefficient
        return result
    if "gain" in element:
        return element["gain"] / (element["time_constant"] * s + 1.0)
    return polynomial(element["numerator"]) / polynomial(element["denominator"])


def plants_with_equations_are_those_of_their_files():
    for name, equations in scenarios.NONLINEAR.items():
        plant = plants.PLANTS[name]
        for ours, given in zip(linearise.model(plant, equations)["elements"],
                               plant.read()["elements"]):
            for key in ("numerator", "denominator", "gain", "time_constant"):
                assert (key in ours) == (key in given), (name, ours, given)
                if isinstance(given.get(key), list):
                    close(ours[key], given[key], 1e-6)
                elif key in given:
                    close([ours[key]], [given[key]], 1e-6)


def states_that_nothing_reaches_are_left_out():
    """(s + 3)⁻¹ of three states, two of which do nothing for the output."""
    A = [[-3.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.0, 0.0, -0.5]]
    A_reached, b, c = linearise.reached(A, [2.0, 0.0, 0.0], [1.0, 0.0, 4.0])
    assert len(A_reached) == 2
    A_seen, c, b = linearise.reached(linearise.transposed(A_reached), c, b)
    numerator, denominator = linearise.transfer_function(linearise.transposed(A_seen), b, c)
    close(numerator, [2.0 / 3.0], 1e-12)
    close(denominator, [1.0 / 3.0, 1.0], 1e-12)


def aged_plants_are_held_where_they_were():
    for equations in scenarios.NONLINEAR.values():
        state, inputs = linearise.at_rest(equations)
        factors = {name: low for name, (low, _) in equations.AGEING.items()}
        aged_state, aged_inputs = linearise.at_rest(equations, **factors)
        kept = [(state[i], aged_state[i]) for i in equations.OUTPUTS]
        if not equations.HELD:
            kept = list(zip(inputs, aged_inputs))
        close(*map(list, zip(*kept)), 1e-9)
        rates = equations.derivative(aged_state, aged_inputs, **factors)
        assert max(map(abs, rates)) < 1e-9, equations
        assert aged_state != state


def elements_age_as_said():
    first = {"output": "y", "input": "u", "gain": 2.0, "time_constant": 5.0, "delay": 1.0}
    third = {"output": "y", "input": "u", "numerator": [3.0, 2.0],
             "denominator": [7.0, 4.0, 1.0], "delay": 1.0}
    for element in (first, third):
        old = plants.aged(element, gain=0.5, time_constant=3.0, delay=2.0)
        assert old["delay"] == 3.0
        for s in (0.1, 0.3 + 0.4j):
            assert abs(value_at(old, s) - 0.5 * value_at(element, 3.0 * s)) < 1e-12
            lag = plants.lagged([element], "y", 4.0)[0]
            assert abs(value_at(lag, s) - value_at(element, s) / (4.0 * s + 1.0)) < 1e-12


def inputs_of_a_diagonal_plant():
    model = {"inputs": [{"name": "u"}, {"name": "v"}], "outputs": [{"name": "y"}, {"name": "z"}],
             "elements": [{"output": "y", "input": "v", "gain": 4.0},
                          {"output": "z", "input": "u", "gain": -0.5}]}
    close(plants.input_sizes(model, (1.0, 2.0)), [4.0, 0.25], 1e-12)


def a_first_order_response_is_simulated():
    """u steps to 2 at 10, through a gain of 3 and a pole of 0.9."""
    weights = [3.0 * 0.1 * 0.9 ** i for i in range(200)]
    inputs = {"u": [5.0] * 10 + [7.0] * 90}
    response = hardware.simulate({"u": weights}, inputs, 100)
    for i, value in enumerate(response):
        k = i * hardware.STRIDE
        assert abs(value - 6.0 * (1.0 - 0.9 ** max(0, k - 10))) < 1e-9
    assert abs(hardware.fit(response, [value + 8.0 for value in response]) - 100.0) < 1e-9
    assert abs(hardware.fit(response, [0.0] * len(response))) < 1e-9
    # Of a level alone nothing is left, of a ramp what it makes in the steps.
    assert hardware.ahead([value + 8.0 for value in response], response, 3) < 1e-9
    ramp = [value + 0.5 * i for i, value in enumerate(response)]
    assert abs(hardware.ahead(ramp, response, 3) - 1.5) < 1e-9


def harm_is_counted():
    def row(kind, decision, change, before, after):
        return {"kind": kind, "decision": decision, "largest_change": change,
                "E_before": before, "E_after": after}
    assert tables.is_harmful(row("none", "corrected", 0.021, 0.0, 1.0))
    assert not tables.is_harmful(row("none", "corrected", 0.019, 0.0, 1.0))
    assert not tables.is_harmful(row("none", "cannot_tell", 9.0, 0.0, 1.0))
    assert tables.is_harmful(row("aged", "corrected", 0.5, 1.0, 1.1))
    assert not tables.is_harmful(row("aged", "corrected", 0.5, 1.0, 0.9))


def scenarios_are_those_of_their_seed():
    for kind in ("none", "aged"):
        for name in scenarios.names(kind):
            plant = scenarios.plant_of(name, "tuning", 2)
            first, again, other = (scenarios.make(plant, kind, name, seed) for seed in (1, 1, 2))
            assert first.effects_file() == again.effects_file(), name
            assert first.true_model() == again.true_model(), name
            assert first.record_flags() == again.record_flags(), name
            aged = first.true_model()["elements"] != first.model["elements"]
            assert aged == (kind == "aged"), (kind, name)
            if kind == "aged" and name != "a new path":  # the model lacks what the plant has
                assert first.true_model() != other.true_model(), name


def the_adversary_states_what_is_true():
    """Every family has plants in both sets; with its own seed the same; one parameter ages."""
    for of_set in plants.SETS:
        for name in adversary.FAMILIES:
            of_family = {scenarios.plant_of(name, of_set, i, "adversary") for i in range(20)}
            assert of_family <= {*plants.SETS[of_set][0], *plants.ADVERSARY[of_set]}, name
            assert len(of_family) >= (1 if adversary.FAMILIES[name].disturbed else 5), name
    for kind in ("none", "aged"):
        for name, family in adversary.FAMILIES.items():
            plant = scenarios.plant_of(name, "tuning", 1, "adversary")
            first, again = (scenarios.make(plant, kind, name, 1, "adversary") for _ in range(2))
            for get in (Trial.effects_file, Trial.record_flags, Trial.true_model):
                assert get(first) == get(again), name
            assert (first.aged is not None) == (kind == "aged") and first.codes == family.codes
            if kind == "none" and family.linear and name != "fast analyser":
                assert first.true_model()["elements"] == first.model["elements"], name


def reasons_are_compared():
    trial = Trial(plants.PLANTS["two_by_two"], random.Random(1))
    trial.codes, trial.where = ("curved_output",), "y2"
    curve = {"output": "y2", "explanation": "curved_output", "value": 0.1}
    lag = {"output": "y1", "element": "y1/u2", "explanation": "time_constant", "value": 1.5}

    def true(*told):
        return adversary.reason_true(trial, {"explanations": list(told)})
    assert adversary.reason_true(trial, {}) is None
    assert true(curve) and true(lag, curve)
    assert not true() and not true(lag) and not true({**curve, "output": "y1"})
    trial.aged = {"output": "y1", "input": "u2", "code": "time_constant"}
    assert true(lag) and not true({**lag, "element": "y1/u1"})
    assert true(lag, curve) and not true(lag, {**curve, "explanation": "output_clock"})
    trial.codes, trial.where, trial.aged = ("reversed", "mistake"), "u1", None
    for channel in ("u1", "u2"):
        reason = {"code": "mistake", "text": f"The sign of {channel} seems to be reversed."}
        result = {"explanations": [], "reasons": [reason, {"code": "other", "text": " u1 "}]}
        assert adversary.reason_true(trial, result) == (channel == "u1")
    trial.codes = ()
    assert true() is None and not true(lag)
    assert adversary.gives_reasons({"decision": "cannot_tell", "told": []})
    assert adversary.gives_reasons({"decision": "corrected", "told": [lag, curve]})
    assert not adversary.gives_reasons({"decision": "corrected", "told": [lag]})


def elements_are_compared():
    trial = Trial(plants.PLANTS["two_by_two"], random.Random(1))
    trial.aged = {"output": "y1", "input": "u2", "code": "gain"}
    for changes, how in (([[0.0, 0.3], [0.0, 0.01]], "named exactly"),
                         ([[0.0, 0.3], [0.1, 0.0]], "named with others"),
                         ([[0.3, 0.0], [0.0, None]], "not named, another is"),
                         ([[0.0, 0.0], [0.0, 0.0]], "missed")):
        result = {"decision": "corrected", "distance": {"elements": changes}}
        assert adversary.named(trial, result) == how
        assert adversary.named(trial, {**result, "decision": "cannot_tell"}) == "missed"


def averages_are_stamped_where_they_say():
    for average, first_stamp in ((effects.averages_at_start, 0), (effects.averages_at_end, 1)):
        trial = Trial(plants.PLANTS["two_by_two"], random.Random(1))
        average(trial)
        count = 200
        header = ["time", "y1", "y1_setpoint", "u1"]
        rows = [[str(k), str(k * k), str(k), "5.0"] for k in range(count)]
        case = mistakes.Case(trial, trial.model, [header, *rows])
        trial.spoil[0](case)
        times = [int(time) for time in case.columns["time"]]
        length = times[1] - times[0]
        assert length > 1 and times[0] == first_stamp * length
        assert case.columns["y1_setpoint"] == case.columns["time"]
        for time, value in zip(times, case.columns["y1"]):
            begin = time - first_stamp * length
            mean = sum(k * k + k + 0.5 for k in range(begin, begin + length)) / length
            assert abs(float(value) - mean) < 1e-9
        assert all(float(value) == 5.0 for value in case.columns["u1"])


def mistakes_change_the_files(folder):
    header = ["time", "y1", "y2", "y1_setpoint", "y2_setpoint", "u1", "u2"]
    rows = [[str(k), "1.0", "2.0", "3.0", "4.0", "5.0", "6.0"] for k in range(3)]
    for name in mistakes.MISTAKES:
        trial = Trial(plants.PLANTS["two_by_two"], random.Random(name))
        model, record = folder / "model.json", folder / "record.csv"
        model.write_text(json.dumps(trial.model))
        with record.open("w", newline="") as file:
            csv.writer(file).writerows([header, *rows])
        mistakes.make(name, trial, model, record)
        same_model = json.loads(model.read_text()) == trial.model
        with record.open(newline="") as file:
            same_record = list(csv.reader(file)) == [header, *rows]
        assert same_model != same_record, name


def study(folder, *flags):
    done = subprocess.run([source / "benchmarks/reality/run", f"--apps={build / 'apps'}", f"--out={folder}",
                           "--seeds=1", *flags], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stderr, (folder / "runs.csv").read_text()


def a_study_goes_on_where_it_stopped(folder):
    first, second = (study(folder, "--kinds=none,aged,hardware", "--scenarios=^white noise$") for _ in range(2))
    assert "2 of 2 runs" in first[0] and "runs" not in second[0], (first[0], second[0])
    assert first[1] == second[1]
    rows = list(csv.DictReader(first[1].splitlines()))
    assert [row["decision"] for row in rows] == ["no_change", "corrected"], rows
    assert float(rows[1]["E_after"]) < 0.2 * float(rows[1]["E_before"])
    assert math.isclose(float(rows[0]["E_before"]), 0.0, abs_tol=1e-12)


def mistakes_and_adversaries_are_run(folder):
    for flags in (("--kinds=mistakes", "--scenarios=^sign of an input$"),
                  ("--group=adversary", "--kinds=aged", "--scenarios=^nothing else$")):
        (row,) = csv.DictReader(study(folder, *flags)[1].splitlines())
        assert (row["decision"] == "corrected") == ("--group=adversary" in flags), row


plants_with_equations_are_those_of_their_files()
states_that_nothing_reaches_are_left_out()
aged_plants_are_held_where_they_were()
elements_age_as_said()
inputs_of_a_diagonal_plant()
a_first_order_response_is_simulated()
harm_is_counted()
scenarios_are_those_of_their_seed()
the_adversary_states_what_is_true()
reasons_are_compared()
elements_are_compared()
averages_are_stamped_where_they_say()
with tempfile.TemporaryDirectory() as scratch:
    mistakes_change_the_files(pathlib.Path(scratch))
    a_study_goes_on_where_it_stopped(pathlib.Path(scratch))
    mistakes_and_adversaries_are_run(pathlib.Path(scratch))
