"""check_walkthroughs.py SOURCE BUILD LEAST PAGE…: pages such as docs/tutorial.md, typed in as
they stand in a copy of the project, each in a copy of its own, with the commands of BUILD.

Every command succeeds, and a page shows what the commands print or write; a page may wrap
long lines. Numbers may differ by a tenth, because compilers round differently; words may
not. At least LEAST lines of each page are compared. Programs in Python are run with the
package of BUILD, where there is one and the libraries that they import are installed.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
least = int(sys.argv[3])
pages = sys.argv[4:]

PYTHON = "/usr/bin/python3"  # which the package is built for
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


def environment(folder):
    """The commands on the path, and the Python package."""
    return {**os.environ,
            "PATH": f"{folder / 'build/release/apps'}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": str(build / "python")}


def run_shell(block, folder, shown):
    """Types the commands in; what they print, and the first lines of exports, are shown."""
    typed = re.sub("^scripts/examples$", "scripts/examples build/release/apps", block,
                   flags=re.MULTILINE)
    done = subprocess.run(["bash", "-ec", typed], cwd=folder, env=environment(folder),
                          capture_output=True, text=True)
    if done.returncode != 0:
        yield f"fails ({done.returncode}): {block}{done.stderr[-2000:]}"
    remember(done.stdout, shown)
    for export in [*folder.glob("examples/*_export.csv"), *folder.glob("examples/*_pi.csv")]:
        remember("\n".join(export.read_text().splitlines()[:10]), shown)


def run_python(block, folder):
    if not list((build / "python/mle").glob("_mle*.so")):
        print("There is no Python package to run programs with")
        return
    done = subprocess.run([PYTHON, "-c", block], cwd=folder, env=environment(folder),
                          capture_output=True, text=True)
    missing = re.search(r"No module named '(numpy|scipy)", done.stderr)
    if missing:
        print(f"{missing[1]} is not installed; not run:\n{block}")
    elif done.returncode != 0:
        yield f"fails ({done.returncode}): {block}{done.stderr[-2000:]}"


def compare(block, shown):
    """The faults of a block of output."""
    for line in lines_of(block, shown):
        words, numbers = parts(line)
        if not found(words, numbers, shown):
            there = shown.get(words, "nothing like it")
            yield f"is not what is printed: {line.strip()}\n  numbers there: {there}"
        # The check can fail.
        wrong = [1.5 * number + 1 for number in numbers]
        if numbers and found(words, wrong, shown):
            yield f"any number would do: {line.strip()}"


def check(page, folder):
    copy_project(folder)
    shown, compared = {}, 0
    blocks = re.findall(r"^```(\w*)\n(.*?)^```", (source / page).read_text(),
                        re.DOTALL | re.MULTILINE)
    for kind, block in blocks:
        if kind == "sh":
            yield from run_shell(block, folder, shown)
        elif kind == "python":
            yield from run_python(block, folder)
        elif kind == "":
            compared += len(list(lines_of(block, shown)))
            yield from compare(block, shown)
    if compared < least:
        yield f"only {compared} lines were compared"


faults = []
for page in pages:
    with tempfile.TemporaryDirectory() as scratch:
        faults += [f"{page}: {fault}" for fault in check(page, pathlib.Path(scratch))]
for fault in faults:
    print(fault)
sys.exit(1 if faults or not pages else 0)
