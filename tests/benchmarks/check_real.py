"""check_real.py SOURCE BUILD: the arithmetic of benchmarks/real; a folder of simulated records."""

import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
sys.dont_write_bytecode = True
sys.path[:0] = [str(source / "benchmarks/real"), str(source / "benchmarks/reality")]
import least_squares  # noqa: E402
import records  # noqa: E402
import report  # noqa: E402
import responses  # noqa: E402
import runs  # noqa: E402
import transforms  # noqa: E402

MODEL = json.loads((source / "configs/wood_berry.json").read_text())
OUTPUTS = [channel["name"] for channel in MODEL["outputs"]]
PAIR = runs.pair_of(MODEL["elements"][0])


def stretch_of(columns, interval):
    samples = len(next(iter(columns.values())))
    return records.Stretch(interval, interval * np.arange(samples), columns)


def step_responses_are_exact():
    first = {"gain": 2.0, "time_constant": 5.0, "delay": 1.3}
    response = responses.step_response(first, 0.5, 40)
    for k, value in enumerate(response):
        expected = 2.0 * (1.0 - math.exp(-max(0.0, 0.5 * k - 1.3) / 5.0))
        assert abs(value - expected) < 1e-13, (k, value, expected)
    # The same as a rational function with a factor that cancels; then two lags and a lead.
    same = {"numerator": [6.0, 2.0], "denominator": [15.0, 8.0, 1.0], "delay": 1.3}
    assert np.allclose(responses.step_response(same, 0.5, 40), response, atol=1e-12)
    lead = {"numerator": [3.0, 1.0], "denominator": [8.0, 6.0, 1.0], "delay": 0.7}
    for k, value in enumerate(responses.step_response(lead, 0.5, 40)):
        t = max(0.0, 0.5 * k - 0.7)
        expected = 1.0 - 0.5 * math.exp(-t / 2.0) - 0.5 * math.exp(-t / 4.0)
        assert abs(value - expected) < 1e-12, (k, value, expected)
    ramp = {"numerator": [0.5], "denominator": [1.0, 0.0], "delay": 1.0}
    assert np.allclose(responses.step_response(ramp, 0.5, 7), [0, 0, 0, .25, .5, .75, 1.0])
    static = {"gain": 3.0, "time_constant": 0.0, "delay": 0.5}
    assert np.allclose(responses.step_response(static, 0.5, 4), [0, 3, 3, 3])


def levels_do_not_count_and_ramps_do():
    error = np.array([5.0, 5.5, math.nan, 6.5, 7.0, 7.5])
    assert np.allclose(responses.changes(error, 3), [1.5, 1.5])
    assert responses.root_mean_square(responses.changes(np.full(9, 4.0), 2)) == 0.0
    assert abs(responses.fit(np.full(5, 8.0), np.arange(5.0)) - 100.0) < 1e-12


def records_are_read(folder):
    file = folder / "record.csv"
    model = {"time_unit": "min", "inputs": [{"name": "u"}], "outputs": [{"name": "y"}]}
    rows = [[f"2024-02-29T12:{minute:02}:00Z", "1" if minute != 3 else "", "2" if minute != 4 else
             "Bad"] for minute in [*range(12), *range(40, 52)]]
    with file.open("w", newline="") as stream:
        csv.writer(stream).writerows([["time", "u", "y"], *rows])
    before, after = records.stretches(file, model)  # nothing is bridged for half an hour
    assert len(before.time) == 12 and after.time[0] == 40.0 and before.interval == 1.0
    assert np.all(before.columns["u"] == 1.0) and np.isnan(before.columns["y"][4])
    records.first_rows(file, 0.5, folder / "part.csv")
    assert (folder / "part.csv").read_text().count("\n") == 13
    assert records.last_time(file, model, 0.5) == 40.0
    file.write_text("time,u,y\n0,1,2\n1,2\n")
    refuses("line 3: 2 fields", records.stretches, file, model)
    file.write_text("time,u\n0,1\n1,2\n")
    refuses("no column \"y\"", records.stretches, file, model)


