"""Data of numpy and others as the arrays of float64 that the library reads, without a copy where they are such arrays already."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from ._imulab import Error

FloatArray = npt.NDArray[np.float64]
Array = TypeVar("Array", bound=npt.NDArray[Any])

_NANOSECONDS = {"ns": 1, "us": 1_000, "ms": 1_000_000, "s": 1_000_000_000}


def fixed(array: Array) -> Array:
    """The same array, read-only: a change of a copy would be silently lost."""
    array.flags.writeable = False
    return array


class _Own:
    """What the extension's object has under the same name: an array read-only, and the same at every access."""

    def __init__(self, holder: str, doc: str) -> None:
        self._holder, self.__doc__ = holder, doc

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: Any, owner: type | None = None) -> Any:
        if instance is None:
            return self
        if self._name in instance.__dict__:
            return instance.__dict__[self._name]
        value = getattr(getattr(instance, self._holder), self._name)
        if isinstance(value, np.ndarray):
            instance.__dict__[self._name] = fixed(value)
        return value

    def __set__(self, instance: Any, value: Any) -> None:
        raise AttributeError(f"{self._name}: does not change")


def own(holder: str, doc: str) -> Any:
    """A property of a class whose objects keep that of the extension as `holder`."""
    return _Own(holder, doc)


def _kind(value: Any) -> str:
    return f"an array of {value.dtype}" if isinstance(value, np.ndarray) else f"a {type(value).__name__}"


def numbers(name: str, value: Any) -> FloatArray:
    """Real numbers as float64. Raises TypeError for anything else, also for booleans and complex numbers."""
    if isinstance(value, np.ma.MaskedArray):
        missing, value = np.ma.getmaskarray(value), np.ma.getdata(value)  # type: ignore[no-untyped-call]
        value = np.where(missing, np.nan, value) if value.dtype.kind in "fiu" else value
    try:
        array = np.asarray(value)
    except ValueError as e:
        raise TypeError(f"{name}: expected numbers in rows of one length, got {_kind(value)}") from e
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: expected real numbers, got {_kind(value)}")
    return array.astype(np.float64, copy=False)


def column(name: str, value: Any) -> FloatArray:
    """(N,). Raises Error for another shape."""
    array = numbers(name, value)
    if array.ndim != 1:
        raise Error(f"{name}: shape {array.shape}; expected (N,)")
    return array


def rows(name: str, value: Any, count: int | None = None) -> FloatArray:
    """(N, 3), a row a sample; N = count where that is given. Raises Error for another shape."""
    array = numbers(name, value)
    if array.ndim != 2 or array.shape[1] != 3:
        raise Error(f"{name}: shape {array.shape}; expected (N, 3), a row a sample")
    if count is not None and array.shape[0] != count:
        raise Error(f"{name}: {array.shape[0]} samples; expected {count}")
    return array


def thermal(name: str, value: Any, count: int) -> FloatArray | None:
    """None, (N,) or (N, 3). Raises Error for another shape."""
    if value is None:
        return None
    array = numbers(name, value)
    if array.shape not in ((count,), (count, 3)):
        raise Error(f"{name}: shape {array.shape}; expected ({count},) or ({count}, 3)")
    return array


def triad_options(
    triad: str, unit: str, per_unit: float, increment: bool, limits: tuple[float, float] | None, temperature: FloatArray | None = None
) -> dict[str, Any]:
    """The declaration of a triad's readings. Raises TypeError or Error for what is no unit or no limits."""
    if not isinstance(unit, str):
        raise TypeError(f"{triad}_unit: expected a name, got {type(unit).__name__}")
    if limits is not None and np.shape(numbers(f"{triad}_limits", limits)) != (2,):
        raise Error(f"{triad}_limits: expected two numbers, the least and the largest reading")
    return {"unit": unit, "counts_per_unit": per_unit, "increment": increment, "limits": limits, "temperature": temperature}


def stamps(t: Any, unit: str) -> FloatArray | npt.NDArray[np.int64]:
    """Seconds as float64, or exact nanoseconds as int64 where `t` is of integers, datetime64 (UTC; of pandas also with a time zone) or timedelta64."""
    if unit not in _NANOSECONDS:
        raise Error(f"time_unit: {unit!r}; expected one of {', '.join(_NANOSECONDS)}")
    zoned = str(getattr(t, "dtype", "")).startswith("datetime64[")  # without the type, pandas gives objects for times with a zone
    array = np.asarray(t, dtype="datetime64[ns]") if zoned else np.asarray(t)
    if array.dtype.kind in "Mm":
        if np.isnat(array).any():
            raise Error("t: has stamps that are not a time (NaT)")
        nanoseconds = array.astype(f"{'datetime64' if array.dtype.kind == 'M' else 'timedelta64'}[ns]").astype(np.int64)
    elif array.dtype.kind in "iu":
        factor = _NANOSECONDS[unit]
        limit = np.iinfo(np.int64).max // factor
        if array.size and (int(array.max()) > limit or int(array.min()) < -limit):
            raise Error(f"t: up to {int(array.max())} {unit}; expected stamps that fit into 64 bits of nanoseconds")
        nanoseconds = array.astype(np.int64) * factor
    else:
        seconds = column("t", t)
        return seconds if unit == "s" else seconds * (_NANOSECONDS[unit] * 1e-9)
    if nanoseconds.ndim != 1:
        raise Error(f"t: shape {nanoseconds.shape}; expected (N,)")
    return nanoseconds
