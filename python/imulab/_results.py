"""Answers: the command's JSON as data, its table as text, its page, and what is missing."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _arrays, _imulab, _plots, _tables
from ._arrays import FloatArray
from ._imulab import Unsupported
from ._recording import Recording
from ._session import Session
from ._text import PathLike, optional_package, path

if TYPE_CHECKING:
    import pandas  # type: ignore

    from ._calibration import Calibration


class Answer:
    """An answer. `data` is the JSON that the command prints; print(answer) is its table.

    `shortcomings` says why it is not what was asked for; empty: it is. The command ends with exit code 1 there; `expect_supported()` raises.
    """

    _answer: _imulab.Outcome | _imulab.Calibration

    json: str = _arrays.own("_answer", "The text that the command prints with --json.")
    shortcomings: str = _arrays.own(
        "_answer", "Why the answer is not what was asked for: not converged, not determined, requirements not reached. Empty: it is."
    )
    warnings: list[str] = _arrays.own("_answer", "Findings in the data, and their consequence for the result.")

    @cached_property
    def data(self) -> dict[str, Any]:
        """The JSON as dicts and lists; null is None."""
        data: dict[str, Any] = json.loads(self.json)
        return data

    @property
    def findings(self) -> list[dict[str, Any]]:
        """Doubts, warnings and notes, each with code, severity and text, and where it has one subject, numbers, advice and place."""
        found: list[dict[str, Any]] = self.data.get("quality", self.data).get("findings", [])
        return found

    def expect_supported(self) -> None:
        """Raises Unsupported with the shortcomings where there are any."""
        if self.shortcomings:
            raise Unsupported(self.shortcomings)

    def save(self, file: PathLike) -> None:
        """Writes the JSON, whole or not at all."""
        _imulab.write_whole(path("file", file), self.json)

    def report(self, file: PathLike) -> None:
        """Writes the page: one HTML file, self-contained. Of a calibration with pictures from the recordings where it was just made from them."""
        _imulab.write_whole(path("file", file), self._answer.page())

    def __str__(self) -> str:
        return self._answer.text

    def _verdict(self) -> tuple[str, str]:
        """The verdict, where there is one, and the sentence beside it."""
        return "", ""

    def _tables(self) -> list[str]:
        """The values as HTML."""
        return []

    def _repr_html_(self) -> str:
        notes = [*self.shortcomings.splitlines(), *self.warnings]
        return "".join([_tables.headline(*self._verdict()), _tables.lines(dict.fromkeys(notes)), *self._tables()])


class Result(Answer):
    """An answer whose values are those of its JSON: result["key"]."""

    def __init__(self, outcome: _imulab.Outcome) -> None:
        self._answer: _imulab.Outcome = outcome

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def _verdict(self) -> tuple[str, str]:
        given = self.data if isinstance(self.data, dict) else {}
        return given.get("verdict", ""), given.get("headline", "") or self._answer.headline

    def __repr__(self) -> str:
        return f"<imulab.{type(self).__name__}: {self._answer.headline}>"


def in_user_units(sigmas: dict[str, float]) -> list[tuple[str, float, str]]:
    """Differences or uncertainties of coefficients by name, SI, in the units that people use: one for all of a term."""
    largest: dict[str, float] = {}
    for name, sigma in sigmas.items():
        kind = _imulab.group_of(name)
        largest[kind] = max(largest.get(kind, 0.0), abs(sigma))
    rows = []
    for name, sigma in sigmas.items():
        unit, size = _imulab.user_unit(name, largest[_imulab.group_of(name)])
        rows.append((name, sigma / size, unit))
    return rows


class Inspection(Result):
    """The contents of a recording, with the evidence."""

    def __init__(self, outcome: _imulab.Outcome, session: _imulab.Session | None, recording: _imulab.Recording | None) -> None:
        super().__init__(outcome)
        self._session, self._recording = session, recording

    @property
    def complete(self) -> bool:
        """True where nothing is open."""
        return not self.shortcomings

    @property
    def session(self) -> Session:
        """The session for it. Raises Unsupported with the open questions."""
        self.expect_supported()
        assert self._session is not None
        return Session._of(self._session)

    @property
    def recording(self) -> Recording:
        """The recording, read as that session declares it. Raises Unsupported with the open questions."""
        self.expect_supported()
        assert self._recording is not None and self._session is not None
        return Recording._of(self._recording, self._session)

    def _tables(self) -> list[str]:
        columns = [(c["name"], c["role"], c["unit"] or "", c["evidence"] or "") for c in self["columns"]]
        return [_tables.table(("column", "role", "unit", "evidence"), columns), _tables.lines(self["evidence"])]

    def plot(self) -> Any:
        """The recording's rates and forces, as a figure of matplotlib. Raises Unsupported with the open questions."""
        return self.recording.plot()


