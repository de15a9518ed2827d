"""The tables of the benchmark, as markdown."""

import statistics

HARM = 0.02  # of a step response's norm, where nothing has aged
GAIN = 5.0  # how far E is to fall where something has


def share(part, whole):
    return f"{100.0 * part / whole:.3g} %" if whole else "–"


def number(value):
    return f"{value:.3g}"


def decisions(rows):
    return {name: sum(row["decision"] == name for row in rows)
            for name in ("no_change", "corrected", "cannot_tell", "no_answer", "unstable")}


def is_harmful(row):
    if row["decision"] != "corrected":
        return False
    if row["kind"] == "none" and row["E_before"] == 0.0:
        return row["largest_change"] > HARM
    return row["E_after"] > row["E_before"]


def scenario_cells(kind, rows):
    counts = decisions(rows)
    judged = [row for row in rows if row.get("E_after") is not None]
    corrected = [row for row in judged if row["decision"] == "corrected"]
    before = statistics.median(row["E_before"] for row in judged) if judged else 0.0
    # Without a corrected model the controller keeps its own.
    after = [row["E_after"] if row["decision"] == "corrected" else row["E_before"]
             for row in judged]
    cells = [str(counts["no_change"]), str(counts["corrected"]),
             str(counts["cannot_tell"] + counts["no_answer"]),
             f"{number(before)} → {number(statistics.median(after))} ({number(max(after))})"
             if judged else "–",
             share(sum(row["inside"] for row in corrected),
                   sum(row["intervals"] for row in corrected)),
             str(sum(map(is_harmful, rows)))]
    if kind == "aged":
        cells.append(str(sum(GAIN * left <= row["E_before"]
                             for left, row in zip(after, judged))))
    return cells


def scenario_table(kind, rows):
    fell = [f"E down {GAIN:.0f}-fold"] if kind == "aged" else []
    header = ["scenario", "runs", "no change", "corrected", "cannot tell",
              "E before → after, median (largest)", "coverage", "harm", *fell]
    lines = ["| " + " | ".join(header) + " |", "|---" + "|--:" * (len(header) - 1) + "|"]
    names = list(dict.fromkeys(row["scenario"] for row in rows))
    for name in names:
        of_name = [row for row in rows if row["scenario"] == name]
        lines.append("| " + " | ".join([name, str(len(of_name)),
                                        *scenario_cells(kind, of_name)]) + " |")
    lines.append("| " + " | ".join(["**all**", str(len(rows)),
                                    *scenario_cells(kind, rows)]) + " |")
    return lines


def mistake_table(rows):
    lines = ["| mistake | runs | no change | corrected | cannot tell | no answer |",
             "|---|--:|--:|--:|--:|--:|"]
    for name in dict.fromkeys(row["scenario"] for row in rows):
        counts = decisions([row for row in rows if row["scenario"] == name])
        lines.append(f"| {name} | {sum(counts.values())} | {counts['no_change']} | "
                     f"{counts['corrected']} | {counts['cannot_tell']} | "
                     f"{counts['no_answer']} |")
    return lines


def hardware_table(rows):
    lines = ["| model | record | decision | simulated fit on unseen records, before → after | "
             "worst fall |", "|---|---|---|---|--:|"]
    for row in rows:
        fits = "; ".join(f"{output} of {other} {before} → {after}"
                         for other, output, before, after in row.get("fits", []))
        fall = number(row["worst_fall"]) if "worst_fall" in row else "–"
        lines.append(f"| {row['scenario']} | {row['plant']} | {row['decision']} | "
                     f"{fits or '–'} | {fall} |")
    return lines


TITLES = {
    "none": "Nothing aged",
    "aged": "Something aged",
    "mistakes": "Operators' mistakes",
    "hardware": "Hardware",
}


def markdown(arguments, rows):
    seconds = [row["seconds"] for row in rows if "seconds" in row]
    parts = [f"Set `{arguments.set}`, {arguments.seeds} seeds; a decision takes, of one core, "
             f"{statistics.median(seconds):.2g} s (median), {max(seconds):.2g} s at most.\n"]
    for kind, title in TITLES.items():
        of_kind = [row for row in rows if row["kind"] == kind]
        if not of_kind:
            continue
        if kind == "mistakes":
            lines = mistake_table(of_kind)
        elif kind == "hardware":
            lines = hardware_table(of_kind)
        else:
            lines = scenario_table(kind, of_kind)
        parts.append(f"## {title}\n\n" + "\n".join(lines) + "\n")
    return "\n".join(parts)
