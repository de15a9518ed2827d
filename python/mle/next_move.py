"""The next move: what mle_correct --plan plans."""

from __future__ import annotations

from typing import Any, Dict, List


class NextMove:
    """The least costly change of set points after which open gains are known.

    ``state`` is "found", "nothing_needed", "out_of_reach" (the best within the limits,
    and ``hindrance`` says which) or "impossible"; ``sentences`` say what to do first.
    ``steps`` is a data frame of set points, indexed by the time after the first move;
    ``gains`` one of standard errors relative to the gain, ``wanted``, ``before`` and
    ``after``, indexed by output and input; ``channels`` one of what each output and
    input is expected to do, ``expected_low`` to ``expected_high``, its band and its
    limits. ``duration`` and ``earliest`` are in the model's time unit; ``cost`` is money
    where ``priced``. Without a plan the frames are empty and ``cost`` is 0.
    """

    def __init__(self, plan: Dict[str, Any]) -> None:
        import pandas as pd

        self.state: str = plan["state"]
        self.sentences: List[str] = plan["sentences"]
        self.hindrance: str = plan.get("hindrance", "")
        self.duration: float = plan.get("duration", 0.0)
        self.cost: float = plan.get("cost", 0.0)
        self.priced: bool = plan.get("priced", False)
        self.earliest: float = plan.get("earliest", float("nan"))
        steps = plan.get("steps", [])
        self.steps = pd.DataFrame(
            [step["set_points"] for step in steps],
            index=pd.Index([step["time"] for step in steps], name="time", dtype=float),
        )
        names = ["output", "input", "wanted", "before", "after"]
        gains = [[gain[name] for name in names] for gain in plan.get("gains", [])]
        self.gains = pd.DataFrame(gains, columns=names).set_index(names[:2]).astype(float)
        kinds = ["expected", "band", "limits"]
        columns = [f"{kind}_{end}" for kind in kinds for end in ("low", "high")]
        channels = plan.get("channels", [])
        self.channels = pd.DataFrame(
            [[value for kind in kinds for value in one[kind]] for one in channels],
            columns=columns,
            index=pd.Index([one["name"] for one in channels], name="channel"),
        ).astype(float)

    def __str__(self) -> str:
        return " ".join(self.sentences)

    def __repr__(self) -> str:
        return f"<mle.NextMove {self.state}>"