class Comparison(Result):
    """Calibrations compared, coefficient by coefficient."""

    @property
    def sigmas(self) -> dict[str, float]:
        """Each difference of two calibrations in its standard uncertainty, where both determined the coefficient."""
        return {name: row["sigmas"] for name, row in self["coefficients"].items() if row["sigmas"] is not None}

    def _comparisons(self) -> dict[str, dict[str, Any]]:
        """The coefficients of each comparison, by its title."""
        several: list[dict[str, Any]] = self.data.get("comparisons", [self.data])
        return {f"{one['b']} with {one['a']}": one["coefficients"] for one in several if "coefficients" in one}

    def _tables(self) -> list[str]:
        out = []
        for title, coefficients in self._comparisons().items():
            rows = [(n, c["a"], c["b"], *_tables.measured(c["user"]["difference"], c["user"]["standard_uncertainty"] or math.nan), c["user"]["unit"], c["sigmas"])
                    for n, c in sorted(coefficients.items(), key=lambda item: -abs(float(item[1]["sigmas"] or 0)))]
            out += [_tables.headline("", title), _tables.table(("coefficient", "a, SI", "b, SI", "difference", "u", "unit", "sigmas"), rows)]
        return out

    def plot(self) -> Any:
        """Differences in their standard uncertainties, the largest 30 of each comparison, as a figure of matplotlib."""
        return _plots.differences({title: {n: c["sigmas"] for n, c in coefficients.items() if c["sigmas"] is not None}
                                   for title, coefficients in self._comparisons().items()})


class Prediction(Result):
    """Standard uncertainties to come."""

    @property
    def sigma(self) -> dict[str, float]:
        """The standard uncertainty of each determined coefficient, SI."""
        return {name: row["closed_form"] for name, row in self["coefficients"].items()}

    def _tables(self) -> list[str]:
        considered = set(self.data.get("considered", []))
        rows = [(name, value, unit, "its prior" if name in considered else "") for name, value, unit in in_user_units(self.sigma)]
        return [_tables.table(("coefficient", "standard uncertainty", "unit", ""), rows)]

    def plot(self) -> Any:
        """The standard uncertainty of each coefficient, as a figure of matplotlib."""
        return _plots.coefficients([(name, value, math.nan, unit) for name, value, unit in in_user_units(self.sigma)], "u")


class Plan(Prediction):
    """The shortest path that meets requirements."""

    def __init__(self, outcome: _imulab.Outcome, procedure: _imulab.Session) -> None:
        super().__init__(outcome)
        self._procedure = procedure

    @property
    def procedure(self) -> Session:
        """Ready to be carried out, or simulated."""
        return Session._of(self._procedure)

    def _tables(self) -> list[str]:
        turns = [(n, t["axis"], t["angle_deg"], t["rest_s"]) for n, t in enumerate(self["turns"], 1)]
        return [_tables.table(("turn", "axis", "angle, deg", "rest after it, s"), turns), *super()._tables()]


class Mounting(NamedTuple):
    """Where an IMU is relative to another one. `matrix` (4 x 4) takes points from the axes of the first to its own."""

    first: str
    name: str
    matrix: FloatArray
    lever_arm: FloatArray
    clock_offset: float
    covariance: FloatArray
    not_shown: list[str]


