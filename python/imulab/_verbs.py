"""The verbs of the command, on values."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arrays, _imulab, _parts
from ._arrays import FloatArray
from ._calibration import Calibration
from ._fleet import Fleet
from ._imulab import Error
from ._recording import Recording
from ._results import Budget, Comparison, Extrinsics, Flight, Inspection, Navigation, Noise, Plan, Prediction, Simulation, Solution, Verification
from ._session import Session, Site, Table, read_session
from ._text import PathLike, options as _options, path, warn

Progress = Callable[[float], object]


Data = Session | Recording | Simulation | Sequence[Recording] | PathLike


def _callback(progress: Progress | None) -> Progress | None:
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: expected a function of one number, got {type(progress).__name__}")
    return progress


def _is_session(place: str) -> bool:
    """A folder without session.toml may be a recording: that of a bag, or of texts."""
    return os.path.exists(os.path.join(place, "session.toml")) or place.endswith(".toml")


def _expect(name: str, value: Any, *kinds: type) -> None:
    if not isinstance(value, kinds):
        expected = " or ".join(kind.__name__ for kind in kinds if kind is not type(None))
        raise TypeError(f"{name}: expected a {expected}, got {type(value).__name__}")


def _declared(
    data: Data, site: Site | Table | None, imu: Table | None, topics: Sequence[str] = (), needs_gravity: bool = True
) -> tuple[Session, list[Recording] | None]:
    """The session of what was given, and its recordings where they are in memory."""
    own = site is not None or imu is not None
    if isinstance(data, Recording):
        data = [data]
    if isinstance(data, Sequence) and not isinstance(data, str):
        if not data or not all(isinstance(r, Recording) for r in data):
            raise TypeError("data: expected recordings")
        return Session(imu=imu, site=site), list(data)
    if own:
        raise Error("site and imu belong to recordings; a session and a file declare their own")
    if isinstance(data, Simulation):
        return data.session, data.recordings
    if isinstance(data, Session):
        session = data
    else:
        place = path("data", data)
        session = read_session(place) if _is_session(place) else Session._of(_imulab.session_of_recording(place, list(topics)))
    gravity = session._session.assumed_gravity
    if gravity and needs_gravity:
        name = session._session.file or "session"
        warn([f"{name}: assumed: {gravity}; declare the place: inspect(files, declare={{'latitude_deg': '47.4'}}), or site of the session"])
    return session, None


def _one_recording(
    data: Data, site: Site | Table | None, chosen: str, topics: Sequence[str] = (), needs_gravity: bool = True
) -> tuple[Session, Recording]:
    session, recordings = _declared(data, site, None, topics, needs_gravity)
    if recordings is None:
        found, notes = _imulab.read_recording(session._session, _imulab.choose_recording(session._session, chosen))
        warn(notes)
        return session, Recording._of(found, session._session)
    named = [r for r in recordings if r.name == chosen] if chosen else recordings
    if len(named) != 1:
        raise Error(f"recording: {chosen!r}; expected one of {', '.join(r.name for r in recordings)}")
    return session, named[0]


def _told(outcome: _imulab.Outcome) -> _imulab.Outcome:
    warn(outcome.warnings)
    return outcome


def _store(prior: Fleet | PathLike | None) -> str:
    """The file of a fleet that is a prior; empty: none."""
    if prior is None:
        return ""
    return prior.store if isinstance(prior, Fleet) else path("prior", prior)


def inspect(*files: PathLike, topics: Sequence[str] = (), declare: Mapping[str, str] | None = None) -> Inspection:
    """The contents of a recording: time, units, axes, rests; and the session for it.

    files: those of one recording. topics: of a file with several tables. declare: what the data leave open, by key: {"gyro.unit": "deg/s"}.
    """
    if not files:
        raise TypeError("expected the files of a recording")
    if isinstance(topics, str):
        raise TypeError("topics: expected a list of names, got str")
    return Inspection(*_imulab.inspect([path("file", f) for f in files], list(topics), dict(declare or {})))


def read_recording(
    data: PathLike | Session, *, recording: str = "", topics: Sequence[str] = (), declare: Mapping[str, str] | None = None
) -> Recording:
    """A recording of a session, or any recording file or folder, which is inspected first. Raises Unsupported with what its data leave open.

    topics: of a file with several tables, as of `inspect`.
    """
    if declare:
        return inspect(path("data", data), topics=topics, declare=declare).recording
    return _one_recording(data, None, recording, topics, needs_gravity=False)[1]


@_options("calibrate")
def calibrate(
    data: Data,
    *,
    method: str,
    site: Site | Table | None = None,
    imu: Table | None = None,
    terms: str | Sequence[str] = "auto",
    prior: Fleet | PathLike | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Calibration:
    """A calibration with the uncertainty of every coefficient.

    data: a session, its folder, a recording file, or recordings in memory with their `site` and `imu` (a table as in session.toml).
    method: "static", "handheld", "turntable", "hybrid", "whole-unit" or "drive".
    terms: "auto", "full" (whole-unit), or names of coefficients to estimate.
    prior: a fleet, whose units say what is known of this one. progress: called with the part that is done, 0 to 1, where the method knows it.

    Look at `verdict` and `shortcomings` of the result. Raises Error for declarations that are wrong, Unsupported where nothing can be determined.
    """
    session, recordings = _declared(data, site, imu)
    given = None if recordings is None else [r._recording for r in recordings]
    options |= {"method": method, "terms": terms if isinstance(terms, str) else ",".join(terms), "prior": _store(prior)}
    found, warnings = _imulab.calibrate(session._session, given, options, _callback(progress))
    warn(warnings)
    return Calibration(found)


def compensate(calibration: Calibration, recording: Recording, *, reject_outliers: bool = False, allow_undetermined: bool = False) -> Recording:
    """A recording in rad/s and m/s^2. reject_outliers: spikes of one or two samples are replaced first."""
    _expect("calibration", calibration, Calibration)
    _expect("recording", recording, Recording)
    calibration._expect_usable(allow_undetermined)
    calibration._expect_thermal_units(recording)
    out, out_of_range, _ = _imulab.compensate(calibration._answer, recording._recording, reject_outliers)
    if len(out_of_range):
        warn([f"{recording.name}: {len(out_of_range)} of {len(recording)} samples are outside the calibrated temperatures"])
    return Recording(out, recording.temperature_units)


@_options("compare")
def compare(*calibrations: Calibration, **options: Any) -> Comparison:
    """The others with the first, coefficient by coefficient, in sigmas and in user units. One without uncertainties counts as the truth."""
    if len(calibrations) < 2 or not all(isinstance(c, Calibration) for c in calibrations):
        raise TypeError("expected two or more calibrations")
    return Comparison(_told(_imulab.compare([(c.name, c._answer) for c in calibrations], options)))


def _named(names: Sequence[str], count: int) -> list[str]:
    """Those names, or imu0, imu1, ..."""
    if isinstance(names, str) or (names and len(names) != count):
        raise TypeError(f"names: expected a list of {count}")
    return list(names) or [f"imu{k}" for k in range(count)]


def calibrate_jointly(*calibrations: Calibration, names: Sequence[str] = (), progress: Progress | None = None) -> list[Calibration]:
    """Calibrations of IMUs on one body, each made from its recording of one motion: at least as certain as alone. A finding says so, or what is in the way."""
    if len(calibrations) < 2 or not all(isinstance(c, Calibration) for c in calibrations):
        raise TypeError("expected two or more calibrations")
    named = _named(names, len(calibrations))
    found = _imulab.calibrate_jointly([(name, c._answer) for name, c in zip(named, calibrations)], _callback(progress))
    return [Calibration(each, name) for each, name in zip(found, named)]


@_options("extrinsics")
def extrinsics(
    *imus: Recording,
    calibrations: Sequence[Calibration | None] = (),
    names: Sequence[str] = (),
    progress: Progress | None = None,
    **options: Any,
) -> Extrinsics:
    """Rotation, lever arm and clock offset between IMUs on one body, from a recording each of one motion; relative to the first.

    calibrations: of the IMUs, in their order; None: as its grade. names: of the IMUs (default: imu0, imu1, ...).
    """
    if len(imus) < 2 or not all(isinstance(r, Recording) for r in imus):
        raise TypeError("expected two or more recordings")
    if calibrations and len(calibrations) != len(imus):
        raise TypeError(f"calibrations: expected {len(imus)}, in the order of the recordings; None: without one")
    answers = [None if c is None else c._answer for c in calibrations] or [None] * len(imus)
    given = [(name, r._recording, answer) for name, r, answer in zip(_named(names, len(imus)), imus, answers)]
    return Extrinsics(_told(_imulab.extrinsics(given, options, _callback(progress))))


@_options("verify")
def verify(calibration: PathLike, **options: Any) -> Verification:
    """Checks by SHA-256 that the session and the recordings are still the files that a calibration was made from.

    Raises Error where the file is no calibration that was made from files.
    """
    return Verification(_imulab.verify(path("calibration", calibration), options))


@_options("simulate")
def simulate(procedure: Session | PathLike, *, unit: Calibration | None = None, output: PathLike | None = None, **options: Any) -> Simulation:
    """Carries out a procedure with a virtual rig and a virtual IMU. The same seed gives the same result.

    unit: the IMU to simulate, in place of the procedure's. output: also writes this new folder.
    """
    _expect("unit", unit, Calibration, type(None))
    session = procedure if isinstance(procedure, Session) else read_session(procedure)
    folder = "" if output is None else path("output", output)
    made, recordings, truth = _imulab.simulate(session._session, options, None if unit is None else unit._answer, folder)
    return Simulation(Session._of(made), [Recording._of(r, made) for r in recordings], Calibration(truth, "truth"))


@_options("predict")
def predict(
    procedure: Session | PathLike,
    *,
    prior: Fleet | PathLike | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
    parts: int | None = None,
    **options: Any,
) -> Prediction:
    """Standard uncertainties of a calibration to come, and the requirements that it misses.

    prior: a fleet, whose units say what is known of this one.
    executor: whose workers do the Monte Carlo in as many `parts` (four a worker, or a processor of this machine): of concurrent.futures, Dask, mpi4py. The result is the same to the bit.
    """
    options |= {"prior": _store(prior)}
    if executor is not None and not isinstance(procedure, Session):
        procedure = read_session(procedure)
    done = _parts.by_parts(executor, parts, _callback(progress), _parts.prediction, procedure, options)
    given: Any = procedure._session if isinstance(procedure, Session) else path("procedure", procedure)
    return Prediction(_told(_imulab.predict(given, options, None if done else _callback(progress), done)))


@_options("plan")
def plan(
    require: str,
    *,
    axes: Sequence[str] = ("outer", "middle", "inner"),
    by_hand: bool = False,
    prior: Fleet | PathLike | None = None,
    progress: Progress | None = None,
    **options: Any,
) -> Plan:
    """The shortest turns and rests with which the method hybrid meets requirements, or the best within `time` seconds.

    prior: a fleet, whose units say what is known of this one.
    """
    if isinstance(axes, str):
        raise TypeError("axes: expected a list of names, got str")
    options |= {"require": require, "axes": ",".join(axes), "prior": _store(prior)}
    return Plan(*_imulab.plan(options, by_hand, _callback(progress)))


def _moving(given: Data | Calibration) -> Any:
    if isinstance(given, Calibration):
        return given._answer, given.name
    if isinstance(given, str | os.PathLike) and str(given).endswith(".json"):
        return path("moving", given)
    return _one_recording(given, None, "", needs_gravity=False)[1]._recording


@_options("noise")
def noise(
    data: Data | None = None, *, recording: str = "", moving: Data | Calibration | Sequence[Data | Calibration] | None = None, **options: Any
) -> Noise:
    """Allan deviation and noise coefficients, with intervals, of the longest rest of a recording; without one those of `datasheet`.

    moving: recordings of the same IMU with motors on or in motion, or a calibration, or the JSON of an aided navigation: where the factor of a
    filter comes from.
    """
    given = [] if moving is None else [_moving(each) for each in (moving if isinstance(moving, list | tuple) else [moving])]
    if data is None:
        if options.get("datasheet") is None:
            raise TypeError("data: expected a recording or a session; without them datasheet=")
        return Noise(_told(_imulab.noise(None, None, options, given)))
    session, found = _one_recording(data, None, recording, needs_gravity=False)
    return Noise(_told(_imulab.noise(session._session, found._recording, options, given)))


def allan_deviation(
    rate: npt.ArrayLike, interval_s: float, *, kind: str = "overlapping-allan", factors: Sequence[int] | None = None
) -> dict[str, FloatArray]:
    """The deviation of a signal, (N,), over averaging times: "tau", "deviation", "edf", "lower_68", "upper_68", "lower_95", "upper_95".

    factors: averaging times in samples; without them four an octave up to a third of the record.
    """
    if factors is not None and not all(isinstance(f, (int, np.integer)) and f >= 1 for f in factors):
        raise Error("factors: expected whole numbers of samples, from 1")
    columns = _imulab.deviation(_arrays.column("rate", rate), interval_s, kind, None if factors is None else [int(f) for f in factors]).T
    return dict(zip(("tau", "deviation", "edf", "lower_68", "upper_68", "lower_95", "upper_95"), (np.ascontiguousarray(c) for c in columns)))


@_options("trajectory")
def trajectory(
    mission: PathLike, *, unit: Calibration | None = None, output: PathLike | None = None, progress: Progress | None = None, **options: Any
) -> Flight:
    """The readings of an ideal IMU on a mission, and the truth. unit: raw readings of this IMU. output: also writes this new folder."""
    _expect("unit", unit, Calibration, type(None))
    session, recording, truth, warnings = _imulab.trajectory(
        path("mission", mission),
        options,
        None if unit is None else unit._answer,
        "" if output is None else path("output", output),
        _callback(progress),
    )
    warn(warnings)
    return Flight(Session._of(session), Recording._of(recording, session), Solution(truth))


@_options("navigate")
def navigate(
    calibration: Calibration | None,
    data: Session | Simulation | Flight | PathLike,
    *,
    recording: str = "",
    refuse_gaps: bool = False,
    **options: Any,
) -> Navigation:
    """Aligns, and integrates a session to position, velocity and attitude; with the errors against its truth.

    calibration: None for recordings that are in SI already. aided=True corrects the solution with the session's aids, and smooths it.
    """
    _expect("calibration", calibration, Calibration, type(None))
    if isinstance(data, Flight):
        session, found = data.session, data.recording
    else:
        session, found = _one_recording(data, None, recording)
    own = data.truth._solution if isinstance(data, Flight) and options.get("truth") is None else None
    _expect("refuse_gaps", refuse_gaps, bool)
    if refuse_gaps:
        if options.get("gaps") not in (None, "refuse"):
            raise Error("gaps and refuse_gaps contradict each other; expected one")
        options["gaps"] = "refuse"
    answer, name = (None, "") if calibration is None else (calibration._answer, calibration.name)
    outcome, solution = _imulab.navigate(found.name, answer, name, session._session, found._recording, options, own)
    return Navigation(_told(outcome), solution)


@_options("budget")
def budget(
    mission: PathLike,
    *,
    grade: str | Sequence[str] | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
    parts: int | None = None,
    **options: Any,
) -> Budget:
    """Position, velocity and attitude errors of a mission, by source, with a Monte Carlo.

    grade: sensors of this grade, in place of the mission's; several, as a list or with commas, are compared (`Budget.budgets`).
    executor: whose workers do the Monte Carlo in as many `parts` (four a worker, or a processor of this machine): of concurrent.futures, Dask, mpi4py. The result is the same to the bit.
    """
    if grade is not None:
        names = [grade] if isinstance(grade, str) else grade
        if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
            raise TypeError(f"grade: expected a name or a list of names, got {grade!r}")
        options["grade"] = ",".join(names)
    file = path("mission", mission)
    done = _parts.by_parts(executor, parts, _callback(progress), _parts.budget, file, options)
    return Budget(_told(_imulab.budget(file, options, None if done else _callback(progress), done)))


def methods() -> dict[str, str]:
    """The calibration methods, each with what it needs."""
    return dict(_imulab.methods())


def export_targets() -> dict[str, str]:
    """The targets of `Calibration.to`, each with its purpose."""
    return dict(_imulab.export_targets())
