#!/usr/bin/env python3
"""Runs of the commands with flags and files that nobody should give.

    hostile_flags.py --apps=DIR [--seconds=N] [--first=CASE] [--count=N] [COMMAND…]

A case is a usual, small run of a command in which one to three things are others: flags (of all
that `--help=all` names), or numbers in the files that it reads. They are at the ends of their
ranges and beyond, no numbers, other texts. `records` in the place of a command are usual runs of
mle_correct with an extreme record, `files` such of mle_correct and mle_convert with a file that is
no record and no model, `transforms` such of what takes models with curves, which are extreme
(hostile_files.py). A case must end with exit code 0, 1 or 2, and with 2 say
one line last, which begins with "error: "; it says and writes no NaN and no infinity, and JSON that
it writes is as docs/schemas say. What runs longer than --patience may have been asked for: it is
told to stop, twice at most, and must; `records`, `files` and `transforms` must end within a minute. The number of
a case makes it again: `--first=CASE --count=1`, with the same commands.

Memory is limited, so that what is asked for without bounds is refused.
"""

import argparse
import datetime
import functools
import json
import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time

from hostile_files import extreme_record, extreme_transform, in_another_unit, odd_files, usual_transform

try:
    import jsonschema
except ImportError:
    jsonschema = None

SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "docs/schemas"
MEMORY = 4 << 30  # bytes of addresses
STOPPING = 20.0  # s, within which a command stops when it is told to
# What would ask at the terminal, serve until it is stopped, or send something.
NOT_TRIED = {"serve", "flagfile", "fromenv", "tryfromenv", "undefok", "help", "version", "ask_password"}

MODEL = {"name": "tank", "time_unit": "min",
         "inputs": [{"name": "u1", "unit": "%"}, {"name": "u2", "unit": "%"}],
         "outputs": [{"name": "y1", "unit": "m"}, {"name": "y2", "unit": "K"}],
         "elements": [{"output": "y1", "input": "u1", "gain": 2, "time_constant": 4, "delay": 1},
                      {"output": "y1", "input": "u2", "gain": -0.5, "time_constant": 6, "delay": 2},
                      {"output": "y2", "input": "u2", "gain": 1, "time_constant": 5, "delay": 1}]}
AGEING = {"time_factor": 1440,
          "elements": [{"output": "y1", "input": "u1", "gain": [[0, 1.0], [60, 0.5]]}]}
EFFECTS = {"outputs": [{"name": "y1",
                        "arma": {"poles": [[0.8, 0.1]], "zeros": [0.5], "variance": 1e-3},
                        "sines": [{"amplitude": 0.05, "period": 25, "phase": 0.5}],
                        "steps": [[100, 0.2]],
                        "sensor": {"lag": 1.5, "noise_variance": 1e-4, "min": -9, "max": 9, "dead_from": 500},
                        "set_point": {"ramps": [[200, 60, 0.5]], "optimiser": {"interval": 15, "deviation": 0.02}},
                        "archive": {"exception": 0.02, "compression": 0.04, "max_interval": 60, "clock_offset": 0.6,
                                    "spikes": [[450, 3]]}}],
           "inputs": [{"name": "u1",
                       "load": {"variance": 1e-4, "time_constant": 40, "steps": [[200, 0.02]]},
                       "actuator": {"stiction": 0.02, "jump": 0.005, "rangeability": 30, "span": 20, "position": 0.5},
                       "archive": {"compression": 0.005, "step": True}}]}
