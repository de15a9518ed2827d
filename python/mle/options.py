"""Keywords as the texts of the commands' flags, which have the same names."""

from __future__ import annotations

import difflib
import inspect
import operator
import textwrap
from collections.abc import Iterable, Mapping
from typing import Any, Callable, List, Sequence, Tuple, TypeVar


def _number(value: Any) -> str:
    """The shortest text that reads as the same number, a whole one without a point."""
    try:
        return str(operator.index(value))
    except TypeError:
        number = float(value)
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def text_of(value: Any) -> str:
    """``value`` as it stands after ``--name=``: True as ``true``, a list with
    commas, a mapping of tags as ``TAG=CHANNEL,...``, a tuple in a list with
    colons (``("overhead", 300, 1)``), dates of datetime, pandas and NumPy in ISO
    8601."""
    if isinstance(value, str):
        return value
    if value is None:
        return "none"
    if isinstance(value, bool) or type(value).__name__ == "bool_":
        return "true" if value else "false"
    if type(value).__name__ == "datetime64":
        value = value.astype("datetime64[us]").item()
    if hasattr(value, "isoformat"):
        return value.isoformat()
    if isinstance(value, Mapping):
        return ",".join(f"{tag}={text_of(channel)}" for tag, channel in value.items())
    if isinstance(value, Iterable):
        return ",".join(_part(part) for part in value)
    return _number(value)


def _part(part: Any) -> str:
    if isinstance(part, tuple):
        return ":".join(text_of(field) for field in part)
    return text_of(part)


# (group, name, default, unit and range, meaning, names to choose from) of an option.
Table = Sequence[Tuple[str, str, str, str, str, List[str]]]


def names_of(table: Table) -> List[str]:
    return [option[1] for option in table]


def help_on(table: Table) -> str:
    """The options of a table, a group after the other."""
    lines: List[str] = []
    last = None
    for group, name, default, kind, meaning, _ in table:
        if group != last:
            lines += ["", group]
            last = group
        lines.append(f"  {name} [{default}] {kind}".rstrip())
        lines += textwrap.wrap(meaning, 78, initial_indent=" " * 6, subsequent_indent=" " * 6)
    return "\n".join(lines[1:]) + "\n"


def option_texts(
    function: str, table: Table, options: Mapping[str, Any]
) -> List[Tuple[str, str]]:
    """Names and texts. Raises TypeError for a name that is not in the table, as
    Python does for keywords, with the nearest one."""
    known = names_of(table)
    for name in options:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            raise TypeError(f"{function}() got an unexpected keyword argument '{name}'{hint}")
    return [(name, text_of(value)) for name, value in options.items()]


Function = TypeVar("Function", bound=Callable[..., Any])


def takes_keywords(table: Table) -> Callable[[Function], Function]:
    """Names the options of a table in the signature of a function that takes them as
    ``**options``, so that notebooks complete them."""

    def named(function: Function) -> Function:
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        keywords = [
            inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default)
            for _, name, default, *_ in table
        ]
        function.__signature__ = signature.replace(  # type: ignore[attr-defined]
            parameters=own + keywords
        )
        return function

    return named
