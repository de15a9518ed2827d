"""check_suite.py SOURCE BUILD: the measures of benchmarks/suite, and its smallest run."""

import csv
import json
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
sys.dont_write_bytecode = True
suite = source / "benchmarks/suite"
sys.path[:0] = [str(suite), str(suite / "methods")]
import cases  # noqa: E402
import common  # noqa: E402
import measures  # noqa: E402
import numpy as np  # noqa: E402
import page  # noqa: E402
import protocol  # noqa: E402
import publications  # noqa: E402
import tracks  # noqa: E402

MODEL = {"outputs": [{"name": "y"}], "inputs": [{"name": "u"}, {"name": "v"}],
         "elements": [{"output": "y", "input": "u", "gain": 2.0, "time_constant": 5.0, "delay": 1.0},
                      {"output": "y", "input": "v", "gain": 1.0, "time_constant": 3.0, "delay": 0.0}]}


def with_gain(gain):
    model = json.loads(json.dumps(MODEL))
    model["elements"][0]["gain"] = gain
    return model


def judged(kind, true, aged):
    truth = cases.Truth(given=MODEL, true=true, interval=1.0, horizon=50.0, aged=aged, kind=kind)
    return measures.Judged(cases.Case("effects", "x", "p", kind, 0), truth)


METHOD = protocol.Method("m", "m")


def distances_harm_and_names_are_as_defined():
    aged = judged("aged", with_gain(1.0), {("y", "u")})
    (_, relative), (_, none) = aged.before, aged.truth.distance(with_gain(1.0))
    assert math.isclose(relative, 1.0) and none == 0.0  # ‖2s − s‖² / ‖s‖²
    def row(model, **more):
        return aged.row(METHOD, protocol.Answer("corrected", model, **more))
    assert (row(with_gain(1.1))["named"], row(with_gain(1.1))["harm"]) == ("exactly", 0)
    assert row(with_gain(3.5))["harm"] == 1
    assert row(with_gain(1.1), aged=[("y", "v")])["named"] == "another"
    assert row(with_gain(1.1), aged=[("y", "v"), ("y", "u")])["named"] == "in part"
    kept = aged.row(METHOD, protocol.Answer("cannot_tell"))
    assert kept["named"] == "missed" and kept["relative_E_after"] == kept["relative_E_before"]
    found = row(with_gain(1.1), intervals=[("y", "u", "gain", 0.9, 1.2), ("y", "v", "delay", 1.0, 2.0)])
    assert (found["inside"], found["intervals"]) == (1, 2)
    assert row({"elements": [{"output": "y", "input": "u", "delay": 0.0}]})["decision"] == "no_answer"
    quiet = judged("none", MODEL, None)
    assert [quiet.row(METHOD, protocol.Answer("corrected", with_gain(2.0 * factor)))["harm"]
            for factor in (1.01, 1.03)] == [0, 1]
    detector = protocol.Method("d", "d", corrects=False)
    assert aged.row(detector, protocol.Answer("mismatch"))["relative_E_after"] is None


def answers_are_read_and_refused(folder):
    (folder / "model.json").write_text(json.dumps(MODEL))
    (folder / "decision.txt").write_text('corrected\naged,"y, top",u\ninterval,y,u,gain,1,2\nreason,backlash,u\n')
    answer = protocol.read(folder, 0)
    assert answer.aged == [("y, top", "u")] and answer.intervals == [("y", "u", "gain", 1.0, 2.0)], answer
    assert answer.reasons == [["backlash", "u"]] and answer.model == MODEL
    for text in ("", "maybe\n", "corrected\naged,y\n", "no_change\nbecause,x\n", "corrected\ninterval,y,u,lag,1,2\n"):
        (folder / "decision.txt").write_text(text)
        try:
            protocol.read(folder, 0)
        except protocol.Wrong:
            continue
        raise AssertionError(text)


def first_order_is_found():
    times = np.arange(200.0)
    found = common.first_order(-3.0 * -np.expm1(-np.maximum(times - 7.3, 0.0) / 21.0), 1.0)
    for key, value in (("gain", -3.0), ("time_constant", 21.0), ("delay", 7.3)):
        assert math.isclose(found[key], value, rel_tol=0.02), found


def tails_are_those_of_tables():
    assert math.isclose(common.normal_quantile(0.025), 1.959964, rel_tol=1e-5)
    assert math.isclose(common.chi_square_tail(18.307, 10), 0.05, rel_tol=0.01)


def seeds_and_limits():
    assert cases.number_of("a", "b") == cases.number_of("a", "b") != cases.number_of("a", "c")
    at_limits = [case for case in tracks.power("full", range(1), None) if case.name.startswith("1 of ")]
    assert len({case.name for case in at_limits}) == 24  # gain, time constant, dead time; four elements; both ways
    for case in at_limits:
        trial = case.make_trial(case, 3)
        (change,) = [(before, after) for before, after in zip(trial.model["elements"], trial.truth["elements"])
                     if before != after]
        ((before, after),) = [(change[0][key], change[1][key]) for key in ("gain", "time_constant", "delay")
                              if change[0][key] != change[1][key]]
        assert f"{100.0 * (after / before - 1.0):+.0f} %" in case.name, case
    short = [case.name for case in tracks.power("short", range(1), None) if case.name.startswith("1 of ")]
    assert [sum(key in name for name in short) for key in ("gain", "time_constant", "delay")] == [2, 2, 2]
    drawn = tracks.draw_level(cases.ByFlags("levels", "0", "column_level", "aged", 0), random.Random(1))
    assert sum(a != b for a, b in zip(drawn.given["elements"], drawn.plant["elements"])) == 1


