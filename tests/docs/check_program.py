"""check_program.py SOURCE BUILD: examples/correct_from_csv and mle_correct agree on the
tutorial's records: the same decision, reasons and warnings, and the same model to the last
digit (numbers are compared as they are written).
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])

# A model, its record of scripts/examples, the decision.
CASES = [("splitter", "splitter", "corrected"),
         ("dryer", "dryer", "corrected"),
         ("dryer", "dryer_new", "no_change")]
# As Packaging.Examples has built it.
PROGRAM = build / "tests/packaging/Examples/example_correct_from_csv"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def run(folder, *command):
    done = subprocess.run(list(map(str, command)), cwd=folder, capture_output=True, text=True)
    if done.returncode > 1:
        sys.exit(f"{command[0]} fails ({done.returncode}): {done.stderr[-2000:]}")
    return done.stdout


def words_of(result):
    """What the program prints, of the result.json of the command."""
    lines = [result["decision"]]
    lines += ["  " + reason["text"] for reason in result["reasons"]]
    lines += [f"  warning, {warning['place']}: {warning['text']}" for warning in result["warnings"]]
    return lines


faults = []
with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    for name in ("scripts", "configs"):
        shutil.copytree(source / name, folder / name)
    run(folder, "scripts/examples", build / "apps")
    for model, record, decision in CASES:
        paths = [f"configs/{model}.json", f"{record}.json", f"examples/{record}.csv"]
        printed = run(folder, PROGRAM, *paths).splitlines()
        run(folder, build / "apps/mle_correct", f"--model={paths[0]}", f"--data={paths[2]}",
            f"--out={record}")
        result = json.loads((folder / record / "result.json").read_text())
        if result["decision"] != decision:
            faults.append(f"{record}: the decision is {result['decision']}, not {decision}")
        if printed != words_of(result):
            faults.append(f"{record}: the program prints {printed}, the command says "
                          f"{words_of(result)}")
        if decision != "corrected":
            continue
        written, fopdt = (NUMBER.findall((folder / path).read_text())
                          for path in (paths[1], f"{record}/fopdt.json"))
        if written != fopdt or len(written) < 10:
            faults.append(f"{record}: the program writes {written}, the command {fopdt}")

for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
