"""Tables of the runs, as Markdown, and the summary that goals are set by."""

import math
import statistics

WORSE = 1.05  # ratio of errors that counts as harm
DOWN = 0.99  # ratio of errors that counts as a fall
POINT = 1.0  # of fit, in per cent
NAMED = 0.05  # logarithm of a factor, or part of the time constant, that counts as a change


def ratio(row, output, which="corrected"):
    """Error of what the controller has in the end over that of the model given: the geometric
    mean over the horizons, on records held out."""
    before, after = (row[model]["outputs"][output]["ahead"] for model in ("given", which))
    logs = [math.log(new / old) for old, new in zip(before, after) if old and new]
    return math.exp(statistics.mean(logs)) if logs else 1.0


def ratios(row):
    return {output: ratio(row, output) for output in row["given"]["outputs"]}


def aged_output(row):
    return row["aged"][0].partition("/")[0]


def mean_ratio(rows, which="corrected"):
    """Of the aged outputs."""
    ratios_of = [math.log(ratio(row, aged_output(row), which)) for row in rows]
    return f"{math.exp(statistics.mean(ratios_of)):.2f}" if rows else "–"


def is_down(row):
    return ratio(row, aged_output(row)) < DOWN


def is_worse(row):
    return max(ratios(row).values()) > WORSE


def named(row):
    """What was changed by enough to count; another shape or path always does."""
    return [change for change in row["changed"] if change[3] is None or change[3] > NAMED]


def is_exact(row):
    """Whether what was aged, and nothing else, was changed."""
    return [change[:2] for change in named(row)] == [list(row["aged"][:2])]


def mean_fit(row, which, output):
    return statistics.mean(row[which]["outputs"][output]["fits"].values())


def is_back(row):
    """Whether the aged output fits unseen records as before it was aged."""
    output = aged_output(row)
    return mean_fit(row, "corrected", output) >= mean_fit(row, "honest", output) - POINT


def worst_fall(row):
    """Of the fit of any output on any unseen record."""
    return max(before - row["corrected"]["outputs"][output]["fits"][record]
               for output, errors in row["given"]["outputs"].items()
               for record, before in errors["fits"].items())


def distance(row, which):
    return sum(row[which]["distances"].values())


def is_known(row):
    """Whether what is known to have aged was changed alone, and by the right factor."""
    known = row["known"]
    if len(named(row)) != 1:
        return False
    ((pair, parameter, by, _),) = named(row)
    return pair.partition("/")[2] == known["input"] and parameter == known["parameter"] and \
        known["from"] <= by <= known["to"]


def of(part, whole):
    return f"{part} of {whole}" if whole else "–"


def count(rows, condition):
    return of(sum(bool(condition(row)) for row in rows), len(rows))


def spread(values, digits=".2f"):
    values = list(values)
    return f"{min(values):{digits}}–{max(values):{digits}}" if values else "–"


class Rows:
    """Runs in the kinds that tables tell apart."""

    def __init__(self, rows):
        # Where every record has a model of its own there are runs across records.
        laboratories = {row["plant"] for row in rows if row["again"] or not row["own"]}
        seen = [row for row in rows if "outputs" in row["given"]]
        self.truth = [row for row in rows if "distances" in row["given"]]
        self.laboratory = [row for row in seen if row["plant"] in laboratories]
        self.plants = [row for row in seen if row["plant"] not in laboratories]


def horizon_lines(kind, found, goals):
    aged = [row for row in found if row["aged"]]
    return [
        (f"{kind}, aged on purpose: error of the aged output over three horizons down",
         count(aged, is_down), goals[0]),
        (f"{kind}, aged on purpose: that error, corrected / not aged, over aged",
         f"{mean_ratio(aged)} / {mean_ratio(aged, 'honest')}", ""),
        (f"{kind}: any output worse by more than 5 %, unaged runs included",
         count(found, is_worse), goals[1]),
        (f"{kind}, aged on purpose: the aged parameter named, and no other",
         count(aged, is_exact), goals[2]),
        (f"{kind}, nothing aged: a model is changed",
         count([row for row in found if not row["aged"]], lambda row: row["changed"]), "")]


def laboratory_lines(rows):
    def own(some):
        return [row for row in some if row["own"] and not row["fitted"] and not row["again"]]

    def fitted(some):
        return [row for row in some if row["aged"] or row["fitted"]]

    found = fitted(rows)
    aged = [row for row in found if row["aged"]]
    lines = horizon_lines("laboratory", found, ("", "", "≥ 20 of 21"))
    lines.append(("laboratory, aged on purpose: fit of the aged output on unseen records back "
                  "within a point", count(aged, is_back), "≥ 19 of 21"))
    fits = {which: spread([mean_fit(row, which, aged_output(row)) for row in aged], ".1f")
            for which in ("honest", "given", "corrected")}
    lines.append(("laboratory, that fit: not aged / aged / corrected, %",
                  " / ".join(fits.values()), ""))
    found = own(rows)
    for output in sorted(found[0]["given"]["outputs"]) if found else ():
        def fixed(some, which, output=output):
            return spread(row[which]["outputs"][output].get("fixed") or math.nan
                          for row in some if not row["aged"])
        lines.append((f"laboratory, own record → others, fixed horizon, {output}: given / "
                      "corrected", f"{fixed(found, 'given')} / {fixed(found, 'corrected')}",
                      "≤ 0.38 (T1), ≤ 0.36 (T2)"))
    cross = [row for row in rows if not row["aged"] and not row["again"] and not row["fitted"]]
    again = [row for row in rows if row["again"] and row["decision"] != "not_given"]
    for name, some in (("cross runs", cross), ("a corrected model given", again)):
        most = f"; largest {max(map(worst_fall, some)):.2f}" if some else ""
        lines.append((f"laboratory, {name}: a fit on an unseen record falls by more than a point",
                      count(some, lambda row: worst_fall(row) > POINT) + most, "0"))
    return lines


