"""Work in parts, by the workers of any executor of concurrent.futures."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from typing import TYPE_CHECKING, Any, TypeVar

from . import _imulab

if TYPE_CHECKING:
    from ._session import Session

_Result = TypeVar("_Result")
_PARTS_A_WORKER = 4  # the last one to finish delays the result by one part


def by_parts(
    executor: Executor | None, parts: int | None, progress: Callable[[float], object] | None, work: Callable[..., _Result], *arguments: Any
) -> list[_Result]:
    """The results of `work(*arguments, "K/N")` for all parts, in their order; none without an executor."""
    if executor is None:
        if parts is not None:
            raise TypeError("parts: expected an executor, whose workers do them")
        return []
    if not callable(getattr(executor, "submit", None)):
        raise TypeError(f"executor: expected one of concurrent.futures, got {type(executor).__name__}")
    if parts is not None and (isinstance(parts, bool) or not isinstance(parts, int)):
        raise TypeError(f"parts: expected a number, got {type(parts).__name__}")
    if parts is not None and parts < 1:
        raise _imulab.Error(f"parts: {parts}; expected at least 1")
    count = parts or _PARTS_A_WORKER * (getattr(executor, "_max_workers", None) or os.cpu_count() or 1)
    futures = [executor.submit(work, *arguments, f"{k}/{count}") for k in range(1, count + 1)]
    try:
        for done, future in enumerate(as_completed(futures), 1):
            future.result()
            if progress is not None:
                progress(done / count)
    except BaseException as reason:
        for future in futures:
            future.cancel()
        if isinstance(reason, Exception):
            _settle(executor)
        raise
    return [future.result() for future in futures]


def _settle(executor: Executor) -> None:
    """Has work done behind what was cancelled: a pool of processes (Python 3.11) whose end is asked for before it has dropped that waits for ever."""
    with contextlib.suppress(Exception):
        executor.submit(int).result()


def prediction(session: Session, options: dict[str, Any], part: str) -> bytes:
    return _imulab.part_of_prediction(session._session, options, part)


def budget(mission: str, options: dict[str, Any], part: str) -> bytes:
    return _imulab.part_of_budget(mission, options, part)


def fleet(places: list[str], method: str, terms: str, station: str, operator: str, time: str, part: str) -> tuple[dict[str, Any], bytes]:
    """The counts of a part, and its store as bytes."""
    with tempfile.TemporaryDirectory() as folder:
        store = os.path.join(folder, "part.db")
        counts = _imulab.fleet_calibrate(store, places, method, terms, station, operator, time, False, None, part)
        with open(store, "rb") as file:
            return counts, file.read()


def join_fleet(store: str, parts: list[tuple[dict[str, Any], bytes]]) -> dict[str, Any]:
    """Adds the stores of all parts to a store; the counts of the whole."""
    with tempfile.TemporaryDirectory() as folder:
        files = [os.path.join(folder, f"part-{k}.db") for k in range(1, len(parts) + 1)]
        for file, (_, content) in zip(files, parts):
            with open(file, "wb") as out:
                out.write(content)
        added = _imulab.fleet_merge(store, files)
    counts = {key: sum((part[key] for part, _ in parts), type(value)()) for key, value in parts[0][0].items()}
    counts["skipped"] += counts["calibrated"] - added
    counts["calibrated"] = added
    return counts
