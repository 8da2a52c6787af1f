"""Sessions of units with effects that a sensor model lacks, by a simulator that shares no code with imulab.

A unit is turned from rest to rest in fixed body axes. Its raw readings v are those for which W0 + W1 v (+ C f) is the true force or rate plus the effects, so
that W0, W1 and C are the right values of a calibration.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

G, DEG = 9.80665, np.pi / 180
EARTH = 7.292115e-5
UG, PPM, DPH = 1e-6 * G, 1e-6, DEG / 3600

# One sigma by grade, in the units of the table of effects: strategic, navigation, tactical, mems.
GRADES = ("strategic", "navigation", "tactical", "mems")
SIZES = {
    "accel.asymmetry": (PPM, (2, 10, 100, 1000)),
    "gyro.asymmetry": (PPM, (0.5, 2, 30, 300)),
    "accel.cross_terms": (UG / G**2, (2, 10, 50, 1000)),
    "accel.hysteresis": (UG, (1, 5, 50, 500)),
    "gyro.g_squared": (DPH / G**2, (0.0005, 0.002, 0.5, 10)),
    "accel.fourth_order": (PPM, (1, 5, 50, 1000)),
    "gyro.scale_force": (PPM / G, (0.2, 1, 10, 100)),
    "accel.drift": (UG, (1, 5, 50, 2000)),
    "gyro.drift": (DPH, (0.0005, 0.003, 0.5, 150)),
    "accel.scale_drift": (PPM, (1, 5, 50, 500)),
    "gyro.scale_drift": (PPM, (1, 5, 50, 500)),
}
# Offsets, scales, misalignments, noise densities of a grade: SI.
UNITS = {
    "strategic": dict(ab=10 * UG, gb=1e-3 * DPH, s=5 * PPM, m=0.5 / 3600 * DEG, gs=0, na=1 * UG, ng=1e-4 * DPH * 60),
    "navigation": dict(ab=70 * UG, gb=0.01 * DPH, s=20 * PPM, m=10 / 3600 * DEG, gs=0, na=5 * UG, ng=1e-3 * DEG / 60),
    "tactical": dict(ab=300 * UG, gb=3 * DPH, s=150 * PPM, m=60 / 3600 * DEG, gs=0, na=100 * UG, ng=0.1 * DEG / 60),
    "mems": dict(ab=0.3, gb=1 * DEG, s=0.01, m=0.01, gs=0.05 * DEG / G, na=200 * UG, ng=0.01 * DEG),
}


def rotation(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Matrices of turns about a unit axis, one for each angle."""
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * k + (1 - c) * (k @ k)


@dataclass
class Motion:
    time: np.ndarray  # s, at the end of each sample
    force: np.ndarray  # m/s^2, mean of the sample
    rate: np.ndarray  # rad/s, mean of the sample
    rest: np.ndarray  # true at rest
    north: np.ndarray | None = None  # unit vectors to it


def hand_motion(rng: np.random.Generator, rests: int, rest_s: float, rate_hz: float, latitude: float, gravity: float) -> Motion:
    """Rests in directions all over the sphere, with one turn of 60 to 180 deg from each to the next."""
    dt, up = 1 / rate_hz, np.array([0, 0, 1.0])
    earth = EARTH * np.array([0, np.cos(latitude), np.sin(latitude)])
    C = rotation(np.array([1.0, 0, 0]), np.array([rng.uniform(-np.pi, np.pi)]))[0]
    force, rate, rest, north = [], [], [], []
    for k in range(rests):
        n = int(rest_s * rate_hz)
        force.append(np.tile(C.T @ up * gravity, (n, 1)))
        rate.append(np.tile(C.T @ earth, (n, 1)))
        rest.append(np.ones(n, bool))
        north.append(np.tile(C[1], (n, 1)))
        if k + 1 == rests:
            break
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        angle = rng.uniform(60, 180) * DEG * rng.choice([-1, 1])
        m = int(abs(angle) / (90 * DEG) * rate_hz)
        x = np.arange(m + 1) / m
        profile = angle * (x - np.sin(2 * np.pi * x) / (2 * np.pi))  # still at both ends
        middle = rotation(axis, 0.5 * (profile[1:] + profile[:-1]))
        attitude = C @ middle
        force.append(np.einsum("nji,j->ni", attitude, up) * gravity)
        rate.append(np.diff(profile)[:, None] / dt * axis + np.einsum("nji,j->ni", attitude, earth))
        rest.append(np.zeros(m, bool))
        north.append(attitude[:, 1])
        C = C @ rotation(axis, profile[-1:])[0]
    f, w = np.concatenate(force), np.concatenate(rate)
    return Motion((1 + np.arange(len(f))) * dt, f, w, np.concatenate(rest), np.concatenate(north))


