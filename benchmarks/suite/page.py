"""Tables of the suite: benchmark.html, sortable and without any other file, and benchmark.md."""

import csv
import html
import math
import os
import statistics
import tempfile

import measures
import tracks

DOWN = 5.0  # times, of relative E
EXACT = 1e-12  # relative E of a model that is the plant
UNSTABLE = 100.0  # times the squared error of the loop

# Key, head, what it says.
COLUMNS = (
    ("runs", "cases", "without, and with something aged"),
    ("false", "false alarms, %", "the model given is exact, and the method says that something has "
     "aged"),
    ("found", "found, %", "aged, and the method says so: it corrects, or reports a mismatch"),
    ("named", "named, %", "aged, and exactly the elements that have aged are named"),
    ("open", "open, %", "cannot tell"),
    ("harm", "harm, %", "the correction is worse than the model given, of all cases"),
    ("down", "E down, %", "aged: relative E down five-fold"),
    ("E", "E", "aged: relative E after over before, median"),
    ("error", "error", "aged: error of predictions of records held out, over that with the model "
     "given, geometric mean"),
    ("loop", "loop", "aged: squared error of the closed loop, over that with the model given, "
     "geometric mean of those that are stable; in brackets with the true model"),
    ("unstable", "unstable", "aged: loops that the corrected model makes unstable, or a hundred "
     "times as bad"),
    ("coverage", "coverage, %", "of stated 95 % intervals"),
    ("reason", "reason, %", "true, where one is told or is to be told"),
    ("silent", "failed, %", "no answer: failed, or took too long"),
)


def share(part, whole):
    return 100.0 * part / whole if whole else None


def geometric(values):
    values = [value for value in values if value and math.isfinite(value)]
    return math.exp(statistics.mean(map(math.log, values))) if values else None


def of(rows, key):
    return [row[key] for row in rows if row[key] is not None]


def says_so(row):
    return row["decision"] in ("corrected", "mismatch")


def cells(rows, corrects):
    """A number, or None, for each column."""
    none = [row for row in rows if row["kind"] == "none"]
    exact = [row for row in none if row["relative_E_before"] is not None
             and row["relative_E_before"] < EXACT]
    aged = [row for row in rows if row["kind"] == "aged"]
    named = of(aged, "named")
    if not corrects and set(named) <= {"missed"}:  # it never says which
        named = []
    result = {
        "runs": f"{len(none)} + {len(aged)}",
        "false": share(sum(map(says_so, exact)), len(exact)),
        "found": share(sum(map(says_so, aged)), len(aged)),
        "named": share(named.count("exactly"), len(named)),
        "open": share(sum(row["decision"] == "cannot_tell" for row in rows), len(rows)),
        "silent": share(sum(row["decision"] == "no_answer" for row in rows), len(rows))}
    if corrects:
        pairs = [(row["relative_E_before"], row["relative_E_after"]) for row in aged
                 if row["relative_E_before"]]
        inside, total = sum(of(rows, "inside")), sum(of(rows, "intervals"))
        loops = of(aged, "loop")
        stable = [row for row in aged if row["loop"] is not None and row["loop"] < UNSTABLE]
        result.update({
            "harm": share(sum(of(rows, "harm")), len(of(rows, "harm"))),
            "down": share(sum(DOWN * after <= before for before, after in pairs), len(pairs)),
            "E": statistics.median(after / before for before, after in pairs) if pairs else None,
            "error": geometric(of(aged, "error")), "loop": geometric(of(stable, "loop")),
            "truth": geometric(of(stable, "loop_of_truth")),
            "unstable": len(loops) - len(stable) if loops else None,
            "coverage": share(inside, total),
            # Of a method that ever tells one.
            "reason": share(sum(of(rows, "reason_true")), len(of(rows, "reason_true")))
            if any(of(rows, "told")) else None})
    return result


def number(key, value):
    if key == "E":
        return f"{value:.2g}"
    return f"{value:.2f}" if key in ("error", "loop") else f"{value:.0f}"


def shown(key, found):
    value = found.get(key)
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    text = number(key, value)
    if key == "loop" and found.get("truth"):
        text += f" ({number(key, found['truth'])})"
    return text


def groups(rows, methods):
    """(track, method, rows), every track and all together."""
    for track in [*tracks.TRACKS, "all"]:
        for method in methods:
            some = [row for row in rows if row["method"] == method.name
                    and (track in (row["track"], "all"))]
            if some and not (track == "all" and method.tracks):
                yield track, method, some