def refuses(what, function, *arguments):
    try:
        function(*arguments)
    except records.Wrong as error:
        assert what in str(error), error
        return
    raise AssertionError(f"not refused: {what}")


def declarations_are_checked():
    good = {"records": ".*", "models": ["m.json"]}
    records.check_declaration("here", good)
    for change, what in (({"modles": []}, "unknown key \"modles\""),
                         ({"records": "("}, "here: \"(\""), ({"part": 1.0}, "between 0 and 1"),
                         ({"cross": 1}, "cross is 1"),
                         ({"aged": [{"gain": 2}]}, "\"pair\" and one of")):
        refuses(what, records.check_declaration, "here", {**good, **change})
    refuses("\"models\" is missing", records.check_declaration, "here", {"records": ""})


def what_was_changed_is_named():
    for change in ({"gain": 0.6}, {"time_constant": 1.6}, {"delay": 0.3 * 16.7}):
        ((parameter, by),) = change.items()
        old = runs.aged(MODEL, (PAIR, parameter, by))
        ((pair, found, size, _),) = runs.changed(MODEL, old)
        assert (pair, found) == (PAIR, parameter) and abs(size - by) < 1e-9, (found, size)
        row = {"aged": [PAIR, parameter, by], "changed": runs.changed(old, MODEL)}
        assert report.is_exact(row), row
        assert not report.is_exact({**row, "changed": []})
        other = runs.pair_of(MODEL["elements"][1])
        little, much = ({**row, "changed": runs.changed(old, runs.aged(MODEL, (other, "gain", by)))}
                        for by in (1.01, 1.2))
        assert report.is_exact(little) and not report.is_exact(much)
    assert runs.changed(MODEL, MODEL) == []
    absent = dict(MODEL, elements=MODEL["elements"][1:])
    assert runs.changed(MODEL, absent) == [[PAIR, "path", None, math.inf]]


def the_error_of_the_horizons_is_a_mean_of_ratios():
    def errors(*values):
        return {"outputs": {"y": {"ahead": list(values)}}}
    row = {"given": errors(1.0, 2.0, 4.0), "corrected": errors(1.0, 1.0, 4.0), "aged": ["y/u"]}
    assert abs(report.ratio(row, "y") - 0.5 ** (1.0 / 3.0)) < 1e-12
    assert report.is_down(row) and not report.is_worse(row)
    row["corrected"] = errors(1.2, 2.0, 4.0)
    assert report.is_worse(row) and not report.is_down(row)


def make_plants(data):
    """Two records of a column that is as its model, and one with a gain at 0.7 of it."""
    for name in ("column", "aged_column"):
        (data / name).mkdir()
        (data / name / "model.json").write_text(json.dumps(MODEL))
    old = runs.aged(MODEL, (PAIR, "gain", 0.7))
    (data / "plant.json").write_text(json.dumps(old))
    steps = ",".join(f"{OUTPUTS[i % 2]}:{90 * i + 30}:{1 - i // 2 % 2}" for i in range(4))

    def simulate(plant, seed, out):
        subprocess.run([build / "apps/mle_simulate", f"--model={source}/configs/wood_berry.json",
                        f"--plant={plant}", f"--setpoints={steps}", "--duration=400",
                        "--sample_time=1", f"--seed={seed}", f"--out={out}"], check=True,
                       stdout=subprocess.DEVNULL)
    for seed in (1, 2):
        simulate(source / "configs/wood_berry.json", seed, data / f"column/run_{seed}.csv")
    simulate(data / "plant.json", 3, data / "aged_column/run_old.csv")
    with (data / "aged_column/truth_old.csv").open("w", newline="") as file:
        truth = csv.writer(file)
        truth.writerow(["time", *map(runs.pair_of, old["elements"])])
        truth.writerows(zip(range(100), *(responses.step_response(element, 1.0, 100)
                                          for element in old["elements"])))
    (data / "plants.json").write_text(json.dumps({
        "column": {"records": "run_.\\.csv", "models": ["model.json"],
                   "aged": [{"pair": PAIR, "gain": 0.6}]},
        "aged_column": {"records": "run_(old)\\.csv", "models": ["model.json"],
                        "truth": "truth_\\1.csv",
                        "known": [{"records": ".*old.*", "input": MODEL["elements"][0]["input"],
                                   "parameter": "gain", "from": 0.65, "to": 0.75}]}}))


