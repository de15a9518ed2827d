"""What became of a case after a method's answer, as one row of figures.

- E: Σ over pairs and samples of (s − ŝ)², s the true step responses over the horizon of the case;
  relative E: Σ over pairs of ‖s − ŝ‖² / ‖s‖² (of a pair that the truth has not: over that of the
  model given, or its own).
- error: of predictions of records held out over 0.2, 1 and 3 times the time constant and dead time
  of the output's largest element, in the model's over the given model's; geometric mean.
- named: the pairs that the method says have aged (of a method that does not say: whose step
  response changed by more than 2 %) are those that have.
- harm, where corrected: with nothing aged a step response changed by more than 2 % of its norm, or
  (where the model's structure is wrong) relative E rose; with something aged relative E rose. Of
  real plants: an output's error on records held out rose by more than 5 %.
- coverage: how many of the stated 95 % intervals hold the true value.
- reason true: of the adversary's cases, an explanation that was given is true.
- loop: the squared error of set points of the closed loop without noise, over that with the model
  given; infinite if the loop is unstable.
A method that leaves the model, whatever it says, is judged by the model given.
"""

import math
import statistics

import protocol
import report  # of benchmarks/real, by cases

COLUMNS = ["track", "scenario", "plant", "kind", "repeat", "method", "decision", "E_before",
           "E_after", "relative_E_before", "relative_E_after", "error", "worst_error", "named",
           "harm", "inside", "intervals", "told", "reason_true", "loop", "loop_of_truth", "why"]


def rounded(value):
    if isinstance(value, float):
        return float(f"{value:.6g}")
    return value


def ratios(before, after):
    row = {"given": {"outputs": before}, "corrected": {"outputs": after}}
    return list(report.ratios(row).values())


class Judged:
    """A case with what does not depend on the method."""

    def __init__(self, case, truth):
        self.case, self.truth = case, truth
        self.before = truth.distance(truth.given)
        self.errors = truth.several_step(truth.given)
        self.loop = truth.loop_error(truth.given) if truth.loop_error else None
        self.best = truth.loop_error(truth.true) if truth.loop_error else None

    def row(self, method, answer):
        row = {"track": self.case.track, "scenario": self.case.name, "plant": self.case.plant,
               "kind": self.case.kind, "repeat": self.case.repeat, "method": method.name,
               "decision": answer.decision, "why": answer.why}
        if self.before:
            (row["E_before"], row["relative_E_before"]) = self.before
        if not method.corrects:
            row["named"] = self.named(answer, set())
            return self.finished(row)
        try:
            self.judge(row, answer)
        except (ArithmeticError, ValueError, KeyError, IndexError, TypeError) as error:
            row.update(decision="no_answer",
                       why=f"model.json: {type(error).__name__} {error}"[:160])
            self.judge(row, protocol.Answer("no_answer"))
        return self.finished(row)

    def finished(self, row):
        return {key: rounded(row.get(key)) for key in COLUMNS}

    def judge(self, row, answer):
        truth, model = self.truth, answer.model or self.truth.given
        corrected = answer.decision == "corrected"
        changed, largest = truth.changed(model) if corrected else (set(), 0.0)
        if self.before:
            (row["E_after"], row["relative_E_after"]) = truth.distance(model)
            if not math.isfinite(row["relative_E_after"]):
                raise ValueError("the step responses are not finite")
        row["error"] = row["worst_error"] = 1.0 if self.errors else None
        if self.errors and corrected:
            some = ratios(self.errors, truth.several_step(model))
            row["error"] = math.exp(statistics.mean(math.log(max(one, 1e-9)) for one in some))
            row["worst_error"] = max(some)
        row["named"] = self.named(answer, changed)
        row["harm"] = int(corrected and self.harmed(row, largest))
        row["inside"], row["intervals"] = self.coverage(answer)
        if self.case.track == "adversary":
            told = truth.reason_true(answer.reasons)
            row["told"] = len(answer.reasons)
            row["reason_true"] = None if told is None else int(told)
        if self.loop and math.isfinite(self.loop):
            after = truth.loop_error(model) if corrected else self.loop
            row["loop"], row["loop_of_truth"] = after / self.loop, self.best / self.loop

    def harmed(self, row, largest):
        before, after = row.get("relative_E_before"), row.get("relative_E_after")
        if before is None:
            return row["worst_error"] is not None and row["worst_error"] > report.WORSE
        if self.case.kind == "none" and before < 1e-12:
            return largest > 0.02
        return after > before * (1.0 + 1e-9)

    def named(self, answer, changed):
        aged = self.truth.aged
        if not aged:
            return None
        said = set(answer.aged) or changed
        if answer.decision not in ("corrected", "mismatch") or not said:
            return "missed"
        if not said & aged:
            return "another"
        return "exactly" if said == aged else "in part"

    def coverage(self, answer):
        if not self.truth.true or answer.decision != "corrected" or not answer.intervals:
            return None, None
        true = {(element["output"], element["input"]): element
                for element in self.truth.true["elements"]}
        inside = total = 0
        for output, source, key, lower, upper in answer.intervals:
            element = true.get((output, source), {})
            if "gain" in element and key in element:
                total += 1
                inside += lower <= element[key] <= upper
        return inside, total
