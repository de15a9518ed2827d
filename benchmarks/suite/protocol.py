"""How a method is called, and what it leaves (docs/benchmark.md has the protocol).

    PROGRAM FOLDER

FOLDER has model.json and record.csv, for methods marked so also loop.json. A method leaves
decision.txt there, and in model.json what it would have in the controller.
"""

import csv
import dataclasses
import json
import os
import pathlib
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
DECISIONS = ("no_change", "corrected", "mismatch", "cannot_tell")
LONGEST = 600.0  # seconds of the processor
PARAMETERS = ("gain", "time_constant", "delay")


@dataclasses.dataclass(frozen=True)
class Method:
    """A program with what the page says of it."""

    name: str
    program: str  # words as of a shell; a name alone is a file beside methods.json
    source: str = ""  # the publication
    settings: str = ""
    corrects: bool = True  # else it detects, and leaves the model
    control_law: bool = False  # gets loop.json
    ours: bool = False
    tracks: tuple = ()  # none: all
    needs: str = ""  # a command without which the method is left out

    def command(self):
        words = shlex.split(self.program)
        own = HERE / "methods" / words[0]
        if own.exists():
            words[0] = str(own)
        return ([sys.executable] if words[0].endswith(".py") else []) + words

    def files(self):
        """What the method is made of, as far as it can be seen."""
        paths = [pathlib.Path(word) for word in self.command() if word != sys.executable]
        return [path for path in paths if path.is_file()]


def shipped():
    rows = json.loads((HERE / "methods/methods.json").read_text())
    return [Method(**{**row, "tracks": tuple(row.get("tracks", ()))}) for row in rows]


@dataclasses.dataclass
class Answer:
    decision: str
    model: dict = None  # where it is corrected
    aged: list = dataclasses.field(default_factory=list)  # (output, input)
    intervals: list = dataclasses.field(default_factory=list)  # (output, input, key, lower, upper)
    reasons: list = dataclasses.field(default_factory=list)  # [code, where, ...]
    why: str = ""
    seconds: float = 0.0


class Wrong(ValueError):
    """What is wrong with what a method left."""


def limit(seconds):
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 5))


def ask(method, public, apps, loop, longest=LONGEST):
    """What the method makes of a copy of the folder."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch, "case")
        shutil.copytree(public, folder)
        if method.control_law:
            (folder / "loop.json").write_text(json.dumps(loop, indent=1))
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
                       "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1",
                       "MLE_APPS": str(apps)}
        with tempfile.TemporaryFile("w+") as err:
            process = subprocess.Popen([*method.command(), str(folder)], stdout=err, stderr=err,
                                       cwd=scratch, env=environment, start_new_session=True,
                                       preexec_fn=lambda: limit(longest))
            code, seconds = wait(process, 3.0 * longest)
            err.seek(0)
            said = err.read().strip().splitlines()
        try:
            answer = read(folder, code)
        except Wrong as wrong:
            last = f": {said[-1][:160]}" if code != 0 and said else ""
            answer = Answer("no_answer", why=f"{wrong}{last}".replace(scratch, ""))
        answer.seconds = round(seconds, 2)
        return answer


def wait(process, longest):
    """Exit code and processor seconds; the program and its children end after so long."""
    end = time.monotonic() + longest
    while time.monotonic() < end:
        pid, status, usage = os.wait4(process.pid, os.WNOHANG)
        if pid:
            break
        time.sleep(0.005)
    else:
        os.killpg(process.pid, signal.SIGKILL)
        _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_utime + usage.ru_stime


def read(folder, code):
    if code != 0:
        raise Wrong(f"exit code {code}")
    file = folder / "decision.txt"
    if not file.exists():
        raise Wrong("no decision.txt")
    rows = [row for row in csv.reader(file.read_text().splitlines()) if row]
    if not rows or rows[0][0] not in DECISIONS:
        raise Wrong(f"decision.txt must begin with one of {', '.join(DECISIONS)}")
    answer = Answer(rows[0][0])
    for row in rows[1:]:
        try:
            add(answer, row)
        except ValueError as error:
            raise Wrong(f"decision.txt: {','.join(row)}: {error}") from error
    if answer.decision == "corrected":
        answer.model = read_model(folder / "model.json")
    return answer


def add(answer, row):
    kind, *fields = row
    if kind == "aged":
        output, source = fields
        answer.aged.append((output, source))
    elif kind == "interval":
        output, source, key, lower, upper = fields
        if key not in PARAMETERS:
            raise ValueError(f"choose from {', '.join(PARAMETERS)}")
        answer.intervals.append((output, source, key, float(lower), float(upper)))
    elif kind == "reason":
        answer.reasons.append(fields)
    else:
        raise ValueError("choose from aged, interval, reason")


def read_model(file):
    try:
        model = json.loads(file.read_text())
        for element in model["elements"]:
            element["output"], element["input"], element["delay"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise Wrong(f"model.json: {type(error).__name__} {error}") from error
    return model
