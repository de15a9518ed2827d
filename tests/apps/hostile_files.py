"""Files that nobody should give: records and curves with values at the ends of what numbers hold, and what is no
record."""

import functools
import gzip
import os

HUGE = [-320, -300, -200, -100, -60, -30, -9, -3, 3, 9, 30, 58, 60, 62, 100, 150, 200, 300, 308]


def power(draw):
    return float(f"{draw.uniform(1, 9.9):.3f}e{draw.choice(HUGE)}")


def scaled(column, draw):
    factor = power(draw)
    return [factor * value for value in column]


def shifted(column, draw):
    offset = power(draw)
    return [offset + value for value in column]


def constant(column, draw):
    return [draw.choice([0.0, 1.0, power(draw)])] * len(column)


def denormal(column, draw):
    return [draw.randrange(-9, 9) * 5e-324 for _ in column]


def stepped(column, draw):
    size, at = power(draw), draw.randrange(len(column))
    return [value + size * (k >= at) for k, value in enumerate(column)]


def spiked(column, draw):
    column = list(column)
    for _ in range(draw.choice([1, 1, 5, 50])):
        column[draw.randrange(len(column))] = draw.choice([-1, 1]) * power(draw)
    return column


def alternating(column, draw):
    size = power(draw)
    return [size * (-1) ** k for k in range(len(column))]


def coarse(column, draw):
    unit = draw.choice([0.1, 1.0, 10.0])
    return [unit * round(value / unit) if abs(value) < 1e300 else value for value in column]


def without(column, draw):
    begin = draw.randrange(len(column))
    end = begin + draw.choice([1, 10, 100, 1000])
    return [float("nan") if begin <= k < end else value for k, value in enumerate(column)]


def columns_of(text):
    header, *rows = [line for line in text.splitlines() if not line.startswith("#")]
    return header, [list(map(float, column)) for column in zip(*(row.split(",") for row in rows))]


def record_of(header, columns, count=None):
    return "\n".join([header, *(",".join(map(repr, row)) for row in list(zip(*columns))[:count])]) + "\n"


def in_another_unit(text, model, draw):
    """The record and the model with one or two channels in units that are far from usual."""
    header, columns = columns_of(text)
    for _ in range(draw.choice([1, 2])):
        name, factor = draw.choice(["y1", "y2", "u1", "u2"]), 10.0 ** draw.randint(-65, 65)
        for c, column in enumerate(header.split(",")):
            if column in (name, f"{name}_setpoint"):
                columns[c] = [factor * value for value in columns[c]]
        for element in model["elements"]:
            element["gain"] *= factor if element["output"] == name else 1.0
            element["gain"] /= factor if element["input"] == name else 1.0
    return record_of(header, columns), model


def extreme_record(text, draw):
    """The record `text` with one to four columns, and now and then its times, that are others."""
    header, columns = columns_of(text)
    for _ in range(draw.choice([1, 1, 2, 3, 4])):
        c = draw.randrange(1, len(columns))
        if draw.random() < 0.15:
            columns[c] = list(columns[draw.randrange(1, len(columns))])
            continue
        change = draw.choice([scaled, scaled, shifted, constant, denormal, stepped, spiked, alternating, coarse,
                              without])
        columns[c] = change(columns[c], draw)
    if draw.random() < 0.1:
        columns[0] = scaled(columns[0], draw)
    if draw.random() < 0.1:
        columns[0] = shifted(columns[0], draw)
    return record_of(header, columns, None if draw.random() < 0.9 else draw.choice([0, 1, 2, 3, 5, 20]))


def usual_transform(draw):
    """Of a channel that moves between -3 and 3."""
    kind = draw.choice(["log", "power", "exponential", "equal_percentage", "quick_opening", "sinh", "tanh",
                        "piecewise_linear"])
    keys = {"log": {"zero": -9}, "power": {"exponent": 2, "zero": -9}, "exponential": {"curvature": 0.1},
            "equal_percentage": {"rangeability": 30, "closed": -9, "open": 9},
            "quick_opening": {"closed": -9, "open": 9}, "sinh": {"curvature": draw.choice([-0.2, 0.2])},
            "tanh": {"curvature": draw.choice([-0.1, 0.1])},
            "piecewise_linear": {"points": [[-5, -9], [-1, -1], [0.5, 2], [5, 4]]}}
    return {"kind": kind, "at": 0.1, **keys[kind]}


