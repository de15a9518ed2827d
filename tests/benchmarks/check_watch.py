"""check_watch.py SOURCE BUILD: the smallest runs of the benchmarks of the watch."""

import pathlib
import re
import subprocess
import sys

source, build = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])


def run(script, *arguments):
    done = subprocess.run([sys.executable, source / "benchmarks" / script, build / "apps", *arguments],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def check_load():
    said = run("watch/serve_load", "1", "3")
    floods = re.findall(r"(\d+) honest requests, (\d+) failed", said)
    assert len(floods) == 4 and all(int(asked) > 0 for asked, _ in floods), said
    assert floods[0][1] == "0", said
    assert re.search(r"stalled reader: .* exit code 0\n", said), said
    assert re.search(r"without an end: .* exit code 1: error: --alarm_webhook: .* too long", said), said


def check_soak():
    assert "nothing went wrong" in run("soak", "0.1")


def check_fleet():
    if not list(pathlib.Path("/usr/lib/postgresql").glob("*/bin")):
        print("no PostgreSQL: fleet_day is left out")
        return
    assert "pages" in run("watch/fleet_day", "2", "16", "1")


for check in (check_load, check_soak, check_fleet):
    check()
