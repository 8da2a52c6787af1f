"""Sessions: recordings with their IMU, site, rig and steps. A procedure is a session without recordings."""

from __future__ import annotations

import html
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from . import _imulab
from ._arrays import own
from ._text import PathLike, path, toml

Table = Mapping[str, Any]


@dataclass(frozen=True)
class Site:
    """Where the recording was made: latitude and height give normal gravity, or gravity as it was measured. One of both is needed."""

    latitude_deg: float | None = None
    longitude_deg: float | None = None
    height_m: float | None = None
    gravity_mps2: float | None = None
    gravity_sigma_mps2: float | None = None


class Session:
    """The declarations of recordings: IMU, site, rigs, steps.

    Its tables are those of session.toml (docs/reference/session.md), as dicts:

        Session(imu={"name": "IMU 7"}, site=Site(latitude_deg=47.4), rig={"kind": "turntable"}, step=[{"kind": "hold", "duration_s": 60}])

    Raises Error that names the line and the key of what is wrong, where lines are those of `text`.
    """

    def __init__(
        self,
        *,
        imu: Table | None = None,
        site: Site | Table | None = None,
        rig: Table | Sequence[Table] | None = None,
        recording: Table | Sequence[Table] | None = None,
        step: Sequence[Table] | None = None,
        initial: Table | None = None,
        truth: Table | None = None,
        reference: Sequence[Table] | None = None,
        aid: Sequence[Table] | None = None,
        file: PathLike = "session.toml",
    ) -> None:
        single = {"imu": imu, "site": asdict(site) if isinstance(site, Site) else site, "initial": initial, "truth": truth}
        for key, table in single.items():
            if table is not None and not isinstance(table, Mapping):
                raise TypeError(f"{key}: expected a dict, got {type(table).__name__}")
        several = {"rig": rig, "recording": recording, "step": step, "reference": reference, "aid": aid}
        for key, value in several.items():
            if isinstance(value, Mapping) and key in ("rig", "recording"):
                several[key] = [value]
            elif value is not None and (isinstance(value, str) or not isinstance(value, Sequence) or not all(isinstance(v, Mapping) for v in value)):
                raise TypeError(f"{key}: expected dicts, got {type(value).__name__}")
        tables: dict[str, Any] = {"format": "imulab.session/1", **single, **several}
        self._session = _imulab.Session.parse(toml(tables), path("file", file))

    @classmethod
    def _of(cls, session: _imulab.Session) -> Session:
        made = cls.__new__(cls)
        made._session = session
        return made

    text: str = own("_session", "As session.toml.")
    procedure_text: str = own("_session", "session.toml with durations in place of times: the form that a procedure's author edits.")
    file: str = own("_session", "The TOML file; the files of the recordings are beside it.")
    imu: str = own("_session", "The name of the IMU.")
    gravity: float = own("_session", "m/s^2: given, or normal gravity. Raises Error where neither it nor the latitude is known.")
    recordings: list[str] = own("_session", "Files of the recordings, as the session names them.")

    @property
    def tables(self) -> dict[str, Any]:
        """As dicts, with the keys of session.toml. Changed, they make another session: Session(**tables) without "format"."""
        return tomllib.loads(self.text)

    def save(self, file: PathLike) -> None:
        """Writes session.toml, whole or not at all."""
        self._session.save(path("file", file))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Session) and self._session == other._session

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<imulab.Session {self.imu!r}: {', '.join(self.recordings) or 'a procedure without recordings'}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>"


def read_session(folder: PathLike) -> Session:
    """Reads a session or a procedure: a folder with session.toml, or the file. Raises Error with file, line and key."""
    return Session._of(_imulab.Session.read(path("folder", folder)))


def procedure(name: str, *, seed: int = 1, **options: float) -> Session:
    """A standard procedure: "handheld", "six-position", "ferraris", "two-axis", "zhang-24", "cheng-path", "dai-unit".

    options: poses, rest (s), rate_hz of handheld; rest, table_arcsec, rate_hz, turns of those on a table; record (s), rate_hz of dai-unit.
    """
    return Session._of(_imulab.procedure(name, options, seed))