CAMPAIGN = {"version": 1, "name": "small", "seeds": {"first": 1, "count": 2},
            "models": [{"name": "tank", "file": "model.json"},
                       {"name": "drawn", "random": {"outputs": 2, "inputs": 2, "gain": [0.5, 2],
                                                    "time_constant": [3, 9], "delay": [0, 3],
                                                    "max_condition_number": 20, "max_sensitivity": 2.5}}],
            "mismatches": [{"name": "gain", "changes": [{"gain_factor": 0.5, "time_constant_factor": 1.5,
                                                         "delay_shift": 1, "elements": 1}], "sizes": [1]}],
            "noise_variances": [0.001], "drift_variances": [1e-6],
            "effects": [{"name": "none"},
                        {"name": "load", "effects": {"outputs": [{"name": "y1", "steps": [[90, 0.1]]}]}}],
            "controllers": [{"name": "usual", "control_period": 1, "prediction_horizon": 20, "control_horizon": 3,
                             "output_weight": 1, "move_weight": 0.5, "disturbance_variance_ratio": 0.1}],
            "windows": [{"name": "one", "setpoint_step": 1, "window": 100, "changes": 2, "spacing": 200,
                         "outlier_share": 0.01, "longest_outlier": 5, "robust": "model"}],
            "estimators": ["none", "output_error:chi_square", "arx:none"], "ablations": ["none"],
            "selections": ["paper", {"name": "b", "rule": "blocks", "folds": 5, "block": 20, "response_deviations": 2}],
            "solvers": ["homotopy", {"name": "net", "elastic_net": 0.5}],
            "lambda_grid": {"min": 0.001, "max": 1, "count": 5},
            "sample_time": 1, "order": 8, "response_horizon": 60,
            "conversion": {"duration": 500, "penalty": 1e-4, "noise_variance": 0.001}}
CONTROLLERS = {"version": 1,
               "controllers": [{"name": "tank", "model": "model.json", "records": "records", "reference_days": 2,
                                "sample_time": 1, "level": 0.05, "least_change": 0.01, "model_error": 0.05,
                                "begin": "2024-02-27", "time_zone": "Europe/Berlin",
                                "prices": {"currency": "EUR", "price_squared_error": [200, 50],
                                           "price_engineer_hour": 100},
                                "tuning": {"control_period": 1, "prediction_horizon": 20, "control_horizon": 3,
                                           "output_weight": 1, "move_weight": 0.5}}]}
# The files of each command's usual run.
FILES = {"convert": ["model.json"],
         "correct": ["model.json", "run.csv"],
         "lifecycle": ["model.json", "ageing.json"],
         "reproduce": ["model.json", "plant.json"],
         "simulate": ["model.json", "plant.json", "effects.json", "ageing.json"],
         "study": ["campaign.json", "model.json"],
         "watch": ["controllers.json", "model.json", "records/days.csv"]}
MINUTE = 60.0  # s


def numbers(draw):
    return draw.choice(["0", "-0", "1", "-1", "2", "3", "7", "100", "1e3", "1e5", "1e6", "1e7", "1e9", "1e12", "1e18",
                        "1e100", "1e154", "1e300", "1.7e308", "-1e300", "1e-3", "1e-6", "1e-9", "1e-12", "1e-100",
                        "1e-300", "5e-324", "0.5", "0.999999999", "1.000000001", "2147483647", "2147483648",
                        "-2147483648", "4294967296", "9223372036854775807", "18446744073709551615", "1e400"])


def texts(draw):
    """No path out of the folder of the case: commands write where they are told to."""
    return draw.choice(["", " ", "nan", "inf", "-inf", "x", "é", "µ\u202e", "a,b", ",", ",,", ":", "a:b:c", "1,2,3",
                        "1:2", "1e3,1e-3", "y1:60:1", "y1:1e300:1e300", "u1", "y1", "true", "none", "auto",
                        "0x10", "1_000", "1 000", "1,5", "%s%n", "a/b", "a//b", "/dev/null", "nowhere/at/all", ".",
                        "--", "{}", "[", "[1,2]", "\n", "\t", "x" * 100_000, "1," * 10_000, "2024-01-01",
                        "9999-12-31 23:59:59", "0001-01-01", "1/2", "3/1", "30d", "1e300d", "1e-300s", "never,never",
                        "output_error:1", "sqlite:nowhere", "sqlite:", "postgresql://", "odbc:x",
                        os.fsdecode(b"\xff\xfe")])