def main_table(rows, methods):
    lines = []
    for track, method, some in groups(rows, methods):
        found = cells(some, method.corrects)
        lines.append([track, method, *(shown(key, found) for key, _, _ in COLUMNS)])
    return lines


KINDS = {"gain": "gains", "time_constant": "time constants", "delay": "dead times"}
POWER = [*(f"{part:g}" for part in tracks.PARTS), *(f"1, {kind}" for kind in KINDS.values()),
         "limits found"]


def power_table(rows, methods):
    """Share that says so, by the size of the mismatch in parts of its limit; and at how many limits
    it is 95 % or more."""
    lines = []
    for method in methods:
        own = [row for row in rows if row["track"] == "power" and row["method"] == method.name]
        if not own:
            continue
        line = [found_share([row for row in own if part_of(row) == part]) for part in tracks.PARTS]
        limits = {}
        for row in own:
            if part_of(row) == 1.0:
                limits.setdefault(row["scenario"], []).append(row)
        line += [found_share([row for name, some in limits.items() if f" {key} of " in name
                              for row in some]) for key in KINDS]
        reached = [20 * sum(map(says_so, some)) >= 19 * len(some) for some in limits.values()]
        lines.append([method, *line, f"{sum(reached)} of {len(reached)}"])
    return lines


def part_of(row):
    """Of its limit, of a case of the track power."""
    return float(row["scenario"].split()[0])


def found_share(rows):
    return f"{share(sum(map(says_so, rows)), len(rows)):.0f}" if rows else "–"


def markdown_table(header, lines):
    text = ["| " + " | ".join(header) + " |", "|---" * len(header) + "|"]
    return text + ["| " + " | ".join(line) + " |" for line in lines]


def life_lines(lives):
    def text(value):
        return "–" if value is None else f"{value:g}"
    return [[row["method"], f"{row['quiet']} + {row['aged']}", text(row["false"]),
             text(row["found"]), text(row["early"]), text(row["right"]), text(row["delay"])]
            for row in lives]


LIVES = ["method", "lives", "false alarms", "found", "too early", "right element",
         "days until found, median"]


def about(arguments, rows):
    count = len({(row["track"], row["scenario"], row["plant"], row["kind"], row["repeat"])
                 for row in rows})
    return (f"Form {arguments.form}, seed “{arguments.seed}”, {arguments.repeats} "
            f"repeat{'s' if arguments.repeats > 1 else ''}: {count} cases.")


def markdown(arguments, rows, methods, lives):
    header = ["track", "method", *(head for _, head, _ in COLUMNS)]
    text = [about(arguments, rows), ""]
    text += markdown_table(header, [[track, method.name, *line] for track, method, *line
                                    in main_table(rows, methods)])
    power = power_table(rows, methods)
    if power:
        text += ["", "Says so, %, by the mismatch in parts of its limit:", ""]
        text += markdown_table(["method", *POWER],
                               [[method.name, *line] for method, *line in power])
    if lives:
        text += ["", "Lives under watch:", "", *markdown_table(LIVES, life_lines(lives))]
    return "\n".join(text) + "\n"


STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 100rem;
  padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .45rem; text-align: right; border-bottom: 1px solid #8884; }
td { white-space: nowrap; }
th { position: sticky; top: 0; background: Canvas; vertical-align: bottom; }
th button { all: unset; cursor: pointer; font-weight: 600; }
th button:focus-visible { outline: 2px solid; }
th[aria-sort=ascending] button::after { content: " ▲"; }
th[aria-sort=descending] button::after { content: " ▼"; }
.text { text-align: left; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .1rem 1rem; }
dt { font-weight: 600; } dd { margin: 0; }
select { font: inherit; }
"""
SCRIPT = """
for (const button of document.querySelectorAll("th button")) button.onclick = () => {
  const head = button.parentElement, body = head.closest("table").tBodies[0];
  const up = head.getAttribute("aria-sort") !== "ascending", at = head.cellIndex;
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", up ? "ascending" : "descending");
  const key = row => { const t = row.cells[at].textContent, n = parseFloat(t);
    return row.cells[at].className ? t : isNaN(n) ? (t === "inf" ? Infinity : null) : n; };
  const rows = [...body.rows].sort((a, b) => { const x = key(a), y = key(b);
    if (x === null || y === null) return (x === null) - (y === null);
    return (x < y ? -1 : x > y ? 1 : 0) * (up ? 1 : -1); });
  body.append(...rows);
};
const track = document.getElementById("track");
const show = () => { for (const row of document.querySelectorAll("#main tbody tr"))
  row.hidden = track.value !== "" && row.cells[0].textContent !== track.value; };
