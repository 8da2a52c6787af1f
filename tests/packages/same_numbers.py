"""same_numbers.py A B: the numbers of the files of two folders, and how far they differ, relative to the largest of their column or array.

Rounding is not the same on two processors (fused multiplication and addition), and estimates amplify it by the condition of their equations:
samples and readings must agree to 1e-12, estimates to a millionth of their standard uncertainty.
"""

import json
import math
import pathlib
import sys

here, there = (pathlib.Path(p) for p in sys.argv[1:3])
worst = {}


def note(kind, difference):
    worst[kind] = max(worst.get(kind, 0.0), difference)


def table(path):
    lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
    return list(zip(*([float(x) for x in line.split(",")] for line in lines[1:])))


def numbers(value, place=""):
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{place}/{key}")
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from numbers(inner, f"{place}/{k}")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield place, float(value)


for file in sorted(here.rglob("*")):
    if not file.is_file() or "given" in file.parts:
        continue
    other = there / file.relative_to(here)
    if file.suffix == ".csv":
        for a, b in zip(table(file), table(other), strict=True):
            size = max(map(abs, a)) or 1
            note(file.name, max(abs(x - y) for x, y in zip(a, b, strict=True)) / size)
    elif file.suffix == ".json":
        a, b = dict(numbers(json.loads(file.read_text()))), dict(numbers(json.loads(other.read_text())))
        assert a.keys() == b.keys(), f"{file.name}: {a.keys() ^ b.keys()}"
        size = {}
        for place, value in a.items():
            array = place.rstrip("0123456789/")
            size[array] = max(size.get(array, 0.0), abs(value))
        for place, value in a.items():
            if "/seconds" in place:  # the time that it took
                continue
            scale = size[place.rstrip("0123456789/")] or 1
            note(file.name, abs(value - b[place]) / scale)
for name, difference in worst.items():
    print(f"{name:24} {difference:.1e}")
