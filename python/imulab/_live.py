"""A calibration by hand while the IMU is being turned."""

from __future__ import annotations

import json
from typing import Any

import numpy.typing as npt

from . import _arrays, _imulab
from ._calibration import Calibration
from ._imulab import Error
from ._session import Session, Site, Table
from ._text import warn


class Live:
    """Which poses and turns are still missing, while you turn the IMU by hand: `imulab live` on rows of arrays.

        live = imulab.Live(site=imulab.Site(latitude_deg=47.4))
        for t, gyro, accel in driver:                       # a block of rows each
            for event in live.add(t, gyro, accel):          # at each new rest
                print(event.get("next", "done"))
            if live.done:
                break
        calibration = live.calibration()

    print(live) is the picture of the command.
    """

    def __init__(
        self,
        *,
        site: Site | Table,
        imu: Table | None = None,
        require: str | None = None,
        rest: float = 4.0,
        interval_s: float | None = None,
        gyro_unit: str = "",
        accel_unit: str = "",
        gyro_counts_per_unit: float = 1.0,
        accel_counts_per_unit: float = 1.0,
        gyro_increment: bool = False,
        accel_increment: bool = False,
        gyro_limits: tuple[float, float] | None = None,
        accel_limits: tuple[float, float] | None = None,
    ) -> None:
        """site, imu: as of `calibrate`. require: what ends it; without it scale factors to 500 ppm, misalignments to 120 arcsec, and offsets of
        accelerometers in SI to 500 ug. rest: seconds of every rest. interval_s, units and limits: as of `Recording.from_arrays`; increments need interval_s.

        Raises Error for declarations that are wrong, Unsupported where gravity is less certain than what is required.
        """
        if not 1 <= rest <= 600:
            raise Error(f"rest: {rest}; expected 1 to 600")
        self._live = _imulab.Live(
            Session(imu=imu, site=site)._session,
            require,
            rest,
            interval_s,
            _arrays.triad_options("gyro", gyro_unit, gyro_counts_per_unit, gyro_increment, gyro_limits),
            _arrays.triad_options("accel", accel_unit, accel_counts_per_unit, accel_increment, accel_limits),
        )

    def add(self, t: npt.ArrayLike, gyro: npt.ArrayLike, accel: npt.ArrayLike, *, time_unit: str = "s") -> list[dict[str, Any]]:
        """Adds rows, one or many, which follow those before; arrays as of `Recording.from_arrays`.

        Returns an event for each rest that became long enough, as `imulab live --json` prints it: "time_s", "rests" (how many), "up", "requirements",
        "done", "next" (a turn), "problem". Raises Error for rows that are wrong, none of which is then used.
        """
        times = _arrays.stamps(t, time_unit)
        count = times.shape[0]
        return [json.loads(event) for event in self._live.add(times, _arrays.rows("gyro", gyro, count), _arrays.rows("accel", accel, count))]

    done: bool = _arrays.own("_live", "True where everything required was reached at the last rest.")
    missing: str = _arrays.own("_live", "Requirements not reached at the last rest, and the turn that helps most. Empty: it is done.")
    resting_s: float | None = _arrays.own("_live", "For how long the IMU has been at rest; None: it moves.")

    def calibration(self) -> Calibration:
        """The calibration of all rows so far; `shortcomings` says what is not reached. Raises Unsupported where there is none yet, and says why."""
        calibration = Calibration(self._live.calibration())
        warn(calibration.warnings)
        return calibration

    def __len__(self) -> int:
        """Rows so far."""
        return self._live.samples

    def __str__(self) -> str:
        return self._live.picture

    def __repr__(self) -> str:
        return f"<imulab.Live: {len(self)} rows, {'done' if self.done else 'not done'}>"
