"""check_schemas.py SOURCE BUILD: files of the project, and what its commands write, against
the JSON Schemas in docs/schemas.

Each schema is also tried on files that are wrong, so that one that takes anything fails.
"""

import copy
import datetime
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import jsonschema

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
faults = []


def validator(name):
    schema = json.loads((source / f"docs/schemas/{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def no_constant(text):
    raise ValueError(f"{text} is no JSON")


def read(path):
    return json.loads(path.read_text(), parse_constant=no_constant)


def check(name, path):
    """The file is valid; without any one of the required keys it is not."""
    schema = validator(name)
    content = read(path)
    for error in schema.iter_errors(content):
        place = "/".join(str(step) for step in error.absolute_path)
        faults.append(f"{path}: {place}: {error.message[:200]}")
    for key in schema.schema["required"]:
        broken = copy.deepcopy(content)
        del broken[key]
        if schema.is_valid(broken):
            faults.append(f"{name}: takes a file without '{key}'")
        broken[key] = {"no": ["such", "thing"]}
        if schema.is_valid(broken) and key != "flags":
            faults.append(f"{name}: takes any '{key}'")


def run(command, *arguments, accepted=(0,)):
    done = subprocess.run([build / "apps" / command, *arguments], capture_output=True, text=True)
    if done.returncode not in accepted:
        sys.exit(f"{command} failed ({done.returncode}): {done.stderr[-2000:]}")


def aged_records(folder):
    """30 days of the column and 20 of the aged one, by 5 min, in folder/aged."""
    (folder / "aged").mkdir()
    begin = datetime.datetime(2026, 1, 1)
    for plant, days in (("wood_berry", 30), ("wood_berry_gain", 20)):
        moves = [f"{output}:{1440 * day + at}:{size}" for day in range(days)
                 for output, at, size in (("overhead", 100, 0.5), ("overhead", 500, 0), ("bottoms", 900, 0.5),
                                          ("bottoms", 1200, 0))]
        run("mle_simulate", f"--model={source}/configs/wood_berry.json", f"--plant={source}/configs/{plant}.json",
            "--sample_time=5", "--control_period=5", f"--duration={1440 * days - 5}", f"--setpoints={','.join(moves)}",
            f"--out={folder}/part.csv")
        header, *rows = (folder / "part.csv").read_text().splitlines()
        dated = [f"{begin + datetime.timedelta(minutes=5 * k)},{row.split(',', 1)[1]}" for k, row in enumerate(rows)]
        (folder / f"aged/{plant}.csv").write_text("\n".join([header, *dated]) + "\n")
        begin += datetime.timedelta(days=days)


def version_of(command):
    """What --version says: the command and a version."""
    done = subprocess.run([build / "apps" / command, "--version"], capture_output=True, text=True)
    name, version = done.stdout.split()
    if done.returncode != 0 or name != command or version.count(".") != 2:
        faults.append(f"{command} --version: {done.returncode}, '{done.stdout}'")
    return version


def check_version(command, path):
    """A folder's results name the program that wrote them and its version."""
    content = read(path)
    found = (content.get("program"), content.get("program_version"))
    if found != (command, version_of(command)):
        faults.append(f"{path}: was written by {found}, not by {command} {version_of(command)}")


def check_commands(folder):
    model = f"--model={source}/configs/wood_berry.json"
    version_of("mle_simulate")  # its one file has the columns of a record and nothing else
    run("mle_simulate", model, f"--plant={source}/configs/wood_berry_gain.json",
        "--setpoints=overhead:150:1,bottoms:450:1", "--duration=700", "--sample_time=0.5",
        f"--out={folder}/run.csv")
    for estimator in ("output_error", "arx"):
        out = folder / estimator
        run("mle_correct", model, f"--data={folder}/run.csv", f"--out={out}", "--figures=false",
            "--conversion_samples=5000", f"--estimator={estimator}",
            f"--truth={source}/configs/wood_berry_gain.json",
            accepted=(0, 1))  # 1: a correction that was refused is a result too
        check("result", out / "result.json")
        check_version("mle_correct", out / "result.json")
        check("arx", out / "arx.json")
        if read(out / "result.json")["state_space"]["written"]:
            check("state_space", out / "state_space.json")
        elif estimator == "output_error":
            faults.append(f"{out}: no state_space.json")
        check("process_model", out / "fopdt.json")
        check("process_model", out / "model.json")
    rows = [line.split(",") for line in (folder / "run.csv").read_text().splitlines()]
    kept = [c for c, name in enumerate(rows[0]) if not name.endswith("_setpoint")]
    (folder / "no_set_points.csv").write_text("".join(",".join(row[c] for c in kept) + "\n" for row in rows))
    out = folder / "no_set_points"
    run("mle_correct", model, f"--data={folder}/no_set_points.csv", f"--out={out}", "--figures=false",
        "--estimator=output_error", accepted=(0, 1))
    check("result", out / "result.json")
    tank = source / "tests/fuzz/corpus/step_response_model/tank.json"
    run("mle_simulate", f"--model={tank}", f"--plant={tank}", "--setpoints=temperature:50:1",
        "--duration=250", "--noise_variance=1e-3", f"--out={folder}/tank.csv")
    out = folder / "step_responses"
    run("mle_correct", f"--model={tank}", f"--data={folder}/tank.csv", f"--out={out}",
        "--figures=false", accepted=(0, 1))
    check("result", out / "result.json")
    check("step_response_model", out / "model_corrected.json")
    heater = source / "configs/heater_z.json"
    run("mle_simulate", f"--model={heater}", f"--plant={heater}", "--setpoints=temperature:20:1",
        "--duration=120", "--noise_variance=1e-3", f"--out={folder}/heater.csv")
    for form, name in (("discrete_model", heater), ("state_space", folder / "states.json")):
        out = folder / form
        run("mle_correct", f"--model={name}", f"--data={folder}/heater.csv", f"--out={out}",
            "--figures=false", accepted=(0, 1))
        check("result", out / "result.json")
        check(form, out / "model_corrected.json")
        shutil.copy(out / "state_space.json", folder / "states.json")
    out = folder / "reproduction"
    run("mle_reproduce", f"--out={out}", "--cases=gain", "--figures=false", "--sample_time=0.5",
        "--order=30", "--conversion_duration=2000", "--duration=400", "--step_time=200",
        "--window=150", "--response_horizon=60", "--lambda_grid_step=1e-4")
    check("results", out / "results.json")
    check_version("mle_reproduce", out / "results.json")
    campaign = {
        "version": 1, "name": "small", "seeds": [1, 2], "sample_time": 0.5, "order": 30,
        "models": [{"name": "column", "file": f"{source}/configs/wood_berry.json"}],
        "mismatches": [{"name": "gain", "plant": f"{source}/configs/wood_berry_gain.json"}],
        "windows": [{"name": "two", "window": 150, "duration": 400, "step_time": 200}],
        "effects": [{"name": "none"}, {"name": "ours", "file": f"{source}/configs/effects_compression.json"}],
        "response_horizon": 60, "conversion": {"duration": 2000},
        "lambda_grid": {"max": 1e-2, "step": 1e-4}}
    (folder / "small.json").write_text(json.dumps(campaign))
    check("campaign", folder / "small.json")
    out = folder / "study"
    run("mle_study", f"--campaign={folder}/small.json", f"--out={out}", "--figures=false")
    check("campaign", out / "campaign.json")
    check("summary", out / "summary.json")
    check_version("mle_study", out / "summary.json")
    out = folder / "lifecycle"
    run("mle_lifecycle", model, f"--ageing={source}/configs/wood_berry_ageing.json", f"--out={out}",
        "--figures=false", "--years=0.2", "--change_every=20d", "--sample_time=1", "--seeds=1",
        "--policies=never,output_error:2,test:1,perfect")
    check("lifecycle", out / "result.json")
    check_version("mle_lifecycle", out / "result.json")
    aged_records(folder)
    controllers = {"version": 1, "controllers": [
        {"name": "none", "model": f"{source}/configs/wood_berry.json", "records": "nowhere"},
        {"name": "column", "model": f"{source}/configs/wood_berry.json", "records": "aged",
         "prices": {"price_squared_error": [100, 50], "price_engineer_hour": 90, "currency": "EUR"},
         "tuning": {"control_period": 5, "prediction_horizon": 30, "control_horizon": 5,
                    "output_weight": 0.2, "move_weight": 0.1}}]}
    (folder / "controllers.json").write_text(json.dumps(controllers))
    check("controllers", folder / "controllers.json")
    run("mle_watch", f"--controllers={folder}/controllers.json", f"--out={folder}/watch", "--propose=false",
        accepted=(1,))  # of "none" there are no records
    check("watch", folder / "watch/watch.json")
    told = read(folder / "watch/watch.json")["controllers"][1]["ageing_cost"]["told"]
    if told != "told":
        faults.append(f"watch.json: costs of a column that has aged: '{told}'")
    check_version("mle_watch", folder / "watch/watch.json")
    journal = out / "journal.txt"
    if not journal.is_file() or version_of("mle_lifecycle") not in journal.read_text():
        faults.append(f"{journal}: no lives of this version were kept")


for path in sorted((source / "configs").glob("*.json")):
    if "elements" in read(path) and "inputs" in read(path) and "sample_time" not in read(path):
        check("process_model", path)
for path in sorted((source / "configs").glob("campaign_*.json")):
    check("campaign", path)
for path in sorted((source / "configs").glob("*_ageing.json")):
    check("ageing", path)
check("ageing", source / "tests/fuzz/corpus/ageing/steps.json")
for path in sorted((source / "configs").glob("effects_*.json")):
    check("effects", path)
check("controllers", source / "configs/controllers.json")
check("arx", source / "tests/fuzz/corpus/arx_model/small.json")
check("process_model", source / "tests/fuzz/corpus/process_model/sampled.json")
check("discrete_model", source / "configs/heater_z.json")
check("step_response_model", source / "tests/fuzz/corpus/step_response_model/tank.json")
with tempfile.TemporaryDirectory() as folder:
    check_commands(pathlib.Path(folder))
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
