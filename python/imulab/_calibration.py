"""Calibrations: values, their uncertainties, and what they do to readings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _arrays, _imulab, _plots, _tables
from ._arrays import FloatArray, own
from ._imulab import Error
from ._results import Answer
from ._text import PathLike, optional_package, options, path, warn

if TYPE_CHECKING:
    import pandas  # type: ignore

    from ._recording import Recording
    from ._results import Noise


class Coefficient(NamedTuple):
    """One coefficient, SI; `sigma` is None where it was not determined or is fixed by the frame."""

    name: str
    value: float
    sigma: float | None
    unit: str


@dataclass(frozen=True, eq=False)
class Terms:
    """One number for each coefficient of a triad, as arrays in SI; rows are axes of the output, columns those of the input.

    Of values, and of their standard uncertainties, which are NaN where a coefficient was not determined or is fixed by the frame.
    """

    offset: FloatArray  #: (3,)
    matrix: FloatArray  #: (3, 3)
    quadratic: FloatArray  #: (3,)
    cubic: FloatArray  #: (3,)
    thermal: FloatArray  #: (3, 3): linear, quadratic and cubic, a row an axis
    matrix_thermal1: FloatArray  #: (3, 3)
    matrix_thermal2: FloatArray  #: (3, 3)
    g_sensitivity: FloatArray | None = None  #: (3, 3) of gyros; None of accelerometers
    lever_arm: FloatArray | None = None  #: (3, 3) of accelerometers, row i that of accelerometer i; None of gyros


@dataclass(frozen=True, eq=False)
class Triad(Terms):
    """The coefficients of the gyros or the accelerometers: offset + matrix @ raw + ..., and `sigma`, their standard uncertainties in the same form."""

    sigma: Terms = field(kw_only=True)


_SHAPES = {"offset": (3,), "quadratic": (3,), "cubic": (3,)}  # others: (3, 3)


def _arrays_of(numbers: dict[str, float | None], triad: str) -> dict[str, FloatArray]:
    """The numbers named "gyro.matrix.xy" and "gyro.thermal.x1" in read-only arrays by term."""
    terms: dict[str, FloatArray] = {}
    for name, value in numbers.items():
        own, term, element = name.split(".")
        if own == triad:
            place = tuple("xyz".index(c) if c in "xyz" else int(c) - 1 for c in element)
            terms.setdefault(term, np.full(_SHAPES.get(term, (3, 3)), np.nan))[place] = np.nan if value is None else value
    return {term: _arrays.fixed(array) for term, array in terms.items()}


class Calibration(Answer):
    """The model of an IMU with the standard uncertainty of every coefficient.

    From `calibrate`, `read_calibration` or `import_calibration`. It does not change: its arrays are read-only.
    """

    def __init__(self, calibration: _imulab.Calibration, name: str = "") -> None:
        if not isinstance(calibration, _imulab.Calibration):
            raise TypeError("expected read_calibration(file) or calibrate(data, method=...)")
        self._answer: _imulab.Calibration = calibration
        self.name = name or calibration.imu or calibration.method  #: of its file or IMU, for comparisons

    # What it says

    @cached_property
    def coefficients(self) -> list[Coefficient]:
        """All of the model, in the order of files."""
        return [Coefficient(n, v, None if np.isnan(s) else s, unit) for n, v, s, unit in self._answer.coefficients]

    @property
    def values(self) -> dict[str, float]:
        """By name, SI: values["gyro.matrix.xy"]."""
        return {c.name: c.value for c in self.coefficients}

    @property
    def sigma(self) -> dict[str, float | None]:
        """Standard uncertainties by name, SI; None where the data did not determine the coefficient or the frame fixes it."""
        return {c.name: c.sigma for c in self.coefficients}

    def __getitem__(self, name: str) -> float:
        """The value of a coefficient, SI: calibration["gyro.matrix.xy"]."""
        return self.values[name]

    def __iter__(self) -> Iterator[str]:
        """The names of the coefficients."""
        return iter(self.values)

    @cached_property
    def gyro(self) -> Triad:
        """The gyros' coefficients as arrays: gyro.offset, gyro.matrix, ...; their uncertainties gyro.sigma.offset, ..."""
        return self._triad("gyro")

    @cached_property
    def accel(self) -> Triad:
        """The accelerometers' coefficients as arrays: accel.offset, accel.matrix, ...; their uncertainties accel.sigma.offset, ..."""
        return self._triad("accel")

    def _triad(self, name: str) -> Triad:
        return Triad(**_arrays_of({**self.values}, name), sigma=Terms(**_arrays_of(self.sigma, name)))

    estimated: list[str] = own("_answer", "Names of the coefficients in `covariance`.")
    covariance: FloatArray = own("_answer", "(M, M), SI, in the order of `estimated`.")
    constant_covariance: FloatArray = own(
        "_answer", "The part of `covariance` that the same IMU brings again at its next calibration; (0, 0) where it is zero."
    )
    verdict: str = own("_answer", '"good" or "doubtful".')
    because: list[str] = own("_answer", "Why it is doubtful.")
    method: str = own("_answer", "The method that made it.")
    imu: str = own("_answer", "The name of the IMU.")
    gyro_unit: str = own("_answer", 'The unit of rates that `apply` takes: "rad/s" or "count".')
    accel_unit: str = own("_answer", 'The unit of forces that `apply` takes: "m/s^2" or "count".')
    details: str = own("_answer", "Every estimated coefficient in SI and in user units, what was used, and the tests of optional terms.")

    @cached_property
    def curves(self) -> dict[str, FloatArray]:
        """Convergence of the method hybrid: "t" [s], and of each coefficient its residual over time and, as "NAME.sigma", its standard uncertainty."""
        return {name: _arrays.fixed(curve) for name, curve in self._answer.curves.items()}

    def _verdict(self) -> tuple[str, str]:
        return self.verdict, f"{self.imu or 'an unnamed IMU'}{f', method {self.method}' if self.method else ''}"

    def _tables(self) -> list[str]:
        known = {name: value for name, value, _, _ in self._answer.coefficients}
        rows = [(name, *_tables.measured(value, sigma), unit)
                for name, value, sigma, unit in self._answer.in_user_units if known[name] != 0 or not math.isnan(sigma)]
        return [_tables.lines(self.because), _tables.table(("coefficient", "value", "standard uncertainty", "unit"), rows)]

    def plot(self) -> Any:
        """The coefficients with twice their standard uncertainties, as a figure of matplotlib."""
        rows = self._answer.in_user_units
        return _plots.coefficients([(n, v, 2 * s, unit) for n, v, s, unit in rows if not math.isnan(s)] or rows, "value")

    def to_frame(self) -> pandas.DataFrame:
        """The coefficients as a pandas table, the name as its index."""
        pandas = optional_package("pandas", "to_frame")
        return pandas.DataFrame(self.coefficients).set_index("name")

    # What it does

    def apply(
        self,
        gyro: npt.ArrayLike,
        accel: npt.ArrayLike,
        temperature: npt.ArrayLike | None = None,
        *,
        gyro_temperature: npt.ArrayLike | None = None,
        accel_temperature: npt.ArrayLike | None = None,
        allow_undetermined: bool = False,
        out: tuple[FloatArray, FloatArray] | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Raw readings to angular rates [rad/s] and specific forces [m/s^2].

        gyro, accel: (N, 3), or (3,) for one sample, in `gyro_unit` and `accel_unit`; any strides, float64 without a copy.
        temperature: (N,) or (N, 3) of both triads, or of each; needed where the calibration has thermal terms.
        out: two arrays to write to, (N, 3) of float64, C-contiguous; the inputs themselves may be given.

        Raises Unsupported where the data did not determine all of the offsets and matrices, unless that is allowed. NaN gives NaN.
        """
        self._expect_usable(allow_undetermined)
        rates = _arrays.numbers("gyro", gyro)
        single = rates.ndim == 1
        if single:
            rates = rates[np.newaxis]
        rates = _arrays.rows("gyro", rates)
        forces = _arrays.numbers("accel", accel)
        forces = _arrays.rows("accel", forces[np.newaxis] if single and forces.ndim == 1 else forces, len(rates))
        count = len(rates)

        def readings(name: str, own: npt.ArrayLike | None) -> FloatArray | None:
            value = temperature if own is None else own
            if isinstance(value, (int, float, np.number)):  # one for all samples
                value = np.full(count, value)
            return _arrays.thermal(name, value, count)

        targets = out if out is not None else (np.empty((count, 3)), np.empty((count, 3)))
        given = (rates, forces, readings("gyro_temperature", gyro_temperature), readings("accel_temperature", accel_temperature))
        self._check_out(targets, count, given)
        self._answer.apply(*given, *targets)
        return (targets[0][0], targets[1][0]) if single and out is None else targets

    @staticmethod
    def _check_out(targets: tuple[FloatArray, FloatArray], count: int, given: Sequence[FloatArray | None]) -> None:
        if not isinstance(targets, tuple) or len(targets) != 2:
            raise TypeError("out: expected two arrays, (rate, force)")
        for name, target in zip(("rate", "force"), targets):
            if not isinstance(target, np.ndarray) or target.dtype != np.float64 or not target.dtype.isnative:
                raise TypeError(f"out: {name}: expected an array of float64")
            if target.shape != (count, 3) or not target.flags.c_contiguous or not target.flags.writeable:
                raise Error(f"out: {name}: expected shape ({count}, 3), C-contiguous and writeable")
        if np.shares_memory(*targets):
            raise Error("out: rate and force share memory; expected two arrays")
        for target in targets:  # a part would be read after it was written
            for array in given:
                same = array is not None and array.ctypes.data == target.ctypes.data and array.strides == target.strides
                if array is not None and not same and np.may_share_memory(array, target):
                    raise Error("out: shares memory with a part of the input; expected the input itself, or other memory")

    def _expect_usable(self, allowed: bool) -> None:
        warn(self._answer.expect_usable(self.name, allowed))

    def _expect_thermal_units(self, recording: Recording) -> None:
        """Temperatures in another unit would be taken for the calibration's."""
        for triad, own, given in zip(("gyro", "accelerometer"), self._answer.thermal_units, recording.temperature_units):
            if own is not None and given is not None and own != given:
                raise Error(f"{recording.name}: the {triad} temperature is in {given}; expected {own} as in the calibration")

    # Where it goes

    @options("export")
    def to(self, target: str, *, noise: Noise | None = None, allow_undetermined: bool = False, **options: Any) -> str:
        """The file for another program, as text: "kalibr", "openvins", "ros", "c-header", ... (`export_targets`). What it cannot hold is warned of.

        noise: for targets that hold noise; without it they have the white noise of the calibration's rests, and a warning says what that means.
        """
        self._expect_usable(allow_undetermined)
        if noise is not None and not hasattr(noise, "json"):
            raise TypeError(f"noise: expected the answer of imulab.noise, got {type(noise).__name__}")
        text, notes = self._answer.exported("" if noise is None else noise.json, {**options, "target": target})
        warn(notes)
        return text

    def export(self, target: str, file: PathLike | None = None, **options: Any) -> str:
        """Gives the text of `to`, and writes it to a file where one is named, whole or not at all."""
        text = self.to(target, **options)
        if file is not None:
            _imulab.write_whole(path("file", file), text)
        return text

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self.json, self.name)

    def __repr__(self) -> str:
        by = f" by {self.method}" if self.method else ""
        return f"<imulab.Calibration {self.imu!r}{by}: {self.verdict or 'no verdict'}, {len(self.estimated)} coefficients>"


def _unpickled(text: str, name: str) -> Calibration:
    return Calibration(_imulab.Calibration.parse(text, name), name)


def read_calibration(file: PathLike) -> Calibration:
    """Reads calibration.json or truth.json. Raises Error with file and field."""
    name = path("file", file)
    return Calibration(_imulab.Calibration.read(name), name)


def import_calibration(file: PathLike, *, gyro_file: PathLike | None = None, instance: int = 0, raw: str = "") -> Calibration:
    """Another program's calibration, recognized by its content; it states no uncertainties.

    gyro_file: for formats with one triad a file. instance: of several IMUs. raw: the readings' unit, "si" or "count"; empty: as the file says.
    """
    name = path("file", file)
    imported, notes = _imulab.Calibration.imported(name, None if gyro_file is None else path("gyro_file", gyro_file), instance, raw)
    warn(notes)
    return Calibration(imported, name)