def truth_lines(rows):
    def part(some, condition):
        return [row for row in some if condition(row)]

    def unaged(row):
        return not row["aged"] and not row["known"]

    def distances(some, which):
        return spread((distance(row, which) for row in some), ".3f")

    lines = []
    for name, condition, goal in (
            ("nothing aged", unaged, "≤ 0.04"),
            ("known ageing", lambda row: bool(row["known"]), "≤ 0.06"),
            ("aged on purpose", lambda row: bool(row["aged"]), "")):
        some = part(rows, condition)
        if not some:
            continue
        lines.append((f"true responses, {name}: relative E, given / corrected",
                      f"{distances(some, 'given')} / {distances(some, 'corrected')}",
                      goal))
        if name == "known ageing":
            lines.append((f"true responses, {name}: named alone, by the right factor",
                          count(some, is_known), "all"))
        elif name == "nothing aged":
            lines.append((f"true responses, {name}: a model is changed",
                          count(some, lambda row: row["changed"]), "0"))
        else:
            lines.append((f"true responses, {name}: E down",
                          count(some, has_fallen), ""))
            lines.append((f"true responses, {name}: the aged parameter named, and no other",
                          count(some, is_exact), ""))
    return lines


def has_fallen(row):
    return distance(row, "corrected") < DOWN * distance(row, "given")


def summary(rows):
    found = Rows(rows)
    lines = []
    if found.plants:
        lines += horizon_lines("plants", found.plants, ("≥ 26 of 42", "≤ 2 of 51", ""))
    if found.laboratory:
        lines += laboratory_lines(found.laboratory)
    if found.truth:
        lines += truth_lines(found.truth)
    return [{"row": row, "found": one, "asked_for": goal} for row, one, goal in lines]


def table(header, lines):
    return ["| " + " | ".join(header) + " |", "|---" + "|--:" * (len(header) - 1) + "|",
            *("| " + " | ".join(line) + " |" for line in lines)]


def decisions(rows):
    names = ("no_change", "corrected", "cannot_tell", "no_answer", "crashed")
    return " / ".join(str(sum(row["decision"] == name for row in rows)) for name in names)


def plant_table(rows):
    lines = []
    for plant, fitted in dict.fromkeys((row["plant"], bool(row["fitted"])) for row in rows):
        some = [row for row in rows if not row["again"] and row["own"]
                and (row["plant"], bool(row["fitted"])) == (plant, fitted)]
        aged = [row for row in some if row["aged"]]
        down, worse = (has_fallen, lambda row: distance(row, "corrected") >
                       WORSE * distance(row, "given")) \
            if "distances" in some[0]["given"] else (is_down, is_worse)
        lines.append([plant, "fitted" if fitted else "as given", str(len(some)), decisions(some),
                      count(aged, down), count(some, worse), count(aged, is_exact)])
    return table(["plant", "model", "runs",
                  "no change / corrected / cannot tell / no answer / crashed",
                  "aged: down", "worse", "named exactly"], lines)


def age_in_words(age):
    if not age:
        return "–"
    pair, parameter, by = age
    name = {"gain": "K ×", "time_constant": "T ×", "delay": "L +"}[parameter]
    return f"{pair} {name} {by:.3g}"


def changes_in_words(row):
    words = []
    for pair, parameter, by, _ in named(row):
        name = {"gain": "K ×", "time_constant": "T ×", "delay": "L"}.get(parameter, parameter)
        size = f" {by:+.3g}" if parameter == "delay" else f" {by:.3g}" if by is not None else ""
        words.append(f"{pair} {name}{size}")
    return "; ".join(words) or "–"


def errors_in_words(row, which):
    judged = row[which]
    if "distances" in judged:
        return f"{distance(row, which):.3f}"
    return "; ".join(" ".join(f"{error:.3g}" for error in errors["ahead"] if error is not None)
                     for errors in judged["outputs"].values())


def run_table(rows):
    lines = []
    for row in rows:
        record = f"{row['record']}, then {row['again']}" if row["again"] else row["record"]
        model = f"{row['model']}, fitted" if row["fitted"] else row["model"]
        lines.append([row["plant"], model, record, age_in_words(row["aged"]),
                      row["decision"].replace("_", " "), changes_in_words(row),
                      errors_in_words(row, "given"), errors_in_words(row, "corrected")])
    return table(["plant", "model", "record", "aged", "decision", "changed", "error given",
                  "corrected"], lines)


def markdown(rows, lines, left_out):
    parts = [table(["", "found", "asked for"],
                   [[line["row"], line["found"], line["asked_for"]]
                    for line in lines]), [""],
             plant_table(rows), [""], run_table(rows)]
    if left_out:
        parts += [[""], left_out]
    return "\n".join(line for part in parts for line in part) + "\n"