def extreme_transform(draw):
    """A usual one with one or two numbers that are others, or a point or key too many."""
    transform = usual_transform(draw)
    places = [(transform, key) for key, value in transform.items() if isinstance(value, (int, float))]
    places += [(point, i) for point in transform.get("points", []) for i in (0, 1)]
    for _ in range(draw.choice([1, 1, 2])):
        place, key = draw.choice(places)
        place[key] = draw.choice([0, -place[key], 2 * place[key], 1.0000000000000002, -1e308, 5e-324, power(draw),
                                  -power(draw)])
    if "points" in transform and draw.random() < 0.2:
        transform["points"] *= draw.choice([0, 2])
    if draw.random() < 0.05:
        transform[draw.choice(["points", "zero", "curvature", "name"])] = draw.choice([1, [], [[1]], "x", None])
    return transform


@functools.lru_cache
def odd_files(text):
    """(name, content) of files in the place of the usual file with `text`: bytes, or what makes it at a path."""
    usual = text.encode()
    packed = gzip.compress(usual, mtime=0)
    zeros = gzip.compress(bytes(1 << 20), mtime=0)
    half = len(usual) // 2
    return [
        ("pipe", os.mkfifo), ("folder", os.mkdir), ("nothing", lambda path: None),
        *((f"link to {target}", lambda path, target=target: os.symlink(target, path))
          for target in ("/dev/zero", "/dev/null", "/dev/urandom", "/dev/stdin", "/proc/self/mem",
                         "/etc")),
        ("link to itself", lambda path: os.symlink(os.path.basename(path), path)),
        ("empty", b""), ("a byte", b"\0"), ("line feeds", b"\n" * 1000), ("carriage returns", b"\r" * 1000),
        ("NUL bytes", bytes(100_000)), ("0xff", b"\xff" * 100_000), ("commas", b"," * 100_000),
        ("a long line", b"x" * 3_000_000), ("quotes", b'"' * 99_999), ("brackets", b"[" * 100_000),
        ("mark", b"\xef\xbb\xbf" + usual), ("mark alone", b"\xef\xbb\xbf"), ("two marks", b"\xef\xbb\xbf" * 2 + usual),
        ("UTF-16", text.encode("utf-16")), ("UTF-32", text.encode("utf-32")), ("UTF-16 without its mark",
                                                                                 text.encode("utf-16-be")),
        ("NUL in it", usual[:half] + b"\0" + usual[half:]), ("half", usual[:half]), ("twice", usual + usual),
        ("backwards", b"\n".join(reversed(usual.split(b"\n")))), ("CR LF", usual.replace(b"\n", b"\r\n")),
        ("0x1a", usual + b"\x1a"), ("latin", usual + b"\xe9\n"),
        ("gzip", packed), ("gzip twice", gzip.compress(packed, mtime=0)), ("gzip, cut", packed[:len(packed) // 2]),
        ("gzip's head", packed[:10]), ("gzip, wrong sum", packed[:-8] + bytes(8)), ("gzip and more", packed + b"more"),
        ("gzip, a bit wrong", packed[:60] + bytes([packed[60] ^ 4]) + packed[61:]),
        ("gzip of zeros", zeros * 200), ("gzip of a line without an end", gzip.compress(b"1" * (100 << 20), mtime=0)),
        ("gzip of nothing", gzip.compress(b"", mtime=0)),
        ("MAT file, its head", b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM"),
        ("MAT file, a large size", b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"\x0e\0\0\0\xff\xff\xff\x7f"),
        ("MAT file, its variable cut", b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"\x0f\0\0\0\x40\0\0\0\x78\x9c"),
        ("HDF5, its head", b"\x89HDF\r\n\x1a\n" + bytes(100)),
        ("SQLite, its head", b"SQLite format 3\0" + bytes(100)), ("zip, its head", b"PK\3\4" + bytes(100)),
        ("XLS, its head", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600)), ("PDF", b"%PDF-1.7\n" + bytes(100)),
        ("HTML", b"<!DOCTYPE html><html><body>Log in</body></html>"),
    ]
