"""table.py FILE.csv: what watch_benchmark found, as the tables of docs/watch.md.

The threshold of the CUSUM that knows the change is, for each effect and kind of ageing, the
value that it exceeds in 5 % of the lives without ageing (four elements in each).
"""

import csv
import statistics
import sys

LOOKS = ("output_alarm", "element_alarm", "repeated_alarm")
FIELDS = ("effect", "ageing", "seed", "output", "input", "begin", *LOOKS, "right_output",
          "right_element", "used", "cannot_tell", "cusum")
AGEINGS = ("gain", "delay", "time_constant")
LEVEL = 0.05


def read(path):
    with open(path, newline="") as file:
        lives = [dict(zip(FIELDS, row)) for row in csv.reader(file) if len(row) == len(FIELDS)]
    for life in lives:
        for field in FIELDS[2:-1]:
            life[field] = int(life[field])
    return lives


def thresholds(quiet):
    """For each effect and ageing."""
    found = {}
    for life in quiet:
        heights = [float(value) for value in life["cusum"].split()]
        for number, ageing in enumerate(AGEINGS):
            found.setdefault((life["effect"], ageing), []).extend(
                heights[4 * number:4 * number + 4])
    return {key: sorted(values)[min(int((1 - LEVEL) * len(values)), len(values) - 1)]
            for key, values in found.items()}


def informed_day(life, threshold):
    for step in life["cusum"].split():
        day, height = step.split(":")
        if int(day) >= life["begin"] and float(height) > threshold:
            return int(day)
    return None


def median(values):
    return f"{statistics.median(values):.0f}" if values else "-"


def main():
    lives = read(sys.argv[1])
    quiet = [life for life in lives if life["ageing"] == "none"]
    limits = thresholds(quiet)
    print(f"{len(quiet)} lives without ageing: with a false alarm "
          f"{sum(max(life['output_alarm'], life['element_alarm']) >= 0 for life in quiet)}, "
          f"by repeated tests {sum(life['repeated_alarm'] >= 0 for life in quiet)}")
    print("| aged | lives | found | before it began | right element | median delay | informed | "
          "ratio |\n|---|---|---|---|---|---|---|---|")
    for ageing in AGEINGS:
        rows = [life for life in lives if life["ageing"] == ageing
                and (life["effect"], ageing) in limits]
        found = [life for life in rows if life["output_alarm"] >= life["begin"]]
        early = sum(0 <= life["output_alarm"] < life["begin"] for life in rows)
        right = sum(life["right_element"] for life in found)
        delays = [life["output_alarm"] - life["begin"] for life in found]
        informed = [day - life["begin"] for life in rows
                    if (day := informed_day(life, limits[life["effect"], ageing])) is not None]
        ratio = "-"
        if delays and informed and statistics.median(informed) > 0:
            ratio = f"{statistics.median(delays) / statistics.median(informed):.1f}"
        print(f"| {ageing} | {len(rows)} | {len(found)} | {early} | {right} | {median(delays)} | "
              f"{median(informed)} | {ratio} |")


if __name__ == "__main__":
    main()
