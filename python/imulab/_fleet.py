"""Fleets: the calibrations of many units in one store."""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

from . import _imulab, _parts, _plots, _tables
from ._results import Result
from ._text import PathLike, optional_package, path, warn

if TYPE_CHECKING:
    import pandas  # type: ignore


class FleetStatistics(Result):
    """Spread, outliers, drift and stations of a fleet's units."""

    def _tables(self) -> list[str]:
        rows = [(c["name"], c["fleet"]["mean"], c["user"]["spread"], c["user"]["measurement"], c["user"]["unit"]) for c in self["coefficients"]]
        outliers = [(o["unit"], o["distance"], o["p_value"], o["farthest"]) for o in self["outliers"]]
        out = [_tables.table(("coefficient", "mean, SI", "spread of the units", "u of a measurement", "unit"), rows)]
        return out if not outliers else [*out, _tables.table(("outlier", "distance", "by chance", "farthest"), outliers)]

    def plot(self) -> Any:
        """How the units spread in each coefficient, one standard deviation, as a figure of matplotlib."""
        return _plots.coefficients([(c["name"], c["user"]["spread"], math.nan, c["user"]["unit"]) for c in self["coefficients"]], "spread")


class Fleet:
    """A store of units and their calibrations: one SQLite file, or "postgresql://USER@HOST/DATABASE". It is made when something is added.

    The same store as of `imulab fleet`. As `prior` of `calibrate` and `plan` it says what is known of a unit before it is measured.
    """

    def __init__(self, store: PathLike) -> None:
        self.store = path("store", store)

    def __repr__(self) -> str:
        return f"<imulab.Fleet: {_imulab.shown_store(self.store)}>"

    @property
    def units(self) -> list[dict[str, Any]]:
        """Serial number, name, how many calibrations, first and last time (UTC), and of the last one method, verdict and station."""
        return _imulab.fleet_units(self.store)

    def to_frame(self) -> pandas.DataFrame:
        """A pandas table with a row for each calibration: its origin, then each coefficient and its standard uncertainty, SI, in columns."""
        pandas = optional_package("pandas", "to_frame")
        return pandas.read_csv(io.StringIO(_imulab.fleet_csv(self.store)), dtype={"serial": str, "unit": str})

    def _repr_html_(self) -> str:
        columns = ("serial", "name", "calibrations", "first", "last", "method", "verdict", "station")
        return _tables.table(columns, [[unit[c] for c in columns] for unit in self.units])

    def add(self, *files: PathLike, unit: str = "", station: str = "", operator: str = "", measured: str = "") -> list[str]:
        """Adds calibrations, sessions or noise.json (with `unit`); what each is: "calibration", with " (known)" where the store had it."""
        if not files:
            raise TypeError("expected files to add")
        return _imulab.fleet_add(self.store, [path("file", f) for f in files], unit, station, operator, measured)

    def calibrate(
        self,
        *places: PathLike,
        method: str,
        terms: str = "auto",
        station: str = "",
        operator: str = "",
        measured: str = "",
        retry: bool = False,
        progress: Callable[[float], object] | None = None,
        executor: Executor | None = None,
        parts: int | None = None,
    ) -> dict[str, Any]:
        """Calibrates all sessions below folders that the store does not have; counts, and the failures as (file, message).

        executor: whose workers calibrate the sessions in as many `parts` (four a worker), each into a store of its own that is joined with this one; what
        this one has is calibrated again.
        """
        if not places:
            raise TypeError("expected folders with sessions")
        if progress is not None and not callable(progress):
            raise TypeError(f"progress: expected a callable, got {type(progress).__name__}")
        below = [path("place", p) for p in places]
        options = (method, terms, station, operator, measured)
        done = _parts.by_parts(executor, parts, progress, _parts.fleet, below, *options)
        return _parts.join_fleet(self.store, done) if done else _imulab.fleet_calibrate(self.store, below, *options, retry, progress, "")

    def statistics(self, *, method: str = "", require: str = "", due: str = "", false_alarm: float = 0.01) -> FleetStatistics:
        """As `imulab fleet stats`. require: limits of the values; due: how far a calibration may be off before the unit is due."""
        if not 1e-9 <= false_alarm <= 0.5:
            raise _imulab.Error(f"false_alarm: {false_alarm}; expected 1e-09 to 0.5")
        outcome = _imulab.fleet_statistics(self.store, method, require, due, false_alarm)
        warn(outcome.warnings)
        return FleetStatistics(outcome)

    def check(self) -> tuple[list[str], list[str]]:
        """Damages of the store, and the files of its sessions that are no longer what they were."""
        return _imulab.fleet_check(self.store)
