"""Sessions of units on a three-axis turntable with effects that a sensor model lacks: turns about each axis, then 24 positions.

As simulate.py, by code of its own. The table has errors of its axes, zeros and stops; the IMU bends in its mount, and may move in it half-way.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

import simulate
from simulate import DEG, EARTH, G, GRADES, Motion, Unit, rotation

ARCSEC = DEG / 3600
SIZES = simulate.SIZES | {
    "gyro.higher_orders": (1e-6, (1, 5, 50, 1000)),
    "mount.elastic": (ARCSEC / G, (0.5, 1, 5, 30)),
}
# Not effects of the table with a prior: a rotation in the mount half-way, in arcsec, and how much worse the table is than declared.
OTHERS = ("mount.change", "table.worse")
TABLE = {"strategic": 1, "navigation": 2, "tactical": 10, "mems": 30}  # arcsec, one sigma of angles, axes and zeros

AXES = {"inner": np.array([1.0, 0, 0]), "middle": np.array([0, 1.0, 0]), "outer": np.array([0, 0, 1.0])}
ORDER = ("outer", "middle", "inner")


@dataclass
class Step:
    kind: str
    start: float
    end: float
    angles: dict[str, float]  # rad, at its begin
    axis: str = ""
    angle: float = 0  # rad, of a turn


def procedure(rest_s: float, turns: int, rate: float, acceleration: float, move_s: float, all_faces: bool) -> list[Step]:
    """`turns` forward and back about each axis, then each face up with four headings; `rate` and `acceleration` in deg/s, deg/s^2. `all_faces`: on each
    also turns about the vertical, where the gyros see the mount bend, which rests on six faces alone do not tell from cross terms."""
    steps: list[Step] = []
    angles, t = dict.fromkeys(ORDER, 0.0), 0.0

    def hold(new: dict[str, float]) -> None:
        nonlocal t, angles
        t += move_s if new != angles else 0
        angles = new
        steps.append(Step("hold", t, t + rest_s, dict(angles)))
        t += rest_s

    def turn(axis: str) -> None:
        nonlocal t, angles
        for sign in (1, -1):
            duration = 360 * turns / rate + rate / acceleration
            steps.append(Step("rotate", t, t + duration, dict(angles), axis, sign * 2 * np.pi * turns))
            t += duration
            angles = angles | {axis: angles[axis] + sign * 2 * np.pi * turns}
            hold(angles)

    hold(angles)
    for axis in ("middle", "outer", "inner"):
        turn(axis)
    for inner, middle in ((90, 0), (0, 0), (0, -90), (-90, 0), (0, 180), (0, 90)):
        for outer in (0, 90, 180, 270):
            hold({"outer": outer * DEG, "middle": middle * DEG, "inner": inner * DEG})
        if all_faces:
            turn("outer")
    return steps


def trapezoid(t: np.ndarray, duration: float, ramp: float) -> np.ndarray:
    """The part of a turn that is done after t seconds."""
    cruise = 1 / (duration - ramp)
    up = 0.5 * cruise * t**2 / ramp
    down = 1 - 0.5 * cruise * (duration - t) ** 2 / ramp
    return np.where(t < ramp, up, np.where(t > duration - ramp, down, cruise * (t - 0.5 * ramp)))


def smooth(x: np.ndarray) -> np.ndarray:
    return x**3 * (10 + x * (6 * x - 15))


def table_angles(rng: np.random.Generator, steps: list[Step], edges: np.ndarray, sigma: float, ramp: float) -> dict[str, np.ndarray]:
    """Actual angles at the edges of the samples. An axis has another error after each move."""
    error = {a: rng.normal() * sigma for a in ORDER}
    now = {a: error[a] for a in ORDER}
    out = {a: np.full(len(edges), now[a]) for a in ORDER}
    end_before = 0.0
    for step in steps:
        moves: dict[str, float] = {}
        if step.kind == "hold":
            moves = {a: step.angles[a] for a in ORDER if abs(step.angles[a] - (now[a] - error[a])) > 1e-9}
            begin, end = end_before, step.start
        else:
            moves = {step.axis: step.angles[step.axis] + step.angle}
            begin, end = step.start, step.end
        during, after = (edges > begin) & (edges < end), edges >= end
        for a, to in moves.items():
            error[a] = rng.normal() * sigma
            x = edges[during] - begin
            part = trapezoid(x, end - begin, ramp) if step.kind == "rotate" else smooth(x / (end - begin))
            out[a][during] = now[a] + (to + error[a] - now[a]) * part
            now[a] = to + error[a]
            out[a][after] = now[a]
        end_before = step.end
    return out


def table_motion(rng: np.random.Generator, steps: list[Step], rate_hz: float, sigma: float, ramp: float, latitude: float, gravity: float,
                 elastic: np.ndarray, change: np.ndarray, change_at: float) -> Motion:
    n = int(round(steps[-1].end * rate_hz))
    edges = np.arange(n + 1) / rate_hz
    angles = table_angles(rng, steps, edges, sigma, ramp)
    axes = {}
    for name, axis in AXES.items():
        off = rng.normal(size=3) * sigma * (1 - axis)
        axes[name] = (axis + off) / np.linalg.norm(axis + off)
    zero = {a: rng.normal() * sigma for a in ORDER}

    def attitude(at: dict[str, np.ndarray]) -> np.ndarray:
        out = np.eye(3)[None]
        for a in ORDER:
            out = out @ rotation(axes[a], at[a] + zero[a])
        return out

    middle = {a: 0.5 * (v[1:] + v[:-1]) for a, v in angles.items()}
    C = attitude(middle)
    # The rate of the body: each axis turns what is inside it.
    rate = np.zeros((n, 3))
    inside = np.broadcast_to(np.eye(3), (n, 3, 3))
    for a in reversed(ORDER):
        rate += np.diff(angles[a])[:, None] * rate_hz * np.einsum("nji,j->ni", inside, axes[a])
        inside = rotation(axes[a], middle[a] + zero[a]) @ inside
    earth = EARTH * np.array([0, np.cos(latitude), np.sin(latitude)])
    force, rate = np.einsum("nji,j->ni", C, np.array([0, 0, gravity])), rate + np.einsum("nji,j->ni", C, earth)
    time = edges[1:]
    angle = force @ elastic.T + np.where(time > change_at, 1.0, 0.0)[:, None] * change
    force, rate = force - np.cross(angle, force), rate - np.cross(angle, rate)  # turned by a small angle in the body
    resting = np.zeros(n, bool)
    for s in steps:
        if s.kind == "hold":
            resting |= (time > s.start) & (time <= s.end)
    return Motion(time, force, rate, resting)


def readings(rng: np.random.Generator, unit: Unit, m: Motion, grade: str, rate_hz: float, gravity: float, full_rate: float):
    own = {k: v for k, v in unit.effects.items() if k in simulate.SIZES}
    raised = Motion(m.time, m.force, m.rate.copy(), m.rest)
    for c, power in zip(unit.effects.get("gyro.higher_orders", []), (4, 5)):
        raised.rate += c * (m.rate / full_rate) ** power * full_rate
    known = Unit(unit.accel_offset, unit.accel_matrix, unit.gyro_offset, unit.gyro_matrix, unit.g_sensitivity, own)
    return simulate.readings(rng, known, raised, grade, rate_hz, gravity)


def drawn_unit(rng: np.random.Generator, grade: str, effects: dict[str, float]) -> Unit:
    unit = simulate.drawn_unit(rng, grade, {k: v for k, v in effects.items() if k in simulate.SIZES})
    for name, count in (("gyro.higher_orders", 2), ("mount.elastic", 3)):
        scale, priors = SIZES[name]
        if name in effects:
            unit.effects[name] = effects[name] * scale * priors[GRADES.index(grade)] * rng.normal(size=(count, 3))
    return unit


def write_session(folder: Path, seed: int, grade: str, effects: dict[str, float], *, rest_s: float = 30, turns: int = 2, rate_hz: float = 20,
                  latitude: float = 48 * DEG, latitude_off: float = 0, declare_grade: bool = True, all_faces: bool = False) -> Unit:
    rng = np.random.default_rng(seed)
    rate, acceleration, gravity = 20.0, 50.0, 9.809
    steps = procedure(rest_s, turns, rate, acceleration, 5, all_faces)
    unit = drawn_unit(rng, grade, effects)
    change = rng.normal(size=3)
    change *= effects.get("mount.change", 0) * ARCSEC / np.linalg.norm(change)
    half = [s for s in steps if s.kind == "hold"][18].end + 2
    sigma = TABLE[grade] * ARCSEC
    true_gravity = gravity + 1e-5 * rng.normal()
    motion = table_motion(rng, steps, rate_hz, sigma * effects.get("table.worse", 1), rate / acceleration, latitude, true_gravity,
                          unit.effects.get("mount.elastic", np.zeros((3, 3))), change, half)
    accel, gyro = readings(rng, unit, motion, grade, rate_hz, true_gravity, max(rate * DEG, 1))
    text = simulate.imu_text(grade, declare_grade) + simulate.site_text(latitude / DEG + latitude_off, gravity) + '[rig]\nkind = "turntable"\n'
    text += "".join(f"{error}_sigma_arcsec = {TABLE[grade]}\n" for error in ("angle", "orthogonality", "zero"))
    text += simulate.recording_text("recording.csv", rate_hz)
    for s in steps:
        text += f'[[step]]\nkind = "{s.kind}"\nstart_s = {s.start:.9g}\nend_s = {s.end:.9g}\n'
        if s.kind == "hold":
            text += "".join(f"{a}_deg = {s.angles[a] / DEG:.9g}\n" for a in ORDER)
        else:
            text += f'axis = "{s.axis}"\nangle_deg = {s.angle / DEG:.9g}\nrate_dps = {rate}\nacceleration_dps2 = {acceleration}\n'
    simulate.write(folder, text, unit, {"recording.csv": np.column_stack([motion.time, gyro, accel])})
    return unit