class Extrinsics(Result):
    """Rotation, lever arm and clock offset between IMUs on one body."""

    @cached_property
    def mountings(self) -> list[Mounting]:
        """Each IMU but the first, relative to it: m, s. Rows of the covariance: rotation [rad, its own axes], lever arm, clock offset, drift, delay."""
        covariance, out = np.array(self["covariance"]), []
        for k, m in enumerate(self["mountings"]):
            rows = slice(9 * k, 9 * k + 9)
            arrays = [_arrays.fixed(np.array(a)) for a in (m["matrix"], m["lever_arm_m"], covariance[rows, rows])]
            out.append(Mounting(m["from"], m["to"], arrays[0], arrays[1], m["clock_offset_s"], arrays[2], m["not_shown"]))
        return out

    def _tables(self) -> list[str]:
        rows = [(m["from"], m["to"], *m["lever_arm_m"], *m["standard_uncertainty"]["lever_arm_m"], max(m["standard_uncertainty"]["rotation_deg"]),
                 m["clock_offset_s"]) for m in self["mountings"]]
        lever_arm = [f"{what} {axis}, m" for what in ("lever arm", "u") for axis in "xyz"]
        return [_tables.table(("from", "to", *lever_arm, "u of rotation, deg", "clock offset, s"), rows)]


class Noise(Result):
    """Allan deviation and noise coefficients of each axis."""

    def axis(self, name: str) -> dict[str, Any]:
        """The JSON of an axis: "gyro.x", ... Raises KeyError for an axis that is not there."""
        for axis in self["axes"]:
            if axis["name"] == name:
                found: dict[str, Any] = axis
                return found
        raise KeyError(name)

    def _tables(self) -> list[str]:
        rows = []
        for axis in self["axes"]:
            for term, c in axis.get("coefficients", {}).items():
                value = c["value"] if c["determined"] else "not determined"
                rows.append((axis["name"], term, value, c["lower"], c["upper"], axis["unit"]))
        return [_tables.table(("axis", "term", "value, SI", "95 %, from", "to", "unit of the axis"), rows)]

    def plot(self) -> Any:
        """Deviations with their 95 % bounds, the fit, and N, B and K of the worst axis, or the bound of what the log does not determine (dotted)."""
        return _plots.noise(self["axes"], self.data.get("deviation", "overlapping-allan"))


class VerifiedFile(NamedTuple):
    """A file that a calibration was made from. `state`: "unchanged", "changed" or "missing"."""

    file: str
    state: str


class Verification(Result):
    """The state of the files that a calibration was made from; true where all are unchanged."""

    @property
    def files(self) -> list[VerifiedFile]:
        """The session's, then the recordings."""
        return [VerifiedFile(f["file"], f["state"]) for f in self["files"]]

    def __bool__(self) -> bool:
        return bool(self["unchanged"])

    def _tables(self) -> list[str]:
        return [_tables.table(("file", "state"), [(f.file, f.state) for f in self.files])]


class Solution:
    """Attitude, velocity and position over time."""

    columns = ("t", "latitude_deg", "longitude_deg", "height_m", "ve", "vn", "vu", "roll_deg", "pitch_deg", "heading_deg")

    def __init__(self, solution: _imulab.Solution) -> None:
        rows = _arrays.fixed(solution.rows)
        self.t: FloatArray = rows[:, 0]  #: (N,) s
        self.latitude_deg: FloatArray = rows[:, 1]
        self.longitude_deg: FloatArray = rows[:, 2]
        self.height_m: FloatArray = rows[:, 3]
        self.velocity: FloatArray = rows[:, 4:7]  #: (N, 3) east, north, up, m/s
        self.attitude_deg: FloatArray = rows[:, 7:10]  #: (N, 3) roll, pitch, heading
        self._solution, self._rows = solution, rows

    def save(self, file: PathLike) -> None:
        """Writes it as CSV with the columns above, whole or not at all."""
        self._solution.save(path("file", file))

    def __len__(self) -> int:
        return len(self.t)

    def to_frame(self) -> pandas.DataFrame:
        """A pandas table, the time as its index."""
        pandas = optional_package("pandas", "to_frame")
        return pandas.DataFrame(self._rows[:, 1:], columns=list(self.columns[1:]), index=pandas.Index(self.t, name="t"))

    def __repr__(self) -> str:
        return f"<imulab.Solution: {len(self)} states, {self.t[0]:.6g} s to {self.t[-1]:.6g} s>"