track.onchange = show; show();
"""


def html_table(name, header, lines, texts):
    """Lines of strings, the first `texts` columns to be sorted as texts."""
    head = "".join(f'<th{" class=text" if i < texts else ""} title="{html.escape(title)}">'
                   f"<button>{html.escape(key)}</button></th>"
                   for i, (key, title) in enumerate(header))
    body = "\n".join("<tr>" + "".join(
        f'<td{" class=text" if i < texts else ""}>{html.escape(cell)}</td>'
        for i, cell in enumerate(line)) + "</tr>" for line in lines)
    return (f'<div class="scroll"><table id="{name}"><thead><tr>{head}</tr></thead>\n'
            f"<tbody>\n{body}\n</tbody></table></div>")


def list_of(pairs):
    return "<dl>" + "".join(f"<dt>{html.escape(one)}</dt><dd>{html.escape(two)}</dd>"
                            for one, two in pairs) + "</dl>"


def document(arguments, rows, methods, lives):
    header = [("track", ""), ("method", ""), *(column[1:] for column in COLUMNS)]
    lines = [[track, method.name, *line] for track, method, *line in main_table(rows, methods)]
    present = list(dict.fromkeys(line[0] for line in lines))
    options = "".join(f"<option{' selected' if name == 'all' else ''}>{name}</option>"
                      for name in present)
    parts = [f"<p>{html.escape(about(arguments, rows))} Columns are sorted by their heads; "
             "– is not known, or not said.</p>",
             f'<p><label>Track <select id="track"><option value="">every</option>{options}'
             "</select></label></p>", html_table("main", header, lines, 2)]
    power = power_table(rows, methods)
    if power:
        parts += ["<h2>Power</h2><p>Cases in which the method says that something has changed, %, "
                  "by the size of the mismatch, in parts of the limit at which it matters; at 0 "
                  "these are false alarms. At the limit also by what is wrong, and of how many "
                  "limits 95 % or more are found.</p>",
                  html_table("power", [("method", ""), *((head, "") for head in POWER)],
                             [[method.name, *line] for method, *line in power], 1)]
    if lives:
        parts += ["<h2>Watch</h2>", html_table("lives", [(name, "") for name in LIVES],
                                               life_lines(lives), 1)]
    parts += ["<h2>Columns</h2>", list_of(column[1:] for column in COLUMNS),
              "<h2>Tracks</h2>", list_of(tracks.ABOUT.items()), "<h2>Methods</h2>",
              list_of((method.name, f"{'corrects' if method.corrects else 'detects only'}"
                       f"{'; is told the control law' if method.control_law else ''}. "
                       f"{method.source or 'given on the command line'}. {method.settings}")
                      for method in methods)]
    return ("<!doctype html>\n<html lang=en><head><meta charset=utf-8>"
            "<meta name=viewport content='width=device-width'>"
            "<title>Model maintenance from routine records</title>"
            f"<style>{STYLE}</style></head><body>\n"
            "<h1>Model maintenance from routine records</h1>\n" + "\n".join(parts) +
            f"\n<script>{SCRIPT}</script></body></html>\n")


def write_file(path, text):
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, newline="") as file:
        file.write(text)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)


def csv_text(header, lines, folder):
    with tempfile.TemporaryFile("w+", dir=folder, newline="") as file:
        csv.writer(file).writerows([header, *lines])
        file.seek(0)
        return file.read()


def seconds_lines(kept):
    """Processor seconds: median and most of each track and method."""
    found = {}
    for one in kept:
        found.setdefault((one["row"]["track"], one["row"]["method"]), []).append(one["seconds"])
    return [[*key, len(values), f"{statistics.median(values):.2f}", f"{max(values):.2f}"]
            for key, values in sorted(found.items())]


def write(arguments, methods, kept, lives):
    """All files; the text of benchmark.md."""
    rows = [one["row"] for one in kept]
    out = arguments.out
    write_file(out / "results.csv", csv_text(
        measures.COLUMNS, ([row[key] for key in measures.COLUMNS] for row in rows), out))
    write_file(out / "seconds.csv", csv_text(
        ["track", "method", "cases", "median", "most"], seconds_lines(kept), out))
    write_file(out / "benchmark.html", document(arguments, rows, methods, lives))
    text = markdown(arguments, rows, methods, lives)
    write_file(out / "benchmark.md", text)
    return text
