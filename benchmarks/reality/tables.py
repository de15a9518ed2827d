"""The tables of the benchmark, as markdown."""

import statistics

import adversary
import effects

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
    # A curve of what is straight makes responses wrong elsewhere than E tells.
    if row.get("curves_false"):
        return True
    if row["kind"] == "none" and row["E_before"] == 0.0:
        return row["largest_change"] > HARM
    return row["E_after"] > row["E_before"]


def effect(kind, before, after):
    """E before and after; where nothing has aged the largest after, as the others are zero."""
    if kind == "none" and before == 0.0 and statistics.median(after) == 0.0:
        return number(max(after))
    return f"{number(before)} → {number(statistics.median(after))} ({number(max(after))})"


def scenario_cells(kind, rows):
    counts = decisions(rows)
    judged = [row for row in rows if row.get("E_after") is not None]
    corrected = [row for row in judged if row["decision"] == "corrected"]
    before = statistics.median(row["E_before"] for row in judged) if judged else 0.0
    after = [left(row) for row in judged]
    cells = [str(counts["no_change"]), str(counts["corrected"]),
             str(counts["cannot_tell"] + counts["no_answer"]),
             effect(kind, before, after) if judged else "–",
             share(sum(row["inside"] for row in corrected),
                   sum(row["intervals"] for row in corrected)).removesuffix(" %"),
             str(sum(map(is_harmful, rows)))]
    if kind == "aged":
        cells.append(str(sum(GAIN * left(row) <= row["E_before"] for row in judged)))
    return cells


def scenario_table(kind, rows):
    """A row for each scenario, after those in one sentence of which all runs are no change."""
    fell = [f"E down {GAIN:.0f}-fold"] if kind == "aged" else []
    header = ["scenario", "no change", "corrected", "cannot tell",
              "largest E" if kind == "none" else "E before → after (largest)",
              "coverage, %", "harm", *fell]
    names = list(dict.fromkeys(row["scenario"] for row in rows))
    of = {name: [row for row in rows if row["scenario"] == name] for name in names}
    quiet = [name for name in names if kind == "none"
             and all(row["decision"] == "no_change" for row in of[name])]
    counts = sorted({len(of[name]) for name in names})
    runs = f"{counts[0]} to {counts[-1]}" if counts[1:] else f"{counts[0]}"
    lines = [f"{runs} runs of each scenario; medians of E, and the largest.", ""]
    if quiet:
        lines += [f"No change in all runs: {'; '.join(quiet)}. The others:", ""]
    lines += ["| " + " | ".join(header) + " |", "|---" + "|--:" * (len(header) - 1) + "|"]
    for name in names:
        if name not in quiet:
            lines.append("| " + " | ".join([name, *scenario_cells(kind, of[name])]) + " |")
    lines.append("| " + " | ".join(["**all**", *scenario_cells(kind, rows)]) + " |")
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
    return lines + ahead_table(rows)


def ahead_table(rows):
    """Errors of predictions, of models that are corrected from their own record."""
    errors = {}
    for row in rows:
        if row["scenario"] != row["plant"]:
            continue
        for _, output, horizon, before, after in row.get("ahead", []):
            errors.setdefault((output, horizon), []).append((before, after))
    if not errors:
        return []
    lines = ["", "Root mean square errors of predictions of unseen records, from the least to the "
             "largest over pairs of record and model:", "",
             "| output | samples ahead | before | after |", "|---|--:|--:|--:|"]
    for (output, horizon), pairs in sorted(errors.items()):
        before, after = (f"{min(values):.3g}–{max(values):.3g}" for values in zip(*pairs))
        lines.append(f"| {output} | {horizon} | {before} | {after} |")
    return lines


def left(row):
    """E of what the controller has in the end: without a corrected model its own."""
    return row["E_after"] if row["decision"] == "corrected" else row["E_before"]


def worst_row(rows, count):
    """The scenario with the largest share of runs that count, and that share."""
    shares = {}
    for name in dict.fromkeys(row["scenario"] for row in rows):
        of_name = [row for row in rows if row["scenario"] == name]
        shares[name] = sum(map(count, of_name)) / len(of_name)
    name = max(shares, key=shares.get)
    return f"{100.0 * shares[name]:.3g} % ({name})"


def goals(rows):
    """What is asked for, in one table."""
    lines = ["| | found | asked for |", "|---|--:|--:|"]
    none = [row for row in rows if row["kind"] == "none"]
    aged = [row for row in rows if row["kind"] == "aged"]
    if none:
        harm = share(sum(map(is_harmful, none)), len(none))
        quiet = share(sum(row["decision"] == "no_change" for row in none), len(none))
        lines += [f"| nothing aged: responses changed by more than 2 % | {harm} | ≤ 1 % |",
                  f"| the same, worst row | {worst_row(none, is_harmful)} | ≤ 4 % |",
                  f"| nothing aged: no change | {quiet} | ≥ 60 % |"]
    if aged:
        judged = [row for row in aged if row.get("E_before")]
        down = [row for row in judged if GAIN * left(row) <= row["E_before"]]
        clean = [row for row in judged if row["scenario"] in effects.CLEAN]
        fell = sum(row["scenario"] in effects.CLEAN for row in down)
        lines += [f"| aged: E larger than before | {share(sum(map(is_harmful, aged)), len(aged))} "
                  "| ≤ 0.3 % |",
                  f"| aged: E down {GAIN:.0f}-fold | {share(len(down), len(aged))} | ≥ 70 % |",
                  f"| the same, noise, drift, quantisation, losses, outliers | "
                  f"{share(fell, len(clean))} | ≥ 95 % |"]
    corrected = [row for row in rows if row["decision"] == "corrected" and "inside" in row]
    if corrected:
        covered = share(sum(row["inside"] for row in corrected),
                        sum(row["intervals"] for row in corrected))
        lines.append(f"| coverage of 95 % intervals | {covered} | 92–98 % |")
    return lines


