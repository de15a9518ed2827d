"""The track watch: lives of the Wood-Berry column, by benchmarks/watch.

A life is 420 days of set points, noise and one of twelve effects, with nothing aged or one element.
The watch of this project, the same tests repeated every day at 5 %, and a CUSUM that knows what
ages (its threshold is exceeded in 5 % of the lives without ageing) see the same scores.
"""

import statistics
import subprocess
import sys

import cases

sys.path.append(str(cases.ROOT / "benchmarks/watch"))
import table  # noqa: E402

EFFECTS = {"smoke": "white", "short": "white,drift,load,steps", "full": ""}


def program(arguments):
    if arguments.watch:
        return arguments.watch
    subprocess.run(["bash", "-c", '. "$0" && build_benchmarks watch_benchmark',
                    cases.ROOT / "benchmarks/scripts/common.sh"], check=True)
    return cases.ROOT / "build/benchmarks/benchmarks/watch_benchmark"


def rows(arguments):
    """A row for each method; none of a part that is not the first."""
    if arguments.part[0] != 1:
        return []
    first = cases.number_of(arguments.seed, "watch") % 1000000
    file = arguments.out / f"lives.{arguments.form}.{first}.csv"
    if not arguments.collect:
        subprocess.run([program(arguments), file, cases.ROOT / "configs/wood_berry.json",
                        str(arguments.repeats), str(first), "", "", EFFECTS[arguments.form]],
                       check=True)
    if not file.exists():
        return []
    lives = sorted(table.read(file), key=lambda life: (life["effect"], life["ageing"],
                                                       life["seed"]))
    quiet = [life for life in lives if life["ageing"] == "none"]
    aged = [life for life in lives if life["ageing"] != "none"]
    limits = table.thresholds(quiet)

    def alarm(life, column):
        return life[column] if life[column] >= 0 else None

    return [row_of("mle_watch", quiet, aged, lambda life: alarm(life, "output_alarm"), True),
            row_of("repeated tests", quiet, aged, lambda life: alarm(life, "repeated_alarm")),
            row_of("CUSUM that knows the change", [], aged, lambda life: table.informed_day(
                life, limits[life["effect"], life["ageing"]]))]


def row_of(method, quiet, aged, day_of, names=False):
    days = [(life, day_of(life)) for life in aged]
    found = [(life, day) for life, day in days if day is not None and day >= life["begin"]]
    return {"method": method, "quiet": len(quiet),
            "false": sum(day_of(life) is not None for life in quiet) if quiet else None,
            "aged": len(aged), "found": len(found),
            "early": sum(day is not None and day < life["begin"] for life, day in days),
            "right": sum(life["right_element"] for life, _ in found) if names else None,
            "delay": statistics.median(day - life["begin"] for life, day in found)
            if found else None}
