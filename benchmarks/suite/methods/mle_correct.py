"""mle_correct.py FOLDER [FLAG…]: this project's command, with its defaults or an estimator.

Its columns of modes are given as --mode_tag; nothing else is told.
"""

import csv
import json
import os
import pathlib
import subprocess
import sys

PARAMETERS = ("gain", "time_constant", "delay")


def answer(result):
    decision = {"refused": "cannot_tell"}.get(result["decision"], result["decision"])
    yield [decision]
    for element in result["elements"]:
        pair = element["output"], element["input"]
        if decision == "corrected" and element.get("aged"):
            yield ["aged", *pair]
        for key in PARAMETERS:
            found = element.get(key, {}).get("corrected")
            if found and found["lower"] is not None:
                yield ["interval", *pair, key, found["lower"], found["upper"]]
    for told in result.get("explanations", []):
        where = [value for key, value in told.items()
                 if isinstance(value, str) and key not in ("explanation", "text")]
        yield ["reason", told["explanation"],
               *(part for value in where for part in {value: 0, **dict.fromkeys(value.split("/"))})]
    for told in result.get("reasons", []):
        if told["code"] == "mistake":
            yield ["reason", "mistake", *told["text"].split()]


def main(*arguments):
    *flags, name = arguments  # the folder comes last
    folder = pathlib.Path(name)
    out = folder / "out"
    with (folder / "record.csv").open(newline="") as file:
        header = next(csv.reader(file))
    tags = [f"{tag}={tag.removesuffix('_mode')}" for tag in header if tag.endswith("_mode")]
    modes = [f"--mode_tag={','.join(tags)}"] if tags else []
    done = subprocess.run([pathlib.Path(os.environ["MLE_APPS"], "mle_correct"),
                           f"--model={folder}/model.json", f"--data={folder}/record.csv",
                           f"--out={out}", "--figures=false", "--threads=1", *modes, *flags])
    if not (out / "result.json").exists():
        sys.exit(done.returncode or 1)
    result = json.loads((out / "result.json").read_text())
    with (folder / "decision.txt").open("w", newline="") as file:
        csv.writer(file).writerows(answer(result))
    corrected = out / "model.json"
    if result["decision"] == "corrected" and corrected.exists():
        corrected.replace(folder / "model.json")


if __name__ == "__main__":
    main(*sys.argv[1:])