def shares_and_means():
    assert page.share(1, 4) == 25.0 and page.share(0, 0) is None
    assert math.isclose(page.geometric([1.0, 4.0, math.inf, None]), 2.0)


def power_is_counted_by_limits():
    def row(name, decision):
        return {"track": "power", "method": "m", "scenario": name, "decision": decision}
    rows = [row("0", "no_change"), row("0.2 of +7 %, gain of y to u", "corrected"),
            row("1 of +7 %, gain of y to u", "mismatch"), row("1 of -40 %, delay of y to u", "cannot_tell")]
    ((_, *line),) = page.power_table(rows, [METHOD])
    assert line == ["0", "100", "–", "50", "–", "100", "–", "0", "1 of 2"], line


def publications_are_reproduced():
    """Those of which figures are at hand; Octave's where it is."""
    figures = [figure for check in publications.CHECKS for figure in check(10)]
    assert len(figures) >= 21 and all(figure.holds() for figure in figures), figures


def run(out, *flags):
    done = subprocess.run([sys.executable, suite / "run", f"--apps={build / 'apps'}", f"--out={out}", "--form=smoke",
                           "--jobs=2", "--cases=^(paper/gain|laboratory/)", "--tracks=paper,laboratory",
                           f"--method=mine={suite / 'examples/method.py'}", *flags], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return {name: (out / name).read_bytes() for name in ("results.csv", "benchmark.html", "benchmark.md")}


def two_runs_give_the_same_bytes(folder):
    methods = "--methods=^(mle_correct|leave|closest|partial)"
    one = run(folder / "one", methods)
    for part in ("1/2", "2/2"):
        run(folder / "two", methods, f"--part={part}")
    two = run(folder / "two", methods, "--collect")
    assert one == two
    rows = list(csv.DictReader(one["results.csv"].decode().splitlines()))
    assert len(rows) == 4 * 5, len(rows)
    ours = {row["kind"]: row for row in rows if row["method"] == "mle_correct" and row["track"] == "paper"}
    assert ours["none"]["decision"] == "no_change" and ours["aged"]["decision"] == "corrected", ours
    assert ours["aged"]["named"] == "exactly" and float(ours["aged"]["loop"]) < 1.0, ours
    # Step responses of the paper's experiment, over 100 min.
    assert abs(float(ours["aged"]["E_before"]) / 19400 - 1.0) < 0.02, ours
    assert not re.search(rb"https?://|src=|href=", one["benchmark.html"])
    assert b"| mine |" in one["benchmark.md"]


def a_method_that_fails_is_told_and_asked_again(folder):
    script, allowed = folder / "mine.py", folder / "allowed"
    script.write_text(f"import pathlib, sys\nassert pathlib.Path({str(allowed)!r}).exists()\n"
                      "pathlib.Path(sys.argv[1], 'decision.txt').write_text('mismatch')\n")
    command = [sys.executable, suite / "run", f"--apps={build / 'apps'}", f"--out={folder / 'out'}", "--form=smoke",
               "--tracks=paper", "--cases=^paper/gain", "--methods=^$", f"--method=mine={script}"]
    failed = subprocess.run(command, capture_output=True, text=True)
    assert "mine: no answer in 2 of 2 cases, the first: exit code 1: AssertionError" in failed.stderr, failed.stderr
    allowed.touch()
    again = subprocess.run(command, capture_output=True, text=True)
    assert "no answer" not in again.stderr and "| paper | mine | 1 + 1 | 100 | 100 |" in again.stdout, again.stdout


def folders_are_left_to_try_a_method_on(folder):
    done = subprocess.run([sys.executable, suite / "run", f"--apps={build / 'apps'}", f"--write={folder}",
                           "--tracks=paper", "--cases=gain.*aged"], capture_output=True, text=True)
    (written,) = map(pathlib.Path, done.stdout.split())
    assert {file.name for file in written.iterdir()} == {"model.json", "record.csv", "loop.json", "truth.json"}
    given, true = (json.loads((written / name).read_text())["elements"] for name in ("model.json", "truth.json"))
    assert [after["gain"] / before["gain"] for before, after in zip(given, true)] == [0.5, 1.0, 0.5, 1.0]


def lives_are_watched(folder):
    program = build / "benchmarks/watch_benchmark"
    if not program.exists():
        print("no watch_benchmark: the track watch is left out")
        return
    done = subprocess.run([sys.executable, suite / "run", f"--apps={build / 'apps'}", f"--watch={program}",
                           f"--out={folder}", "--form=smoke", "--tracks=watch"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    assert "| mle_watch | 1 + 3 |" in done.stdout, done.stdout


distances_harm_and_names_are_as_defined()
first_order_is_found()
tails_are_those_of_tables()
seeds_and_limits()
shares_and_means()
power_is_counted_by_limits()
publications_are_reproduced()
with tempfile.TemporaryDirectory() as scratch:
    answers_are_read_and_refused(pathlib.Path(scratch))
with tempfile.TemporaryDirectory() as scratch:
    two_runs_give_the_same_bytes(pathlib.Path(scratch))
    a_method_that_fails_is_told_and_asked_again(pathlib.Path(scratch))
    folders_are_left_to_try_a_method_on(pathlib.Path(scratch) / "folders")
    lives_are_watched(pathlib.Path(scratch))
