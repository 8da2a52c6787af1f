"""The verbs of the command, on values."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _arrays, _imulab
from ._arrays import FloatArray
from ._calibration import Calibration
from ._fleet import Fleet
from ._imulab import Error
from ._recording import Recording
from ._results import Budget, Comparison, Inspection, Navigation, Noise, Plan, Prediction, Solution, Verification
from ._session import Session, Site, Table, read_session
from ._text import PathLike, path, warn

Progress = Callable[[float], object]


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


Data = Session | Recording | Simulation | Sequence[Recording] | PathLike


def _callback(progress: Progress | None) -> Progress | None:
    if progress is not None and not callable(progress):
        raise TypeError(f"progress: expected a function of one number, got {type(progress).__name__}")
    return progress


def _is_session(place: str) -> bool:
    return os.path.isdir(place) or place.endswith(".toml")


def _expect(name: str, value: Any, *kinds: type) -> None:
    if not isinstance(value, kinds):
        expected = " or ".join(kind.__name__ for kind in kinds if kind is not type(None))
        raise TypeError(f"{name}: expected a {expected}, got {type(value).__name__}")


def _declared(data: Data, site: Site | Table | None, imu: Table | None) -> tuple[Session, list[Recording] | None]:
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
        return data, None
    place = path("data", data)
    if _is_session(place):
        return read_session(place), None
    session, gravity = _imulab.session_of_recording(place)
    if gravity:
        warn([f"{place}: assumed: {gravity}; declare the place: inspect(file, declare={{'latitude_deg': '47.4'}}).session"])
    return Session._of(session), None


def _one_recording(data: Data, site: Site | Table | None, chosen: str) -> tuple[Session, Recording]:
    session, recordings = _declared(data, site, None)
    if recordings is None:
        found, notes = _imulab.read_recording(session._session, _imulab.choose_recording(session._session, chosen))
        warn(notes)
        return session, Recording._of(found, session._session)
    named = [r for r in recordings if r.name == chosen] if chosen else recordings
    if len(named) != 1:
        raise Error(f"recording: {chosen!r}; expected one of {', '.join(r.name for r in recordings)}")
    return session, named[0]


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


def read_recording(data: PathLike | Session, *, recording: str = "", declare: Mapping[str, str] | None = None) -> Recording:
    """A recording of a session, or any recording file, which is inspected first. Raises Unsupported with what its data leave open."""
    if declare:
        return inspect(path("data", data), declare=declare).recording
    return _one_recording(data, None, recording)[1]


def calibrate(
    data: Data,
    *,
    method: str,
    site: Site | Table | None = None,
    imu: Table | None = None,
    terms: str | Sequence[str] = "auto",
    require: str = "",
    recording: str = "",
    stepwise: bool = False,
    prior: Fleet | PathLike | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """A calibration with the uncertainty of every coefficient.

    data: a session, its folder, a recording file, or recordings in memory with their `site` and `imu` (a table as in session.toml).
    method: "static", "handheld", "turntable", "hybrid" or "whole-unit".
    terms: "auto", "full" (whole-unit), or names of coefficients to estimate.
    require: what it is for: "gyro.matrix.diagonal <= 100 ppm, accel.offset <= 200 ug".
    recording: one of a session that has several. prior: a fleet, whose units say what is known of this one. progress: called with the part that is done, 0 to 1, where the method knows it.

    Look at `verdict` and `shortcomings` of the result. Raises Error for declarations that are wrong, Unsupported where nothing can be determined.
    """
    session, recordings = _declared(data, site, imu)
    given = None if recordings is None else [r._recording for r in recordings]
    selected = terms if isinstance(terms, str) else ",".join(terms)
    found, warnings = _imulab.calibrate(session._session, given, method, selected, require, recording, stepwise, _store(prior), _callback(progress))
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


def compare(*calibrations: Calibration, different_imus: bool = False) -> Comparison:
    """The others with the first, coefficient by coefficient, in sigmas and in user units. One without uncertainties counts as the truth.

    different_imus: also where their serial numbers differ.
    """
    if len(calibrations) < 2 or not all(isinstance(c, Calibration) for c in calibrations):
        raise TypeError("expected two or more calibrations")
    outcome = _imulab.compare([(c.name, c._answer) for c in calibrations], different_imus)
    warn(outcome.warnings)
    return Comparison(outcome)


def verify(calibration: PathLike, *, session: PathLike | None = None) -> Verification:
    """Whether the session and the recordings are still the files that a calibration was made from, by their SHA-256.

    session: its folder or file, if it is not where it was. Raises Error where the file is no calibration that was made from files.
    """
    return Verification(_imulab.verify(path("calibration", calibration), "" if session is None else path("session", session)))


def simulate(
    procedure: Session | PathLike, *, seed: int = 1, unit: Calibration | None = None, grade: str | None = None, output: PathLike | None = None
) -> Simulation:
    """Carries out a procedure with a virtual rig and a virtual IMU. The same seed gives the same result.

    unit: the IMU to simulate; grade: a grade by its name, or noise.json; both in place of the procedure's. output: also writes this new folder.
    """
    _expect("unit", unit, Calibration, type(None))
    session = procedure if isinstance(procedure, Session) else read_session(procedure)
    made, recordings, truth = _imulab.simulate(
        session._session, _seed(seed), None if unit is None else unit._answer, grade, "" if output is None else path("output", output)
    )
    return Simulation(Session._of(made), [Recording._of(r, made) for r in recordings], Calibration(truth, "truth"))


def _seed(seed: int) -> int:
    if not 0 <= seed < 2**64:
        raise Error(f"seed: {seed}; expected 0 to 2^64 - 1")
    return seed


def predict(
    procedure: Session | PathLike,
    *,
    method: str = "turntable",
    terms: str = "auto",
    require: str = "",
    runs: int = 20000,
    seed: int = 1,
    classical: bool = False,
    progress: Progress | None = None,
) -> Prediction:
    """Standard uncertainties of a calibration to come, and the requirements that it misses.

    terms: as of calibrate. runs: of the Monte Carlo (turntable); 0: none."""
    session = procedure if isinstance(procedure, Session) else read_session(procedure)
    if not 0 <= runs < 10**9:
        raise Error(f"runs: {runs}; expected 0 to 999999999")
    outcome = _imulab.predict(session._session, method, terms, require, runs, _seed(seed), classical, _callback(progress))
    warn(outcome.warnings)
    return Prediction(outcome)


def plan(
    require: str,
    *,
    grade: str = "navigation",
    latitude_deg: float = 45.0,
    gravity: float | None = None,
    axes: Sequence[str] = ("outer", "middle", "inner"),
    by_hand: bool = False,
    time: float | None = None,
    rest: float | None = None,
    prior: Fleet | PathLike | None = None,
    progress: Progress | None = None,
) -> Plan:
    """The shortest turns and rests with which the method hybrid meets requirements, or the best within `time` seconds.

    prior: a fleet, whose units say what is known of this one.
    """
    if isinstance(axes, str):
        raise TypeError("axes: expected a list of names, got str")
    for name, value, low, high in (("latitude_deg", latitude_deg, -90, 90), ("gravity", gravity, 9.7, 9.9), ("time", time, 60, 14400), ("rest", rest, 6, 600)):
        if value is not None and not low <= value <= high:
            raise Error(f"{name}: {value}; expected {low} to {high}")
    return Plan(*_imulab.plan(require, grade, latitude_deg, gravity, list(axes), by_hand, time, rest, _store(prior), _callback(progress)))


def noise(
    data: Data, *, recording: str = "", deviation: str = "overlapping-allan", remove_temperature: bool = False
) -> Noise:
    """Allan deviation and noise coefficients, with intervals, of the longest rest of a recording."""
    session, found = _one_recording(data, None, recording)
    outcome = _imulab.noise(session._session, found._recording, deviation, remove_temperature)
    warn(outcome.warnings)
    return Noise(outcome)


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


def trajectory(
    mission: PathLike,
    *,
    errors: bool = False,
    unit: Calibration | None = None,
    seed: int = 1,
    output: PathLike | None = None,
    progress: Progress | None = None,
) -> Flight:
    """What an ideal IMU measures on a mission, and the truth. errors: with those of the mission; unit: raw readings of this IMU."""
    if errors and unit is not None:
        raise Error("errors and unit exclude each other")
    _expect("unit", unit, Calibration, type(None))
    session, recording, truth, warnings = _imulab.trajectory(
        path("mission", mission),
        errors,
        None if unit is None else unit._answer,
        _seed(seed),
        "" if output is None else path("output", output),
        _callback(progress),
    )
    warn(warnings)
    return Flight(Session._of(session), Recording._of(recording, session), Solution(truth))


def navigate(
    calibration: Calibration | None,
    data: Session | Simulation | Flight | PathLike,
    *,
    recording: str = "",
    vertical: str = "free",
    align: bool = False,
    heading_deg: float | None = None,
    heading_sigma_deg: float = 0.0,
    barometer: PathLike | None = None,
    truth: PathLike | None = None,
    refuse_gaps: bool = False,
    allow_undetermined: bool = False,
) -> Navigation:
    """Aligns, and integrates a session to position, velocity and attitude; with the errors against its truth.

    calibration: None for recordings that are in SI already. vertical: "free", "fixed", or "aided" and "held" with a `barometer`: a CSV file.
    """
    _expect("calibration", calibration, Calibration, type(None))
    if isinstance(data, Flight):
        session, found = data.session, data.recording
    else:
        session, found = _one_recording(data, None, recording)
    if calibration is not None:
        calibration._expect_usable(allow_undetermined)
    own = data.truth._solution if isinstance(data, Flight) and truth is None else None
    outcome, solution = _imulab.navigate(
        found.name,
        None if calibration is None else calibration._answer,
        session._session,
        found._recording,
        vertical,
        align,
        heading_deg,
        heading_sigma_deg,
        "" if barometer is None else path("barometer", barometer),
        "" if truth is None else path("truth", truth),
        own,
        refuse_gaps,
    )
    warn(outcome.warnings)
    return Navigation(outcome, solution)


def budget(
    mission: PathLike,
    *,
    grade: str | None = None,
    system: str | None = None,
    calibration: PathLike | None = None,
    noise: PathLike | None = None,
    runs: int = 200,
    seed: int = 1,
    every: float = 10.0,
    allow_undetermined: bool = False,
    progress: Progress | None = None,
) -> Budget:
    """Position, velocity and attitude errors of a mission, by source, with a Monte Carlo of `runs` runs.

    grade, system or calibration (a file): in place of the mission's sensors. noise: noise.json in place of its noise. every: s between outputs.
    """
    if sum(x is not None for x in (grade, system, calibration)) > 1:
        raise Error("grade, system and calibration exclude each other; expected one")
    if not 0 <= runs <= 10**7:
        raise Error(f"runs: {runs}; expected 0 to 10000000")
    outcome = _imulab.budget(
        path("mission", mission),
        grade,
        system,
        None if calibration is None else path("calibration", calibration),
        None if noise is None else path("noise", noise),
        runs,
        _seed(seed),
        every,
        allow_undetermined,
        _callback(progress),
    )
    warn(outcome.warnings)
    return Budget(outcome)


def methods() -> dict[str, str]:
    """The calibration methods, each with what it needs."""
    return dict(_imulab.methods())


def export_targets() -> dict[str, str]:
    """What `Calibration.to` can write, each with what it is for."""
    return dict(_imulab.export_targets())