def held_in_a_hand(rng: np.random.Generator, m: Motion, tremor_deg: float, wander_deg: float) -> Motion:
    """The body turned by a small angle throughout: a tremor of 2 to 6 Hz, and a slow wander, each with this RMS about every axis."""
    dt = m.time[1] - m.time[0]
    edges = np.arange(len(m.time) + 1) * dt

    def swinging(low: float, high: float, rms: float) -> np.ndarray:
        out = np.zeros((len(edges), 3))
        for _ in range(12):
            out += np.sin(2 * np.pi * rng.uniform(low, high, 3) * edges[:, None] + rng.uniform(0, 2 * np.pi, 3))
        return rms * DEG * out / np.sqrt(6)

    angle = swinging(2, 6, tremor_deg) + swinging(0.05, 0.2, wander_deg)
    a, turning = 0.5 * (angle[1:] + angle[:-1]), np.diff(angle, axis=0) / dt
    size = np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-12)

    def seen(v: np.ndarray) -> np.ndarray:
        """In the turned axes."""
        k = a / size
        return v * np.cos(size) - np.cross(k, v) * np.sin(size) + k * np.sum(k * v, axis=1, keepdims=True) * (1 - np.cos(size))

    rate = seen(m.rate) + turning - 0.5 * np.cross(a, turning) + np.cross(a, np.cross(a, turning)) / 6
    return Motion(m.time, seen(m.force), rate, m.rest, None if m.north is None else seen(m.north))


def slow(time: np.ndarray) -> np.ndarray:
    x = (time - time[0]) / (time[-1] - time[0])
    warm = 1 - np.exp(-4 * x)
    return np.stack([x - x.mean(), warm - warm.mean()])


def play(force: np.ndarray, half: float) -> np.ndarray:
    """Play operator: what drags behind the force by `half` on either side."""
    middle, out = force[0].copy(), np.empty_like(force)
    for i, f in enumerate(force):
        middle = np.minimum(np.maximum(middle, f - half), f + half)
        out[i] = (f - middle) / half
    return out


def columns(name: str, m: Motion, gravity: float) -> list[np.ndarray]:
    """The functions phi of an effect, each for the three axes at every sample."""
    f, w = m.force, m.rate
    nxt, last = np.roll(f, -1, axis=1), np.roll(f, -2, axis=1)
    if name == "accel.asymmetry":
        return [np.abs(f) - gravity / 2]
    if name == "gyro.asymmetry":
        return [np.abs(w)]
    if name == "accel.cross_terms":
        return [f * nxt, f * last, nxt * last, nxt**2 - gravity**2 / 3, last**2 - gravity**2 / 3]
    if name == "accel.hysteresis":
        return [play(f, 0.05 * gravity)]
    if name == "gyro.g_squared":
        return [f * nxt, f * last, nxt * last] + [x**2 - gravity**2 / 3 for x in (f, nxt, last)]
    if name == "accel.fourth_order":
        return [((f / G) ** 4 - (gravity / G) ** 4 / 5) * G]
    if name == "gyro.scale_force":
        return [w * f[:, j : j + 1] for j in range(3)]
    shapes = slow(m.time)
    if name in ("accel.drift", "gyro.drift"):
        return [np.repeat(s[:, None], 3, axis=1) for s in shapes]
    if name == "accel.scale_drift":
        return [s[:, None] * f for s in shapes]
    if name == "gyro.scale_drift":
        return [s[:, None] * w for s in shapes]
    raise KeyError(name)