class Navigation(Result):
    """A session navigated. `solution`: from the start, then at every sample's end."""

    def __init__(self, outcome: _imulab.Outcome, solution: _imulab.Solution) -> None:
        super().__init__(outcome)
        self.solution = Solution(solution)

    @property
    def errors(self) -> FloatArray | None:
        """(N, 10): t [s]; position east, north, up [m]; velocity [m/s]; attitude [rad]. None without a reference."""
        return self._answer.arrays.get("errors")

    @property
    def sigmas(self) -> FloatArray | None:
        """(N, 10), with aids: t [s]; one sigma of the position east, north, up [m], the velocity [m/s], the attitude [rad]."""
        return self._answer.arrays.get("sigmas")

    def _tables(self) -> list[str]:
        if "outages" in self.data:
            withheld = [(f"{o['begin_s']:g} to {o['end_s']:g}", o["horizontal_error_m"], o["sigma_m"]) for o in self["outages"]]
            known = [(name, c["value"], c["standard_uncertainty"]) for name, c in self["constants"].items()]
            tables = [_tables.table(("constant, SI", "value", "u"), known)]
            return [_tables.table(("withheld, s", "horizontal error, m", "its sigma"), withheld), *tables] if withheld else tables
        if "position_error" not in self.data:
            return []
        position, velocity, attitude = self["position_error"], self["velocity_error_mps"], self["attitude_error_arcsec"]
        rows = [("position, m", *(position[k] for k in ("east_m", "north_m", "up_m"))), ("velocity, m/s", *velocity), ("attitude, arcsec", *attitude)]
        return [_tables.table(("error at the end", "east", "north", "up"), rows)]

    def plot(self) -> Any:
        """The track, and the horizontal error where there is a reference, with aids also its sigma, as a figure of matplotlib."""
        return _plots.track(self.solution.latitude_deg, self.solution.longitude_deg, self.errors, self.sigmas)


class Budget(Result):
    """Navigation errors of a mission by source; of several grades their comparison."""

    @property
    def budgets(self) -> dict[str, dict[str, Any]]:
        """The data of each grade; of sensors without one under an empty name."""
        return {each.get("grade", ""): each for each in self.data.get("budgets", [self.data])}

    def _tables(self) -> list[str]:
        if "budgets" in self.data:
            compared = []
            for grade, each in self.budgets.items():
                total = each["total"]["position_m"]
                compared.append((grade, math.hypot(*(part[k] for part in (total["fixed"], total["sigma"]) for k in (0, 1))), each["noise"]))
            return [_tables.table(("grade", "horizontal RMS at the end, m", "noise of"), compared)]
        parts = sorted(self["sources"].items(), key=lambda item: -math.hypot(*map(float, item[1]["position_m"]["sigma"][:2])))
        rows = [(name, *part["position_m"]["sigma"], *part["velocity_mps"]["sigma"], *part["attitude_arcsec"]["sigma"])
                for name, part in [("total", self["total"]), *parts]]
        head = [f"{what} {axis}" for what in ("position, m:", "velocity, m/s:", "attitude, arcsec:") for axis in ("east", "north", "up")]
        return [_tables.table(("one sigma at the end", *head), rows)]

    def plot(self) -> Any:
        """The horizontal error over time and its largest sources, of several grades each grade's, as a figure of matplotlib."""
        if "budgets" in self.data:
            return _plots.grades({grade: each["history"] for grade, each in self.budgets.items()})
        return _plots.budget(self["history"])


@dataclass(frozen=True)
class Simulation:
    """A session simulated: what a user would have, and the truth that a calibration should find."""

    session: Session
    recordings: list[Recording]
    truth: Calibration


@dataclass(frozen=True)
class Flight:
    """A mission flown."""

    session: Session
    recording: Recording
    truth: Solution
