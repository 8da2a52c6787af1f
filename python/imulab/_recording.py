"""Recordings: samples of one IMU on one clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _arrays, _imulab, _plots
from ._arrays import FloatArray, own
from ._imulab import Error
from ._text import PathLike, optional_package, path

if TYPE_CHECKING:
    import pandas  # type: ignore


class Recording:
    """Samples of one IMU on one clock, in SI, or in counts where their unit is "count".

    A sample belongs to the interval that ends at its stamp. Make one with `Recording.from_arrays`, `read_recording` or `simulate`. It does not
    change: its arrays are read-only, and the same at every access.
    """

    def __init__(self, recording: _imulab.Recording, temperature_units: tuple[str | None, str | None] = (None, None)) -> None:
        if not isinstance(recording, _imulab.Recording):
            raise TypeError("expected Recording.from_arrays(t, gyro, accel) or read_recording(file)")
        self._recording = recording
        self.temperature_units = temperature_units  #: of the gyros' and the accelerometers' thermal readings; None: not known, or none

    @classmethod
    def _of(cls, recording: _imulab.Recording, session: _imulab.Session) -> Recording:
        """One of a session, which declares the unit of its thermal readings."""
        return cls(recording, _imulab.thermal_units(session, recording.name))

    @classmethod
    def from_arrays(
        cls,
        t: npt.ArrayLike,
        gyro: npt.ArrayLike,
        accel: npt.ArrayLike,
        *,
        temperature: npt.ArrayLike | None = None,
        gyro_temperature: npt.ArrayLike | None = None,
        accel_temperature: npt.ArrayLike | None = None,
        name: str = "recording",
        time_unit: str = "s",
        interval_s: float | None = None,
        gyro_unit: str = "",
        accel_unit: str = "",
        gyro_counts_per_unit: float = 1.0,
        accel_counts_per_unit: float = 1.0,
        gyro_increment: bool = False,
        accel_increment: bool = False,
        gyro_limits: tuple[float, float] | None = None,
        accel_limits: tuple[float, float] | None = None,
    ) -> Recording:
        """A recording from arrays in memory, which are copied once.

        t: (N,) ends of the samples' intervals: seconds as floats; integers of `time_unit` ("s", "ms", "us", "ns"), datetime64 or timedelta64 keep every digit.
        gyro: (N, 3) angular rates, rad/s or `gyro_unit`: "deg/s", "deg/h", "count"; with `gyro_increment` integrals over the interval ("rad").
        accel: (N, 3) specific forces, m/s^2 or `accel_unit`: "g", "mg", "count"; with `accel_increment` "m/s".
        temperature: (N,) or (N, 3) of both triads, degC; or of each by `gyro_temperature` and `accel_temperature`.
        gyro_counts_per_unit: the array has counts, so many of them are one unit. gyro_limits: readings at or beyond are saturated.
        interval_s: nominal; without it the median difference of the stamps.

        Raises Error for shapes that do not agree, NaN, stamps that go back, unknown units; TypeError for what is not numbers.
        """
        times = _arrays.stamps(t, time_unit)
        count = times.shape[0]
        rates = _arrays.rows("gyro", gyro, count)
        forces = _arrays.rows("accel", accel, count)

        def thermal(triad: str, own: Any) -> FloatArray | None:
            return _arrays.thermal(f"{triad}_temperature", temperature if own is None else own, count)

        units = ("degC" if temperature is not None or gyro_temperature is not None else None,
                 "degC" if temperature is not None or accel_temperature is not None else None)
        return cls(
            _imulab.Recording(
                times,
                rates,
                forces,
                name,
                interval_s,
                _arrays.triad_options("gyro", gyro_unit, gyro_counts_per_unit, gyro_increment, gyro_limits, thermal("gyro", gyro_temperature)),
                _arrays.triad_options("accel", accel_unit, accel_counts_per_unit, accel_increment, accel_limits, thermal("accel", accel_temperature)),
            ),
            units,
        )

    def __len__(self) -> int:
        return len(self._recording)

    name: str = own("_recording", "The name of its file, or as it was given.")
    interval_s: float = own("_recording", "Nominal interval, s.")
    t: FloatArray = own("_recording", "(N,) ends of the samples' intervals, s.")
    time_ns: npt.NDArray[np.int64] = own("_recording", "(N,) the same, exact, ns.")
    gyro: FloatArray = own("_recording", "(N, 3) angular rates, rad/s, or counts.")
    accel: FloatArray = own("_recording", "(N, 3) specific forces, m/s^2, or counts.")
    gyro_temperature: FloatArray | None = own("_recording", "(N, 3) thermal readings of the gyros, or None.")
    accel_temperature: FloatArray | None = own("_recording", "(N, 3) thermal readings of the accelerometers, or None.")
    gyro_unit: str = own("_recording", '"rad/s" or "count".')
    accel_unit: str = own("_recording", '"m/s^2" or "count".')
    gaps: npt.NDArray[np.int64] = own("_recording", "Indices of samples before which time is missing.")
    saturated: npt.NDArray[np.int64] = own("_recording", "Indices of samples with a reading at a limit.")

    def save(self, file: PathLike) -> None:
        """Writes t,gx,gy,gz,ax,ay,az as CSV, whole or not at all."""
        self._recording.save(path("file", file))

    def to_frame(self) -> pandas.DataFrame:
        """A pandas table with the columns of `save`, the time as its index."""
        pandas = optional_package("pandas", "to_frame")
        columns = {n: v for n, v in zip(("gx", "gy", "gz"), self.gyro.T)} | {n: v for n, v in zip(("ax", "ay", "az"), self.accel.T)}
        return pandas.DataFrame(columns, index=pandas.Index(self.t, name="t"))

    def plot(self) -> Any:
        """Rates and forces over the time from the first sample, as a figure of matplotlib."""
        return _plots.recording(self.t, self.gyro, self.accel, (self.gyro_unit, self.accel_unit))

    def __reduce__(self) -> tuple[Any, ...]:
        return Recording, (self._recording, self.temperature_units)  # without the arrays of earlier accesses

    def __repr__(self) -> str:
        size = len(self)
        duration = (int(self.time_ns[-1]) - int(self.time_ns[0])) * 1e-9 + self.interval_s if size else 0.0
        return f"<imulab.Recording {self.name!r}: {size} samples, {duration:.6g} s at {1 / self.interval_s:.6g} Hz, {self.gyro_unit}, {self.accel_unit}>"