def responses_are_those_of_the_simulator(data):
    """From rest, with noise of a deviation of 0.03."""
    for stretch in records.stretches(data / "column/run_1.csv", MODEL):
        for output in OUTPUTS:
            error = responses.errors_of(MODEL["elements"], stretch, output)
            assert abs(np.std(error) - math.sqrt(1e-3)) < 2e-3, (output, np.std(error))
            assert abs(np.mean(error)) < 5e-3, (output, np.mean(error))


def least_squares_finds_an_aged_gain(data):
    seen = records.stretches(data / "aged_column/run_old.csv", MODEL)
    found = least_squares.correct(MODEL, seen, runs.horizons(MODEL, seen))
    for before, after in zip(MODEL["elements"], found["elements"]):
        factor = 0.7 if runs.pair_of(before) == PAIR else 1.0
        assert abs(after["gain"] / before["gain"] - factor) < 0.05, (before, after)


def transforms_are_those_of_the_library():
    """Slope 1 at the operating point, the inverse, and values of mle/model/transform.h."""
    both = [{"kind": "exponential", "curvature": 0.02}, {"kind": "log", "zero": 60.0},
            {"kind": "equal_percentage", "rangeability": 50.0, "closed": 0.0, "open": 100.0},
            {"kind": "power", "exponent": -0.7, "zero": 1.0},
            {"kind": "quick_opening", "closed": 5.0, "open": 100.0},
            {"kind": "sinh", "curvature": 0.05}, {"kind": "sinh", "curvature": -0.05},
            {"kind": "tanh", "curvature": 0.02}, {"kind": "tanh", "curvature": -0.02},
            {"kind": "piecewise_linear", "points": [[0, 0], [30, 10], [50, 40], [80, 50]]}]
    x = np.array([12.0, 40.0, 40.001, 55.0])
    for transform in both:
        there, back = transforms.of({"name": "u", "transform": {**transform, "at": 40.0}})
        z = there(x)
        assert np.allclose(back(z), x, atol=1e-9), transform
        assert z[1] == 40.0 and abs(z[2] - x[2]) < 1e-6, (transform, z)
        assert np.all(np.diff(z) > 0.0), transform
    assert transforms.of({"name": "u"}) is None
    # A valve of rangeability 50 at 55 %, with slope 1 at 40 %.
    valve = transforms.of({"transform": {**both[2], "at": 40.0}})[0]
    c = math.log(50.0) / 100.0
    assert abs(valve(55.0) - (40.0 + (50.0**0.15 - 1.0) / c)) < 1e-12
    # A static element between two transforms leaves no error, but for the level.
    element = {"input": "u", "output": "y", "gain": 2.0, "time_constant": 0.0, "delay": 0.0}
    model = {"inputs": [{"name": "u", "transform": {**both[2], "at": 40.0}}],
             "outputs": [{"name": "y", "transform": {"kind": "log", "at": 3.0}}],
             "elements": [{**element, "gain": 0.01}]}
    u = np.tile([30.0, 40.0, 52.0], 4)
    y = transforms.of(model["outputs"][0])[1](3.0 + 0.01 * (valve(u) - 40.0))
    error = transforms.errors_of(model, stretch_of({"u": u, "y": y}, 1.0), "y")
    assert np.allclose(error, 0.0, atol=1e-12), error


STAND_IN = """#!{python}
import json, pathlib, sys
flags = dict(argument[2:].split("=", 1) for argument in sys.argv[1:])
given, truth = (json.loads(pathlib.Path(file).read_text()) for file in (flags["model"], {truth!r}))
out = pathlib.Path(flags["out"])
out.mkdir()
decision = "no_change" if given["elements"] == truth["elements"] else "corrected"
(out / "result.json").write_text(json.dumps({{"decision": decision, "verdict": []}}))
(out / "model.json").write_text(json.dumps(truth))
"""