def reasons_judged(rows):
    """Of the answers that need a reason beside ageing, whether it is true."""
    return [row["reason_true"] for row in rows
            if row.get("reason_true") is not None and adversary.gives_reasons(row)]


def adversary_goals(rows):
    """What is asked for of the adversary's scenarios."""
    none = [row for row in rows if row["kind"] == "none"]
    aged = [row for row in rows if row["kind"] == "aged"]
    linear = [row for row in aged if adversary.FAMILIES[row["scenario"]].linear]
    wrong = {kind: sum(map(is_harmful, of_kind)) for kind, of_kind in
             (("none", none), ("aged", aged))}
    named = [row.get("named") for row in aged]
    answers = reasons_judged(rows)

    def line(what, part, whole, goal):
        return f"| {what} | {part} of {whole} | {share(part, whole)} | {goal} |"

    def down(of_kind):
        return sum(GAIN * left(row) <= row["E_before"] for row in of_kind if row.get("E_before"))
    return ["| | runs | found | asked for |", "|---|--:|--:|--:|",
            line("nothing aged: responses changed by more than 2 %, or further from the truth",
                 wrong["none"], len(none), "≤ 2 %"),
            line("aged: E larger than before", wrong["aged"], len(aged), "≤ 2 %"),
            line(f"aged: E down {GAIN:.0f}-fold", down(aged), len(aged), "–"),
            line("the same, linear families", down(linear), len(linear), "≥ 85 %"),
            *(line(f"aged: the aged element {how}", named.count(how), len(aged), goal)
              for how, goal in (("named exactly", "≥ 75 %"), ("named with others", "–"),
                                ("not named, another is", "–"), ("missed", "–"))),
            line("reason true, where something else than ageing is told or nothing can be",
                 sum(answers), len(answers), "≥ 85 %")]


def curve_table(rows):
    """How near curves that were put into models are to the truth."""
    judged = [row for row in rows if row.get("curve_points")]
    false = sum(row.get("curves_false") or 0 for row in rows)
    if not judged and not false:
        return []
    lines = ["| curves put into models | | asked for |", "|---|--:|--:|"]
    if judged:
        near = share(sum(row["curve_error"] <= 0.05 for row in judged), len(judged))
        inside = share(sum(row["curve_inside"] for row in judged),
                       sum(row["curve_points"] for row in judged))
        lines += [f"| records with true curves that are told | {len(judged)} | – |",
                  f"| … all within 5 % of the truth over what was visited | {near} | ≥ 80 % |",
                  f"| gains within their 95 % bands | {inside} | 92–98 % |"]
    lines.append(f"| curves of channels that are straight, of {len(rows)} records | {false} | – |")
    return lines


def told(rows):
    """What was told of scenarios, most often first."""
    codes = [one["explanation"] for row in rows for one in row.get("told") or []]
    return ", ".join(f"{code} {codes.count(code)}"
                     for code in sorted(set(codes), key=codes.count, reverse=True)) or "–"


def adversary_table(rows):
    lines = ["| scenario | kind | runs | no change | corrected | cannot tell | harm | E down | "
             "named exactly | reason true | told |", "|---|---|" + "--:|" * 8 + "---|"]
    for name in dict.fromkeys(row["scenario"] for row in rows):
        for kind in ("none", "aged"):
            of_name = [row for row in rows if (row["scenario"], row["kind"]) == (name, kind)]
            if not of_name:
                continue
            counts = decisions(of_name)
            down = sum(GAIN * left(row) <= row["E_before"] for row in of_name
                       if row.get("E_before"))
            exactly = sum(row.get("named") == "named exactly" for row in of_name)
            answers = reasons_judged(of_name)
            cells = [name, kind, len(of_name), counts["no_change"], counts["corrected"],
                     counts["cannot_tell"] + counts["no_answer"], sum(map(is_harmful, of_name)),
                     down if kind == "aged" else "–", exactly if kind == "aged" else "–",
                     f"{sum(answers)} of {len(answers)}" if answers else "–", told(of_name)]
            lines.append("| " + " | ".join(map(str, cells)) + " |")
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
    if arguments.group == "adversary":
        parts += ["\n".join(adversary_goals(rows)) + "\n",
                  "\n".join(curve_table(rows)) + "\n",
                  "\n".join(adversary_table(rows)) + "\n"]
        return "\n".join(parts)
    if any(row["kind"] in ("none", "aged") for row in rows):
        parts.append("\n".join(goals(rows)) + "\n")
        parts.append("\n".join(curve_table(rows)) + "\n")
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