@dataclass
class Unit:
    accel_offset: np.ndarray
    accel_matrix: np.ndarray
    gyro_offset: np.ndarray
    gyro_matrix: np.ndarray
    g_sensitivity: np.ndarray
    effects: dict[str, np.ndarray] = field(default_factory=dict)

    def values(self) -> dict[str, float]:
        """By the names of coefficients in a calibration."""
        out: dict[str, float] = {}
        for triad, offset, matrix in (("accel", self.accel_offset, self.accel_matrix), ("gyro", self.gyro_offset, self.gyro_matrix)):
            out |= {f"{triad}.offset.{a}": offset[i] for i, a in enumerate("xyz")}
            out |= {f"{triad}.matrix.{a}{b}": matrix[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}
        return out | {f"gyro.g_sensitivity.{a}{b}": self.g_sensitivity[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz")}


def drawn_unit(rng: np.random.Generator, grade: str, effects: dict[str, float]) -> Unit:
    """`effects`: the size of each in its prior sigmas."""
    u = UNITS[grade]
    accel = np.eye(3) + np.diag(rng.normal(size=3) * u["s"]) + np.tril(rng.normal(size=(3, 3)) * u["m"], -1)
    gyro = np.eye(3) + np.diag(rng.normal(size=3) * u["s"]) + (1 - np.eye(3)) * rng.normal(size=(3, 3)) * u["m"]
    unit = Unit(rng.normal(size=3) * u["ab"], accel, rng.normal(size=3) * u["gb"], gyro, rng.normal(size=(3, 3)) * u["gs"])
    for name, size in effects.items():
        scale, priors = SIZES[name]
        count = {"accel.cross_terms": 5, "gyro.g_squared": 6, "gyro.scale_force": 3}.get(name, 2 if "drift" in name else 1)
        unit.effects[name] = size * scale * priors[GRADES.index(grade)] * rng.normal(size=(count, 3))
    return unit


def readings(rng: np.random.Generator, unit: Unit, m: Motion, grade: str, rate_hz: float, gravity: float) -> tuple[np.ndarray, np.ndarray]:
    force, rate = m.force.copy(), m.rate.copy()
    for name, c in unit.effects.items():
        change = sum(ck * phi for ck, phi in zip(c, columns(name, m, gravity)))
        if name.startswith("accel"):
            force = force + change
        else:
            rate = rate + change
    rate = rate - m.force @ unit.g_sensitivity.T
    noise = UNITS[grade]
    accel = (force - unit.accel_offset) @ np.linalg.inv(unit.accel_matrix).T
    gyro = (rate - unit.gyro_offset) @ np.linalg.inv(unit.gyro_matrix).T
    root = np.sqrt(rate_hz)
    return accel + rng.normal(size=accel.shape) * noise["na"] * root, gyro + rng.normal(size=gyro.shape) * noise["ng"] * root


def imu_text(grade: str, declare_grade: bool = True) -> str:
    """A session's first lines: the unit's noise is declared."""
    named = f'grade = "{grade}"\n' if declare_grade else ""
    return f"""format = "imulab.session/1"
[imu]
name = "simulated"
{named}accel_noise_density = {UNITS[grade]["na"]:.9g}
gyro_noise_density = {UNITS[grade]["ng"]:.9g}
"""


def site_text(latitude_deg: float, gravity: float) -> str:
    return f"[site]\nlatitude_deg = {latitude_deg:.9g}\ngravity_mps2 = {gravity}\ngravity_sigma_mps2 = 1e-5\n"


def recording_text(file: str, rate_hz: float, more: str = "") -> str:
    return f"""[[recording]]
file = "{file}"
{more}rate_hz = {rate_hz}
time = {{ column = "t", unit = "s" }}
gyro = {{ columns = ["gx", "gy", "gz"], output = "rate", unit = "rad/s" }}
accel = {{ columns = ["ax", "ay", "az"], output = "rate", unit = "m/s^2" }}
"""


def write(folder: Path, text: str, unit, recordings: dict[str, np.ndarray]) -> None:
    """The session, its recordings (rows of time, gyro, accel and perhaps a temperature, by file), and the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    for file, rows in recordings.items():
        np.savetxt(folder / file, rows, delimiter=",", header=",".join("t gx gy gz ax ay az T".split()[: rows.shape[1]]), comments="", fmt="%.13g")
    (folder / "session.toml").write_text(text)
    (folder / "truth.json").write_text(json.dumps({"values": unit.values(), "effects": {k: v.tolist() for k, v in unit.effects.items()}}))


def in_recorded_seconds(unit: Unit, gain: float) -> None:
    """The right scales are per second of the recording, whose clock gains by this fraction."""
    unit.gyro_offset, unit.gyro_matrix, unit.g_sensitivity = (v / (1 + gain) for v in (unit.gyro_offset, unit.gyro_matrix, unit.g_sensitivity))


def write_session(folder: Path, seed: int, grade: str, effects: dict[str, float], *, rests: int = 40, rest_s: float = 5, rate_hz: float = 50,
                  latitude: float = 48 * DEG, latitude_off: float = 0, wrong_sign: bool = False, tremor: float = 0, wander: float = 0,
                  clock: float = 0, heading_ug: float = 0) -> Unit:
    """A session of a hand-turned unit with its noise and grade declared. `latitude_off` [deg]: of the declared one; `tremor`, `wander` [deg]: of the hand;
    `clock`: the recording's seconds are shorter than true ones by this fraction; `heading_ug`: offsets of the accelerometers that follow the heading."""
    rng = np.random.default_rng(seed)
    gravity = 9.809
    motion = hand_motion(rng, rests, rest_s, rate_hz, latitude, gravity)
    unit = drawn_unit(rng, grade, effects)
    if tremor or wander:
        motion = held_in_a_hand(np.random.default_rng([seed, 1]), motion, tremor, wander)
    if heading_ug:
        east = np.cross(motion.north, motion.force / gravity)
        by_north, by_east = np.random.default_rng([seed, 2]).normal(size=(2, 3)) * heading_ug * UG
        motion = Motion(motion.time, motion.force + by_north * motion.north + by_east * east, motion.rate, motion.rest)
    accel, gyro = readings(rng, unit, motion, grade, rate_hz, gravity)
    in_recorded_seconds(unit, clock)
    text = imu_text(grade) + site_text((-1 if wrong_sign else 1) * latitude / DEG + latitude_off, gravity) + recording_text("recording.csv", rate_hz)
    write(folder, text, unit, {"recording.csv": np.column_stack([motion.time * (1 + clock), gyro, accel])})
    return unit
