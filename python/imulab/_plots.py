"""Results as figures of matplotlib, which is imported where a figure is asked for."""

from __future__ import annotations

import datetime
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ._arrays import FloatArray
from ._text import optional_package

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")  # Okabe and Ito
_SHOWN_SOURCES = 5

Row = tuple[str, float, float, str]  # name, value, half of its interval (NaN: none), unit


def pyplot() -> Any:
    return optional_package("matplotlib.pyplot", "plot")


def time_label(first_s: float) -> str:
    """The axis of times from the first sample on; its date where the stamps count from 1970."""
    if first_s < 1e8:
        return "time from the first sample, s"
    date = datetime.datetime.fromtimestamp(first_s, datetime.timezone.utc)
    return f"time from {date:%Y-%m-%d %H:%M:%S} UTC, s"


def _group(name: str) -> str:
    """The coefficients that share a panel: those of one kind of a triad."""
    triad, term, element = name.split(".")
    words = {"accel": "accelerometers", "gyro": "gyros"}[triad]
    if term == "matrix":
        return f"{words}: {'scale factors' if element[0] == element[1] else 'misalignments'}"
    return f"{words}: {term.replace('_', ' ')}"


def coefficients(rows: Sequence[Row], what: str) -> Any:
    """A panel for each kind of coefficient, a bar each; with whiskers where there are intervals."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((_group(row[0]), row[3]), []).append(row)
    across = min(3, max(1, len(groups)))
    down = max(1, math.ceil(len(groups) / across))
    figure, places = pyplot().subplots(down, across, layout="constrained", figsize=(4 * across, 2.6 * down), squeeze=False)
    for place in places.flat[len(groups):]:
        place.set_visible(False)
    for place, ((title, unit), members) in zip(places.flat, groups.items()):
        labels = [row[0].rsplit(".", 1)[1] for row in members]
        errors = None if all(math.isnan(row[2]) for row in members) else [0 if math.isnan(row[2]) else row[2] for row in members]
        place.bar(labels, [row[1] for row in members], yerr=errors, capsize=3, color=COLORS[title.startswith("gyros")])
        place.axhline(0, color="black", linewidth=0.6)
        place.set_title(title, fontsize="medium")
        place.set_ylabel(f"{what}, {unit}" if unit else what)
    return figure


def differences(series: Mapping[str, Mapping[str, float]]) -> Any:
    """Differences in their standard uncertainties, the largest first; of each comparison."""
    figure, places = pyplot().subplots(1, len(series), layout="constrained", figsize=(5 * len(series), 6), squeeze=False)
    for place, (title, sigmas) in zip(places.flat, series.items()):
        ordered = sorted(sigmas.items(), key=lambda item: abs(item[1]))[-30:]
        place.barh([name for name, _ in ordered], [value for _, value in ordered], color=COLORS[0])
        for bound in (-2, 2):
            place.axvline(bound, color=COLORS[1], linestyle="--", linewidth=1, label="2 standard uncertainties" if bound > 0 else None)
        place.set_title(title, fontsize="medium")
        place.set_xlabel("difference / its standard uncertainty")
        place.tick_params(axis="y", labelsize="small")
        place.legend(loc="lower right", fontsize="small")
    return figure


def recording(t: FloatArray, gyro: FloatArray, accel: FloatArray, units: tuple[str, str]) -> Any:
    """Rates and forces over the time from the first sample."""
    figure, axes = pyplot().subplots(2, 1, sharex=True, layout="constrained")
    first = float(t[0]) if len(t) else 0.0
    for axis, values, label in ((axes[0], gyro, f"rate, {units[0]}"), (axes[1], accel, f"force, {units[1]}")):
        for i, name in enumerate("xyz"):
            axis.plot(t - first, values[:, i], linewidth=0.7, label=name, color=COLORS[i])
        axis.set_ylabel(label)
        axis.legend(loc="upper right", ncols=3)
    axes[1].set_xlabel(time_label(first))
    return figure


def track(latitude: FloatArray, longitude: FloatArray, errors: FloatArray | None, sigmas: FloatArray | None = None) -> Any:
    """The track; beside it over time the horizontal error where there is a reference, and its sigma where it is known."""
    alone = errors is None and sigmas is None
    figure, places = pyplot().subplots(1, 1 if alone else 2, layout="constrained", squeeze=False, figsize=(5 if alone else 10, 4))
    place = places[0][0]
    place.plot(longitude, latitude, color=COLORS[0])
    place.set_xlabel("longitude, deg")
    place.set_ylabel("latitude, deg")
    for color, rows, what in ((COLORS[1], sigmas, "sigma"), (COLORS[0], errors, "error")):
        if rows is None:
            continue
        shown = places[0][1]
        shown.plot(rows[:, 0] - rows[0, 0], np.hypot(rows[:, 1], rows[:, 2]), color=color, label=what)
        shown.set_xlabel(time_label(float(rows[0, 0])))
        shown.set_ylabel("horizontal error, m")
    if errors is not None and sigmas is not None:
        places[0][1].legend()
    return figure


def _horizontal(part: Mapping[str, Any]) -> FloatArray:
    if "pe" not in part:
        return np.asarray(part["ph"]["sigma"], dtype=float)
    east, north = (np.asarray(part[axis]["sigma"], dtype=float) for axis in ("pe", "pn"))
    out: FloatArray = np.sqrt(east**2 + north**2)
    return out


def grades(histories: Mapping[str, Mapping[str, Any]]) -> Any:
    """The horizontal error of each grade over time."""
    figure, place = pyplot().subplots(layout="constrained", figsize=(7, 4))
    for color, (grade, history) in zip(itertools.cycle(COLORS), histories.items()):
        place.plot(np.asarray(history["time_s"], dtype=float) / 60, _horizontal(history["total"]), color=color, label=grade)
    place.set_yscale("log")  # the worst grade would hide the others
    place.set_xlabel("time, min")
    place.set_ylabel("horizontal error, one sigma, m")
    place.legend()
    return figure


def budget(history: Mapping[str, Any]) -> Any:
    """The horizontal error over time, and its largest sources."""
    figure, place = pyplot().subplots(layout="constrained", figsize=(7, 4))
    minutes = np.asarray(history["time_s"], dtype=float) / 60
    place.plot(minutes, _horizontal(history["total"]), color="black", linewidth=2, label="total")
    sources = sorted(history["sources"].items(), key=lambda item: -float(_horizontal(item[1])[-1]))[:_SHOWN_SOURCES]
    for color, (name, part) in zip(COLORS, sources):
        place.plot(minutes, _horizontal(part), color=color, label=name)
    place.set_xlabel("time, min")
    place.set_ylabel("horizontal error, one sigma, m")
    place.legend()
    return figure


# ---- noise


def _fitted(axis: Mapping[str, Any], tau: FloatArray) -> FloatArray:
    """The Allan deviation of the terms that the log determines (IEEE Std 952)."""

    def square(coefficient: Mapping[str, Any]) -> float:
        return float(coefficient["value"]) ** 2 if coefficient["determined"] else 0.0

    terms = axis["coefficients"]
    variance: FloatArray = 3 * square(terms["Q"]) / tau**2 + square(terms["N"]) / tau + 2 * math.log(2) / math.pi * square(terms["B"])
    variance = variance + square(terms["K"]) * tau / 3 + square(terms["R"]) * tau**2 / 2
    for process in axis.get("markov", []):
        x = tau / float(process["time"]["value"] or math.inf)
        bracket = np.where(x > 1e-3, 1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x), x * x / 3)
        variance = variance + 2 * square(process["sigma"]) / x * bracket
    return np.sqrt(variance)


def _shape(term: str, tau: FloatArray) -> FloatArray:
    """The Allan deviation of a term of size one."""
    sizes: FloatArray = {"N": 1 / np.sqrt(tau), "B": np.full(tau.shape, 0.664), "K": np.sqrt(tau / 3)}[term]
    return sizes


def _asymptotes(place: Any, axes: Sequence[Mapping[str, Any]], tau: FloatArray, unit: str) -> None:
    """N, B and K of the worst axis: dashed where the log determines them, else the bound, dotted."""
    units = {"N": f"{unit}/sqrt(Hz)", "B": unit, "K": f"{unit}/sqrt(s)"}
    for style, term in enumerate("NBK"):
        found = [a["coefficients"][term] for a in axes]
        known = [c["value"] for c in found if c["determined"]]
        bounds = [c["upper"] for c in found if not c["determined"] and c["upper"] is not None]
        if not known and not bounds:
            continue
        size, sign = (max(known), "=") if known else (max(bounds), "<")
        place.loglog(tau, size * _shape(term, tau), linestyle="--" if known else ":", linewidth=1, color=COLORS[3 + style],
                     label=f"{term} {sign} {size:.2g} {units[term]}")


def noise(axes: Sequence[Mapping[str, Any]], kind: str) -> Any:
    """A panel a triad: deviations with their 95 % bounds, and of Allan deviations the fit, and N, B and K or their bounds."""
    named = {triad: [a for a in axes if a["name"].startswith(triad)] for triad in ("gyro", "accel")}
    shown = {triad: own for triad, own in named.items() if own}
    figure, places = pyplot().subplots(1, len(shown), layout="constrained", figsize=(6 * len(shown), 4.5), squeeze=False)
    for place, (triad, own) in zip(places.flat, shown.items()):
        values: list[float] = []
        for axis in own:
            color = COLORS["xyz".index(axis["name"][-1])]
            if "deviation" not in axis:  # of several logs there are coefficients alone
                continue
            place.fill_between(axis["tau"], axis["lower"], axis["upper"], alpha=0.2, color=color)
            place.loglog(axis["tau"], axis["deviation"], label=axis["name"], color=color)
            values += axis["deviation"]
            if "coefficients" in axis and kind.endswith("allan"):
                tau = np.asarray(axis["tau"], dtype=float)
                place.loglog(tau, _fitted(axis, tau), color="black", linewidth=0.8, label="fit" if axis is own[-1] else None)
        fitted = [a for a in own if "coefficients" in a]
        longest = max((a["tau"] for a in own if "tau" in a), key=len, default=[0.01, 0.1, 1.0, 10.0, 100.0, 1000.0])
        if fitted and kind.endswith("allan") and "modified" not in kind:
            _asymptotes(place, fitted, np.asarray(longest, dtype=float), own[0]["unit"])
        if values:
            place.set_ylim(0.3 * min(values), 3 * max(values))
        place.set_title({"gyro": "gyros", "accel": "accelerometers"}[triad], fontsize="medium")
        place.set_xlabel("averaging time, s")
        place.set_ylabel(f"deviation, {own[0]['unit']}")
        place.legend(fontsize="small")
    return figure
