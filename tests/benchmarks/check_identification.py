"""check_identification.py SOURCE BUILD: the arithmetic of benchmarks/peers/identification, and its smallest run."""

import argparse
import importlib.machinery
import importlib.util
import math
import pathlib
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
sys.dont_write_bytecode = True
script = str(source / "benchmarks/peers/identification")
loader = importlib.machinery.SourceFileLoader("identification", script)
identification = importlib.util.module_from_spec(
    importlib.util.spec_from_loader("identification", loader))
loader.exec_module(identification)

MODEL = {
    "outputs": [{"name": "y"}],
    "inputs": [{"name": "u"}, {"name": "v"}],
    "elements": [{"output": "y", "input": "u", "gain": 2.0, "time_constant": 5.0, "delay": 1.0}],
}


def step_responses_are_those_of_first_order():
    responses = identification.true_responses(MODEL, 0.5, 9)
    assert responses["y/v"] == [0.0] * 9
    assert responses["y/u"][:3] == [0.0] * 3, responses["y/u"]
    assert math.isclose(responses["y/u"][8], 2.0 * (1.0 - math.exp(-3.0 / 5.0)), rel_tol=1e-12)


def the_distance_is_a_sum_of_squares():
    truth = {"y/u": [0.0, 1.0], "y/v": [0.0, 0.0]}
    assert identification.distance(truth, {"y/u": [0.5, 3.0], "y/v": [0.0, -1.0]}) == 5.25
    assert identification.distance(truth, {"y/u": [0.0, math.nan], "y/v": [0.0, 0.0]}) == math.inf
    # A longer response is judged where the truth is known.
    assert identification.distance(truth, {"y/u": [0.0, 1.0, 9.0], "y/v": [0.0, 0.0]}) == 0.0


def plants_age_as_their_names_say():
    cases = {case.name: case for case in identification.cases()}
    gain = cases["Wood-Berry, gain"].plant()["elements"]
    assert [element["gain"] for element in gain] == [6.4, -18.9, 3.3, -19.4], gain
    delay = cases["Wood-Berry, delay"].plant()["elements"]
    assert [element["delay"] for element in delay] == [1.0, 7.0, 7.0, 7.0], delay
    assert cases["Wood-Berry, gain"].samples() == 501


def peers_get_deviations_from_rest():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        window = folder / "window.csv"
        window.write_text("time,u,v,y,y_setpoint\n" +
                          "".join(f"{k},{k},{7},{2 * k + 1},0\n" for k in range(6)))
        identification.write_peer_files(folder, [window], MODEL, 12, 3, 2)
        rows = [[float(value) for value in line.split()]
                for line in (folder / "window_1.txt").read_text().splitlines()]
        # y, u and v less the means of the first two samples.
        assert rows[0] == [-1.0, -0.5, 0.0] and rows[5] == [9.0, 4.5, 0.0], rows
        assert (folder / "settings.txt").read_text().split() == ["1", "2", "12", "3"]


def tables_have_the_worst_run():
    text = identification.table("T", "E", {"a": [(1.0, 2.0, "x"), (5.0, 4.0, "y")]}, max)
    assert "| a | 3 (5) | 3.0 | x (1), y (1) |" in text, text


def a_plant_is_judged():
    """A correction beside the peer that needs NumPy alone."""
    kernel = "kernel FIR"
    has_numpy = subprocess.run(["/usr/bin/python3", "-c", "import numpy"], stderr=subprocess.DEVNULL).returncode == 0
    methods = ["output_error", *([kernel] if has_numpy else [])]
    with tempfile.TemporaryDirectory() as out:
        arguments = argparse.Namespace(apps=build / "apps", out=pathlib.Path(out), cases="^two_by_two", seeds=1)
        ((_, rows),) = identification.judge_plants(arguments, methods)
    initial, *judged = (rows[method][0][0] for method in ("the initial model", *methods))
    assert all(error < initial for error in judged), rows


step_responses_are_those_of_first_order()
the_distance_is_a_sum_of_squares()
plants_age_as_their_names_say()
peers_get_deviations_from_rest()
tables_have_the_worst_run()
a_plant_is_judged()
