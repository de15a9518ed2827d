"""check_plant_size.py SOURCE BUILD: the plants that benchmarks/plant_size draws, and its smallest run."""

import csv
import importlib.machinery
import importlib.util
import pathlib
import random
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
sys.dont_write_bytecode = True
script = source / "benchmarks/plant_size/run"
loader = importlib.machinery.SourceFileLoader("plant_size", str(script))
spec = importlib.util.spec_from_loader("plant_size", loader)
plant_size = importlib.util.module_from_spec(spec)
sys.modules["plant_size"] = plant_size
loader.exec_module(plant_size)


def check_drawn_plants():
    size = plant_size.SIZES["12x12"]
    model = plant_size.draw_model(size, random.Random(3))
    pairs = {(element["output"], element["input"]) for element in model["elements"]}
    assert len(pairs) == len(model["elements"])
    assert all((f"y{i}", f"u{i}") in pairs for i in range(1, size.outputs + 1))
    off_diagonal = len(pairs) - size.outputs
    assert 0.3 < off_diagonal / (size.outputs * (size.inputs - 1)) < 0.7, off_diagonal
    plant, aged = plant_size.draw_aged(model, random.Random(4))
    assert len(aged) == len(pairs) // 8
    for before, after in zip(model["elements"], plant["elements"]):
        changed = (before["output"], before["input"]) in aged
        assert (before["gain"] != after["gain"]) == changed, (before, after)


def check_a_run():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, script, "--sizes=2x2", f"--apps={build}/apps",
                        f"--out={folder}"], check=True, stdout=subprocess.DEVNULL)
        with open(pathlib.Path(folder) / "size.csv", newline="") as file:
            rows = list(csv.DictReader(file))
    assert [row["size"] for row in rows] == ["2x2"], rows
    assert rows[0]["decision"] == "corrected", rows
    assert int(rows[0]["named"]) == int(rows[0]["aged"]) and rows[0]["named_wrongly"] == "0", rows
    assert float(rows[0]["E_after"]) < 0.2 * float(rows[0]["E_before"]), rows
    assert float(rows[0]["busy"]) > 0.0 and int(rows[0]["mebibytes"]) > 0, rows


def check_a_year():
    """Nine days of it, 30 tags."""
    year = script.with_name("year")
    if subprocess.run(["/usr/bin/python3", "-c", "import numpy"], stderr=subprocess.DEVNULL).returncode != 0:
        print("no NumPy: the year is left out")
        return
    done = subprocess.run([year, f"--apps={build}/apps", "--samples=12960", "--tags=30", "--keep=3000"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "days that move begin at" in done.stdout and "stretches" in done.stdout, done.stdout


check_drawn_plants()
check_a_run()
check_a_year()
