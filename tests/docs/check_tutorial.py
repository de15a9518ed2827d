"""check_tutorial.py SOURCE BUILD: docs/tutorial.md, typed in as it stands in a copy of the
project, with the commands of BUILD.

Every command succeeds, and the page shows what the commands print or write; the page may
wrap long lines. Numbers may differ by a tenth, because compilers round differently; words
may not.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])

TOLERANCE = 0.1
MAX_WRAPPED = 5  # lines of the page for one line of output
NUMBER = re.compile(r"[−-]?\d+(?:,\d{3})*(?:\.\d+)?(?:×10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")
PLAIN = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789", ",")


def value(number):
    mantissa, _, exponent = number.partition("×10")
    return float(mantissa.translate(PLAIN)) * 10.0 ** float(exponent.translate(PLAIN) or 0)


def parts(line):
    """The line's words, and its numbers; neither has the checksums of files."""
    line = re.sub(r"\b[0-9a-f]{12}…", "checksum", line)
    words = re.sub(r"\s+", " ", re.sub("─+", "─", NUMBER.sub("#", line))).strip()
    return words, [value(number) for number in NUMBER.findall(line)]


def found(expected, numbers, shown):
    return any(
        all(abs(a - b) <= TOLERANCE * max(abs(a), abs(b)) for a, b in zip(numbers, other))
        for other in shown.get(expected, [])
    )


def lines_of(block, shown):
    """The lines of a block; a line that the page wraps is joined again."""
    lines = list(filter(str.strip, block.splitlines()))
    begin = 0
    while begin < len(lines):
        end = begin + 1
        for last in range(begin + 1, min(begin + MAX_WRAPPED, len(lines)) + 1):
            if found(*parts(" ".join(lines[begin:last])), shown):
                end = last
                break
        yield " ".join(lines[begin:end])
        begin = end


def copy_project(folder):
    """What the tutorial needs of the project, the commands as they were built for the tests."""
    for name in ("scripts", "configs"):
        shutil.copytree(source / name, folder / name)
    (folder / "build/release").mkdir(parents=True)
    (folder / "build/release/apps").symlink_to(build / "apps")


def remember(text, shown):
    for line in text.splitlines():
        words, numbers = parts(line)
        shown.setdefault(words, []).append(numbers)


faults = []
shown = {}
checked = 0
page = (source / "docs/tutorial.md").read_text()
with tempfile.TemporaryDirectory() as scratch:
    folder = pathlib.Path(scratch)
    copy_project(folder)
    for kind, block in re.findall(r"^```(\w*)\n(.*?)^```", page, re.DOTALL | re.MULTILINE):
        if kind == "sh":
            typed = re.sub("^scripts/examples$", "scripts/examples build/release/apps", block,
                           flags=re.MULTILINE)
            done = subprocess.run(["bash", "-c", typed], cwd=folder,
                                  capture_output=True, text=True)
            if done.returncode != 0:
                faults.append(f"fails ({done.returncode}): {block}{done.stderr[-2000:]}")
            remember(done.stdout, shown)
            for export in folder.glob("examples/*_export.csv"):
                remember("\n".join(export.read_text().splitlines()[:10]), shown)
            continue
        for line in lines_of(block, shown):
            words, numbers = parts(line)
            checked += 1
            if not found(words, numbers, shown):
                there = shown.get(words, "nothing like it")
                faults.append(f"is not what is printed: {line.strip()}\n  numbers there: {there}")
            # The check can fail.
            wrong = [1.5 * number + 1 for number in numbers]
            if numbers and found(words, wrong, shown):
                faults.append(f"any number would do: {line.strip()}")

if checked < 50:
    faults.append(f"only {checked} lines of docs/tutorial.md were checked")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