def run(data, out, command, *more):
    return subprocess.run([sys.executable, source / "benchmarks/real/run", f"--data={data}",
                           f"--command={command}", f"--out={out}", *more],
                          capture_output=True, text=True)


def summary_of(out):
    return {line["row"]: line for line in
            json.loads((out / "results.json").read_text())["summary"]}


def a_folder_is_run(data, out):
    """By a command that knows the truth."""
    command = out.with_name("stand_in")
    command.write_text(STAND_IN.format(python=sys.executable,
                                       truth=str(source / "configs/wood_berry.json")))
    command.chmod(0o755)
    first = run(data, out, command, "--plants=^column|tclab")
    assert first.returncode == 0, first.stderr[-2000:]
    assert "4 of 4 runs, 100 %" in first.stderr and "tclab: skipped" in first.stderr, first.stderr
    results = (out / "results.json").read_bytes()
    second = run(data, out, command, "--plants=^column|tclab", "--jobs=1")
    assert " runs, " not in second.stderr, second.stderr
    assert (out / "results.json").read_bytes() == results and second.stdout == first.stdout
    found = summary_of(out)
    for row, ours in (
            ("plants, aged on purpose: error of the aged output over three horizons down",
             "2 of 2"),
            ("plants: any output worse by more than 5 %, unaged runs included", "0 of 4"),
            ("plants, aged on purpose: the aged parameter named, and no other", "2 of 2"),
            ("plants, nothing aged: a model is changed", "0 of 2")):
        assert found[row]["found"] == ours, (row, found[row])


def mle_correct_is_run(data, out):
    done = run(data, out, build / "apps/mle_correct", "--plants=aged_column")
    assert done.returncode == 0, done.stderr[-2000:]
    row = summary_of(out)["true responses, known ageing: named alone, by the right factor"]
    assert row["found"] == "1 of 1", done.stdout


def a_wrong_declaration_is_refused(data, out):
    (data / "plants.json").write_text("{\"column\": {\"models\": []}}")
    refused = run(data, out, build / "apps/mle_correct")
    assert refused.returncode == 2 and "column: \"records\" is missing" in refused.stderr, refused


def experiments_are_the_same_at_every_run(scratch):
    made = []
    for name in ("once", "again"):
        subprocess.run([source / "benchmarks/real/experiments", f"--out={scratch / name}",
                        "--plants=heating"], check=True)
        made.append({file.name: file.read_bytes()
                     for file in (scratch / name / "heating").iterdir()})
    assert made[0] == made[1] and len(made[0]) == 3, [list(files) for files in made]
    declared = records.declarations(scratch / "once")
    (case,) = records.cases(scratch / "once/heating", "heating", declared["heating"])
    assert case.record.name == "record.csv"
    # The fitted gain is near that of the plant at its middle: a curve of 0.3 u².
    (element,) = json.loads(case.model.read_text())["elements"]
    assert 0.2 < abs(element["gain"]) < 4.5 and element["time_constant"] > 20.0, element


step_responses_are_exact()
transforms_are_those_of_the_library()
levels_do_not_count_and_ramps_do()
declarations_are_checked()
what_was_changed_is_named()
the_error_of_the_horizons_is_a_mean_of_ratios()
with tempfile.TemporaryDirectory() as scratch:
    scratch = pathlib.Path(scratch)
    records_are_read(scratch)
    experiments_are_the_same_at_every_run(scratch)
    folder = scratch / "data"
    folder.mkdir()
    make_plants(folder)
    responses_are_those_of_the_simulator(folder)
    least_squares_finds_an_aged_gain(folder)
    a_folder_is_run(folder, scratch / "out")
    mle_correct_is_run(folder, scratch / "out_of_command")
    a_wrong_declaration_is_refused(folder, scratch / "out_of_command")
