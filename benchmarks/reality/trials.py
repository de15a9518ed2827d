"""One run of the benchmark: the record, the correction, and what became of it."""

import csv
import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

import adversary
import curves
import hardware
import mistakes
import scenarios

COLUMNS = ["kind", "scenario", "plant", "seed", "decision", "exit_code", "E_before", "E_after",
           "largest_change", "inside", "intervals", "worst_fall", "seconds", "codes", "aged",
           "named", "told", "reason_true", "curve_error", "curve_inside", "curve_points",
           "curves_false", "reason"]


class Failed(RuntimeError):
    pass


@dataclasses.dataclass
class Done:
    exit_code: int
    seconds: float  # of the processor
    err: str


def call(accepted, *command):
    """Runs a command, one thread, and insists on one of the accepted exit codes."""
    with tempfile.TemporaryFile("w+") as err:
        process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL,
                                   stderr=err, env={**os.environ, "OMP_NUM_THREADS": "1"})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        err.seek(0)
        done = Done(process.returncode, usage.ru_utime + usage.ru_stime, err.read())
    if done.exit_code not in accepted:
        raise Failed(f"{' '.join(map(str, command))}\nexit code {done.exit_code}: "
                     f"{done.err[-2000:]}")
    return done


def flags_of(flags):
    for name, value in flags.items():
        yield f"--{name}" if value is True else f"--{name}={value}"


def follows(record, outputs):
    """Whether outputs are at their set points, to half the range of these, at the end of it."""
    with open(record, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row[outputs[0]]]
    for name in outputs:
        points = [float(row[f"{name}_setpoint"]) for row in rows]
        end = rows[-max(1, len(rows) // 10):]
        apart = [abs(float(row[name]) - float(row[f"{name}_setpoint"])) for row in end]
        if sum(apart) / len(apart) > 0.5 * (max(points) - min(points)):
            return False
    return True


def simulate(apps, trial, seed, scratch):
    """Writes model.json, truth.json and record.csv; False if the loop is unstable, or if the plant
    has aged so far that it cannot be held at its set points: no routine, and not at the operating
    point that the truth is of."""
    files = {"model": trial.model, "plant": trial.truth, "truth": trial.true_model(),
             "effects": trial.effects_file(), "ageing": trial.ageing_file()}
    for name, content in files.items():
        (scratch / f"{name}.json").write_text(json.dumps(content))
    plant = trial.plant.simulated or scratch / "plant.json"
    done = call((0, 1), apps / "mle_simulate", f"--model={scratch}/model.json",
                f"--plant={plant}", f"--effects={scratch}/effects.json",
                f"--ageing={scratch}/ageing.json", *flags_of(trial.record_flags()),
                f"--seed={seed}", f"--out={scratch}/record.csv")
    if done.exit_code != 0:
        return False
    return trial.factors is None or follows(scratch / "record.csv", trial.outputs)


def drop_set_points(record):
    """A record as of a historian that has none."""
    with record.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    kept = [i for i, name in enumerate(header) if not name.endswith("_setpoint")]
    with record.open("w", newline="") as stream:
        csv.writer(stream).writerows([row[i] for i in kept] for row in [header, *rows])


def correct(arguments, scratch, model, record, truth=None, flags=()):
    """The decision with its figures, as columns of a row."""
    out = scratch / "out"
    given = [f"--truth={truth}"] if truth else []
    done = call((0, 1, 2), arguments.apps / "mle_correct", f"--model={model}",
                f"--data={record}", *given, f"--out={out}", "--figures=false", "--threads=1",
                *flags, *arguments.correct.split())
    row = {"exit_code": done.exit_code, "seconds": round(done.seconds, 2)}
    result_file = out / "result.json"
    if not result_file.exists():
        # What a command with bad input says; a record that cannot be used is an answer too.
        row.update(decision="no_answer", reason=done.err.strip().splitlines()[-1][:200])
        return row, None
    result = json.loads(result_file.read_text())
    decision = result["decision"]
    row.update(decision="cannot_tell" if decision == "refused" else decision,
               reason=(result["verdict"] or [""])[0][:200])
    changes = [value for line in result["distance"]["elements"] for value in line]
    row["largest_change"] = max((value for value in changes if value is not None), default=0.0)
    if truth:
        row["E_before"] = result["truth"]["E_initial"]
        row["E_after"] = result["truth"]["E_corrected"]
        row["inside"], row["intervals"] = coverage(result, json.loads(truth.read_text()))
    return row, result


def coverage(result, truth):
    """How many of the 95 % intervals of the written parameters hold the true value."""
    true = {(e["output"], e["input"]): e for e in truth["elements"]}
    inside = total = 0
    for element in result["elements"]:
        known = true.get((element["output"], element["input"]), {})
        for key in ("gain", "time_constant", "delay"):
            interval = element.get(key, {}).get("corrected")
            if "gain" not in known or not interval or interval["lower"] is None:
                continue
            total += 1
            inside += interval["lower"] <= known[key] <= interval["upper"]
    return inside, total


def run(arguments, kind, name, plant, seed):
    """A row: the figures of one run."""
    row = {"run": [kind, name, plant, seed], "kind": kind, "scenario": name, "plant": plant,
           "seed": seed}
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        if kind == "hardware":
            figures = hardware.run(arguments, correct, name, plant, scratch)
        elif kind == "mistakes":
            figures = run_mistake(arguments, name, plant, seed, scratch)
        else:
            figures = run_scenario(arguments, kind, name, plant, seed, scratch)
    row.update(figures)
    return row


def run_scenario(arguments, kind, name, plant, seed, scratch):
    # A loop that is unstable makes no record: the ageing or the effect is drawn again.
    for attempt in range(10):
        trial = scenarios.make(plant, kind, name, seed + 100000 * attempt, arguments.group)
        if simulate(arguments.apps, trial, seed, scratch):
            break
    else:
        return {"decision": "unstable"}
    if trial.spoil:
        mistakes.spoil(trial.spoil, trial, scratch / "model.json", scratch / "record.csv")
    if arguments.no_set_points:
        drop_set_points(scratch / "record.csv")
    if arguments.keep:
        keep(arguments.keep / arguments.set / name.replace(" ", "_") / kind / str(seed), scratch,
             trial)
    figures, result = correct(arguments, scratch, scratch / "model.json", scratch / "record.csv",
                              scratch / "truth.json", list(flags_of(trial.correct)))
    figures.update(curves.judged(trial, result))
    if arguments.group == "adversary":
        figures.update(adversary.judged(trial, result))
    return figures


def keep(folder, scratch, trial):
    """Model, plant, record and what is true of them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("model.json", "plant.json", "truth.json", "effects.json", "ageing.json",
                 "record.csv"):
        shutil.copy(scratch / name, folder / name)
    (folder / "trial.json").write_text(json.dumps({
        "plant": trial.plant.model, "codes": trial.codes, "where": trial.where,
        "aged": trial.aged, "steps": trial.steps, "time_constant": trial.time_constant}))


def run_mistake(arguments, name, plant, seed, scratch):
    trial = scenarios.make(plant, "none", "white noise", seed)
    if not simulate(arguments.apps, trial, seed, scratch):
        return {"decision": "unstable"}
    mistakes.make(name, trial, scratch / "model.json", scratch / "record.csv")
    figures, _ = correct(arguments, scratch, scratch / "model.json", scratch / "record.csv")
    return figures