def with_numbers(value, draw):
    """`value` with one of the numbers in it replaced."""
    places = list(re.finditer(r"\d+(\.\d+)?(e[-+]?\d+)?", value))
    if not places:
        return numbers(draw)
    place = draw.choice(places)
    other = numbers(draw)
    if draw.random() < 0.6:
        factor = draw.choice([0, 0.1, 0.5, 1.01, 2, 10, 100, 1e3, 1e4, 1e6, 1e9, 1e-2, 1e-3, 1e-6])
        other = f"{float(place[0]) * factor:g}"
    return value[:place.start()] + other + value[place.end():]


class World:
    """The files that usual runs need, and the flags of each command."""

    def __init__(self, apps, folder):
        self.apps = apps
        self.folder = folder
        self.write("model.json", MODEL)
        plant = json.loads(json.dumps(MODEL))
        plant["elements"][0]["gain"] = 1.2
        self.write("plant.json", plant)
        self.write("ageing.json", AGEING)
        self.write("effects.json", EFFECTS)
        self.write("campaign.json", CAMPAIGN)
        self.usual = {
            "convert": ["--model=model.json", "--form=state_space", "--out=out.json", "--interval=1"],
            "correct": ["--model=model.json", "--data=run.csv", "--out=out", "--figures=false"],
            "lifecycle": ["--model=model.json", "--ageing=ageing.json", "--out=out", "--figures=false",
                          "--years=0.1", "--change_every=5d", "--sample_time=1", "--seeds=1",
                          "--policies=never,output_error:2,test:1"],
            "reproduce": ["--model=model.json", "--plants=aged:plant.json", "--out=out", "--figures=false",
                          "--sample_time=1", "--order=10", "--window=200"],
            "simulate": ["--model=model.json", "--plant=plant.json", "--out=out.csv", "--sample_time=1",
                         "--duration=600", "--setpoints=y1:60:1,y2:300:1", "--effects=effects.json"],
            "study": ["--campaign=campaign.json", "--out=out", "--figures=false"],
            "watch": ["--controllers=controllers.json", "--out=out"],
        }
        self.simulate("run.csv", ["--effects="])
        changes = ",".join(f"y1:{300 * i}:{i % 2}" for i in range(1, 19))
        self.simulate("days.csv", ["--effects=", "--duration=5800", f"--setpoints={changes}"])
        self.write_history("days.csv")
        self.write("controllers.json", CONTROLLERS)
        self.flags = {command: self.flags_of(command) for command in FILES}

    def write(self, name, content):
        (self.folder / name).write_text(json.dumps(content))

    def simulate(self, name, more):
        run = subprocess.run([self.apps / "mle_simulate", *self.usual["simulate"], f"--out={name}", *more],
                             cwd=self.folder, capture_output=True, text=True)
        if run.returncode != 0:
            raise SystemExit("no record to try with: " + run.stderr)

    def write_history(self, name):
        """A record by the minute as a historian exports it, with dates."""
        records = self.folder / "records"
        records.mkdir()
        header, *rows = [line for line in (self.folder / name).read_text().splitlines() if not line.startswith("#")]
        begin = datetime.datetime(2024, 2, 27)
        with (records / "days.csv").open("w") as file:
            print(header, file=file)
            for row in rows:
                minutes, values = row.split(",", 1)
                print(begin + datetime.timedelta(minutes=float(minutes)), values, sep=",", file=file)
        (self.folder / name).unlink()

    def flags_of(self, command):
        """(name, default) of each flag that is tried."""
        text = subprocess.run([self.apps / f"mle_{command}", "--help=all"], capture_output=True, text=True,
                              check=True).stdout
        found = re.findall(r"^  --(\w+) \[(.*?)\]", text, re.MULTILINE)
        return [(name, default) for name, default in found if name not in NOT_TRIED]

    def case(self, number, commands):
        """(command, its arguments, contents of files that are others, kind of these or "")."""
        draw = random.Random(number)
        command = draw.choice(commands)
        if command == "records":
            return self.extreme_case(draw)
        if command == "files":
            return self.odd_case(number)
        if command == "transforms":
            return self.transform_case(draw)
        arguments = list(self.usual[command])
        files = {}
        given = dict(argument[2:].split("=", 1) for argument in arguments if "=" in argument)
        for _ in range(draw.choice([1, 1, 1, 2, 3])):
            if draw.random() < 0.4:
                file = draw.choice(FILES[command])
                files[file] = with_numbers(files.get(file) or (self.folder / file).read_text(), draw)
                continue
            name, default = draw.choice(self.flags[command])
            usual = given.get(name, default)
            is_number = re.search(r"\d", usual) is not None
            how = draw.random()
            if how < 0.6 and is_number:
                value = with_numbers(usual, draw)
            elif how < 0.8:
                value = numbers(draw)
            else:
                value = texts(draw)
            arguments.append(f"--{name}={value}")
        return command, arguments, files, ""

    def extreme_case(self, draw):
        """A record in extreme units, an extreme record, or also a model that is another."""
        record, model = ((self.folder / name).read_text() for name in ("run.csv", "model.json"))
        kind = draw.random()
        if kind < 0.4:
            record, model = in_another_unit(record, json.loads(model), draw)
            return "correct", self.usual["correct"], {"run.csv": record, "model.json": json.dumps(model)}, "extreme"
        files = {"run.csv": extreme_record(record, draw)}
        if kind < 0.6:
            files["model.json"] = with_numbers(model, draw)
        return "correct", self.usual["correct"], files, "extreme"

    def transform_case(self, draw):
        """A model one or two of whose channels have curves, one of these an extreme one."""
        model = json.loads((self.folder / "model.json").read_text())
        channels = draw.sample(model["inputs"] + model["outputs"], draw.choice([1, 1, 2]))
        for channel in channels:
            channel["transform"] = usual_transform(draw)
        if draw.random() < 0.8:
            channels[0]["transform"] = extreme_transform(draw)
        command, more = draw.choice([
            ("simulate", ["--plant="]), ("correct", []), ("convert", ["--form=element_table", "--out=out.csv"]),
            ("convert", [f"--at={channels[0]['name']}:2"])])
        return command, [*self.usual[command], *more], {"model.json": json.dumps(model)}, "transforms"

    def odd_case(self, number):
        """Each kind of file in each place in turn."""
        places = [("correct", "run.csv", []), ("correct", "model.json", []),
                  ("correct", "tags.csv", ["--tag_file=tags.csv"]),
                  ("correct", "model.mat", ["--model=model.mat"]), ("convert", "model.json", [])]
        command, file, more = places[number % len(places)]
        usual = "run.csv" if file == "run.csv" else "model.json"
        kinds = odd_files((self.folder / usual).read_text())
        name, content = kinds[number // len(places) % len(kinds)]
        return command, [*self.usual[command], *more], {file: content}, name


def put(path, content):
    """Texts, bytes, or what makes it."""
    if callable(content):
        content(path)
    else:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def refuse_constant(name):
    raise ValueError(f"JSON with {name}")


@functools.lru_cache
def schema_of(command, name):
    """Of a file that the command writes; None where there is none, or nothing that knows schemas."""
    stem = "lifecycle" if (command, name) == ("lifecycle", "result.json") else pathlib.Path(name).stem
    file = SCHEMAS / f"{stem}.schema.json"
    if jsonschema is None or not file.exists():
        return None
    return jsonschema.Draft202012Validator(json.loads(file.read_text()))


def check_files(command, folder, given, names_them):
    """JSON is valid, and as its schema says; no number of a page, a figure or a table is NaN or infinite."""
    for file in sorted(folder.rglob("*.*")):
        if file.name in given or file.suffix not in (".json", ".html", ".svg", ".csv"):
            continue
        text, name = file.read_text(), file.relative_to(folder)
        if file.suffix != ".json":
            place = re.search(r"(?<![\w.])(nan|inf)(?![\w.])", text)
            assert names_them or place is None, f"{name}: {text[max(0, place.start() - 60):place.end() + 60]}"
            continue
        try:
            content = json.loads(text, parse_constant=refuse_constant)
        except ValueError as error:
            raise AssertionError(f"{name}: {error}") from error
        schema = schema_of(command, file.name)
        for error in schema.iter_errors(content) if schema else ():
            raise AssertionError(f"{name}: {'/'.join(map(str, error.absolute_path))}: {error.message[:200]}")


def run_case(world, number, commands, patience):
    """Exit code, or None where it was ended. Raises AssertionError for a finding."""
    command, arguments, files, kind = world.case(number, commands)
    patience = MINUTE if kind else patience
    with tempfile.TemporaryDirectory(dir=world.folder) as folder:
        folder = pathlib.Path(folder)
        for file in {*FILES[command], "records/days.csv", *files}:
            (folder / file).parent.mkdir(exist_ok=True)
            put(folder / file, files[file] if file in files else (world.folder / file).read_bytes())
        process = subprocess.Popen([world.apps / f"mle_{command}", *arguments], cwd=folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=limit_memory,
                                   start_new_session=True)
        for told_to_stop, wait in ((0, patience), (1, STOPPING), (2, 5.0)):
            try:
                out, err = process.communicate(timeout=wait)
                break
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGTERM)
        else:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
            raise AssertionError("does not stop when it is told to twice")
        text = err.decode(errors="replace")
        code = process.returncode
        if told_to_stop and kind:
            raise AssertionError(f"does not end within {patience} s: {text[-2000:]}")
        if told_to_stop and code in (-signal.SIGTERM, 128 + signal.SIGTERM):
            return None
        if code not in (0, 1, 2):
            raise AssertionError(f"exit code {code}: {text[-2000:]}")
        lines = [line for line in text.split("\n") if line]
        errors = [line for line in lines if line.startswith("error: ")]
        if code == 2 and (len(errors) != 1 or lines[-1] != errors[0]):
            raise AssertionError(f"exit code 2 with {len(errors)} errors: {text[-2000:]}")
        if code == 2 and len(errors[0]) < 20:
            raise AssertionError(f"an error that says nothing: {errors[0]}")
        own = re.sub("'[^'\n]*'", "''", out.decode(errors="replace") + text)  # without what is quoted
        said = re.search(r".*((?<![\w.])(nan|inf)(?![\w.])|Check failed|\*\*\*).*", own)
        names_them = re.search("nan|inf", " ".join(arguments).lower()) is not None
        if said and not names_them:
            raise AssertionError(f"says {said[0][-2000:]}")
        check_files(command, folder, {*FILES[command], *files}, names_them)
        return code


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--apps", type=lambda path: pathlib.Path(path).resolve(), required=True, metavar="DIR")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--first", type=int, default=None, metavar="CASE", help="default: of the time")
    parser.add_argument("--count", type=int, default=0)
    parser.add_argument("--patience", type=float, default=10.0, help="s, after which a run is ended")
    parser.add_argument("commands", nargs="*", metavar="COMMAND")
    flags = parser.parse_args()
    commands = flags.commands or [*FILES, "records", "files", "transforms"]
    first = flags.first if flags.first is not None else time.time_ns() // 1_000_000 * 1000
    begin = time.monotonic()
    codes = {}
    findings = 0
    number = first
    with tempfile.TemporaryDirectory() as folder:
        world = World(flags.apps, pathlib.Path(folder))
        while (number < first + flags.count) if flags.count else time.monotonic() - begin < flags.seconds:
            try:
                code = run_case(world, number, commands, flags.patience)
                codes[code] = codes.get(code, 0) + 1
            except AssertionError as error:
                findings += 1
                command, arguments, files, kind = world.case(number, commands)
                print(f"case {number}: mle_{command} {' '.join(a[:200] for a in arguments)!r}, {sorted(files)} {kind}\n"
                      f"  {error}", flush=True)
            number += 1
    print(f"{number - first} runs: {codes.get(0, 0)} done, {codes.get(1, 0)} not usable, {codes.get(2, 0)} refused, "
          f"{codes.get(None, 0)} ended as too long, {findings} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
