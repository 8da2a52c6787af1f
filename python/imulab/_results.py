"""Answers: the command's JSON as data, its table as text, its page, and what is missing."""

from __future__ import annotations

import html
import json
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _imulab
from ._arrays import FloatArray
from ._imulab import Unsupported
from ._recording import Recording
from ._session import Session
from ._text import PathLike, optional_package, path

if TYPE_CHECKING:
    import pandas  # type: ignore[import]


class Answer:
    """An answer. `data` is the JSON that the command prints; print(answer) is its table.

    `shortcomings` says why it is not what was asked for; empty: it is. The command ends with exit code 1 there; `expect_supported()` raises.
    """

    _answer: _imulab.Outcome | _imulab.Calibration

    @property
    def json(self) -> str:
        """The text that the command prints with --json."""
        return self._answer.json

    @cached_property
    def data(self) -> dict[str, Any]:
        """The JSON as dicts and lists; null is None."""
        data: dict[str, Any] = json.loads(self.json)
        return data

    @property
    def shortcomings(self) -> str:
        """Why the answer is not what was asked for: not converged, not determined, requirements not reached. Empty: it is."""
        return self._answer.shortcomings

    @property
    def warnings(self) -> list[str]:
        """Findings in the data, and their consequence for the result."""
        return self._answer.warnings

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

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


class Result(Answer):
    """An answer whose values are those of its JSON: result["key"]."""

    def __init__(self, outcome: _imulab.Outcome) -> None:
        self._answer: _imulab.Outcome = outcome

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __repr__(self) -> str:
        return f"<imulab.{type(self).__name__}: {self._answer.headline}>"


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


class Comparison(Result):
    """Calibrations compared, coefficient by coefficient."""

    @property
    def sigmas(self) -> dict[str, float]:
        """Each difference of two calibrations in its standard uncertainty, where both determined the coefficient."""
        return {name: row["sigmas"] for name, row in self["coefficients"].items() if row["sigmas"] is not None}


class Prediction(Result):
    """Standard uncertainties to come."""

    @property
    def sigma(self) -> dict[str, float]:
        """The standard uncertainty of each determined coefficient, SI."""
        return {name: row["closed_form"] for name, row in self["coefficients"].items()}


class Plan(Prediction):
    """The shortest path that meets requirements."""

    def __init__(self, outcome: _imulab.Outcome, procedure: _imulab.Session) -> None:
        super().__init__(outcome)
        self._procedure = procedure

    @property
    def procedure(self) -> Session:
        """Ready to be carried out, or simulated."""
        return Session._of(self._procedure)


class Noise(Result):
    """Allan deviation and noise coefficients of each axis."""

    def axis(self, name: str) -> dict[str, Any]:
        """The JSON of an axis: "gyro.x", ... Raises KeyError for an axis that is not there."""
        for axis in self["axes"]:
            if axis["name"] == name:
                found: dict[str, Any] = axis
                return found
        raise KeyError(name)

    def plot(self) -> Any:
        """Deviations with their 95 % bounds, as a figure of matplotlib."""
        pyplot = optional_package("matplotlib.pyplot", "plot")
        figure, axes = pyplot.subplots(1, 2, layout="constrained", figsize=(10, 4))
        for axis in self["axes"]:
            place = axes[0] if axis["name"].startswith("gyro") else axes[1]
            place.fill_between(axis["tau"], axis["lower"], axis["upper"], alpha=0.2)
            place.loglog(axis["tau"], axis["deviation"], label=axis["name"])
            place.set_xlabel("averaging time, s")
            place.set_ylabel(f"deviation, {axis['unit']}")
            place.legend()
        return figure


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


class Solution:
    """Attitude, velocity and position over time."""

    columns = ("t", "latitude_deg", "longitude_deg", "height_m", "ve", "vn", "vu", "roll_deg", "pitch_deg", "heading_deg")

    def __init__(self, solution: _imulab.Solution) -> None:
        rows = solution.rows
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

    def plot(self) -> Any:
        """The track, as a figure of matplotlib."""
        pyplot = optional_package("matplotlib.pyplot", "plot")
        figure, axis = pyplot.subplots(layout="constrained")
        axis.plot(self.solution.longitude_deg, self.solution.latitude_deg)
        axis.set_xlabel("longitude, deg")
        axis.set_ylabel("latitude, deg")
        return figure


class Budget(Result):
    """Navigation errors of a mission by source."""
