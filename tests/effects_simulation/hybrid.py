"""Sessions for the hybrid method: a unit on a three-axis table that turns it by 90 and 180 deg between rests, with effects that a sensor model lacks."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import simulate
from simulate import DEG, EARTH, Motion, Unit

# Axis and turn [deg], from zero angles (Cheng 2014).
PATH = [("middle", 90), ("middle", 180), ("middle", 180), ("middle", -90), ("inner", 90), ("inner", 180), ("inner", 180), ("middle", 90), ("middle", 180),
        ("middle", 180), ("outer", 90), ("middle", -90), ("inner", -90), ("outer", 90), ("inner", -90), ("middle", 90), ("inner", 90), ("outer", -90),
        ("middle", 90), ("inner", -90)]
AXES = {"outer": np.array([0, 0, 1.0]), "middle": np.array([0, 1.0, 0]), "inner": np.array([1.0, 0, 0])}  # east, north, up at zero angles
SIZES = simulate.SIZES | {"gyro.higher_orders": (simulate.PPM, (1, 5, 50, 1000))}
RATE, ACCELERATION = 10 * DEG, 50 * DEG  # of turns: rad/s, rad/s^2


def angle_of_turn(angle: float, t: np.ndarray) -> np.ndarray:
    """A trapezoid of rate, at times since its begin."""
    ramp, whole = RATE / ACCELERATION, abs(angle) / RATE + RATE / ACCELERATION
    t = np.clip(t, 0, whole)
    up, down = np.minimum(t, ramp), np.maximum(t - (whole - ramp), 0)
    steady = np.clip(t - ramp, 0, whole - 2 * ramp)
    return np.sign(angle) * (0.5 * ACCELERATION * up**2 + RATE * steady + RATE * down - 0.5 * ACCELERATION * down**2)


def table_motion(rng: np.random.Generator, rest_s: float, rate_hz: float, latitude: float, gravity: float, table: float = 60 / 3600 * DEG) -> tuple[Motion, list[dict]]:
    """The motion, and the steps as they are declared. `table`: one sigma of the table's errors, which nobody declares to the method."""
    dt, up = 1 / rate_hz, np.array([0, 0, 1.0])
    earth = EARTH * np.array([0, np.cos(latitude), np.sin(latitude)])
    axes = {k: (v + table * rng.normal(size=3)) / np.linalg.norm(v) for k, v in AXES.items()}
    axes = {k: v / np.linalg.norm(v) for k, v in axes.items()}
    zero = {k: table * rng.normal() for k in AXES}
    declared = dict.fromkeys(AXES, 0.0)
    now = dict(zero)

    def attitude(changed: str, angles: np.ndarray) -> np.ndarray:
        parts = {k: simulate.rotation(axes[k], angles if k == changed else np.full(len(angles), now[k])) for k in AXES}
        return parts["outer"] @ parts["middle"] @ parts["inner"]

    force, rate, rest, steps = [], [], [], []
    time = 0.0
    for k, (axis, turn) in enumerate([*PATH, ("", 0)]):
        n = round(rest_s * rate_hz)
        C = attitude("", np.zeros(1))[0]
        force.append(np.tile(C.T @ up * gravity, (n, 1)))
        rate.append(np.tile(C.T @ earth, (n, 1)))
        rest.append(np.ones(n, bool))
        steps.append({"kind": "hold", "start_s": time, "end_s": time + n * dt, **{f"{a}_deg": v for a, v in declared.items()}})
        time += n * dt
        if not axis:
            break
        angle = turn * DEG + table * rng.normal()
        m = int(np.ceil((abs(turn * DEG) / RATE + RATE / ACCELERATION + 0.1) * rate_hz))  # it ends a little earlier than the step
        edges = now[axis] + angle_of_turn(angle, np.arange(m + 1) * dt)
        middles = now[axis] + angle_of_turn(angle, (np.arange(m) + 0.5) * dt)
        # The mean over a sample by Simpson's rule.
        at_edges, at_middles = attitude(axis, edges).transpose(0, 2, 1), attitude(axis, middles).transpose(0, 2, 1)
        mean = (at_edges[:-1] + 4 * at_middles + at_edges[1:]) / 6
        carried = {"outer": np.eye(3), "middle": simulate.rotation(axes["outer"], np.array([now["outer"]]))[0],
                   "inner": simulate.rotation(axes["outer"], np.array([now["outer"]]))[0] @ simulate.rotation(axes["middle"], np.array([now["middle"]]))[0]}
        about = at_edges[0] @ carried[axis] @ axes[axis]  # fixed in the unit while it turns
        force.append(mean @ up * gravity)
        rate.append(np.diff(edges)[:, None] / dt * about + mean @ earth)
        rest.append(np.zeros(m, bool))
        now[axis] = edges[-1]
        declared[axis] += turn
        steps.append({"kind": "rotate", "start_s": time, "end_s": time + m * dt, "axis": axis, "angle_deg": turn, "rate_dps": RATE / DEG,
                      "acceleration_dps2": ACCELERATION / DEG})
        time += m * dt
    f = np.concatenate(force)
    return Motion((1 + np.arange(len(f))) * dt, f, np.concatenate(rate), np.concatenate(rest)), steps


def as_toml(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else f"{value:.12g}"


def write_session(folder: Path, seed: int, grade: str, effects: dict[str, float], *, rest_s: float = 30, rate_hz: float = 50, latitude: float = 48 * DEG,
                  clock: float = 0, sticks: bool = False) -> Unit:
    """A session with its noise and grade declared. `clock`: the recording's seconds are shorter than true ones by this fraction. `sticks`: a gyro reads
    nothing for a second of a turn."""
    rng = np.random.default_rng(seed)
    gravity = 9.809
    motion, steps = table_motion(rng, rest_s, rate_hz, latitude, gravity)
    if "gyro.higher_orders" in effects:
        scale, priors = SIZES["gyro.higher_orders"]
        c = effects["gyro.higher_orders"] * scale * priors[simulate.GRADES.index(grade)] * rng.normal(size=(2, 3))
        full = max(1, np.abs(motion.rate).max())  # rad/s: no gyro's range is less
        x = motion.rate / full
        motion.rate = motion.rate + (c[0] * x**4 + c[1] * x**5) * full
    unit = simulate.drawn_unit(rng, grade, {k: v for k, v in effects.items() if k in simulate.SIZES})
    accel, gyro = simulate.readings(rng, unit, motion, grade, rate_hz, gravity)
    if sticks:
        turns = [s for s in steps if s["kind"] == "rotate"]
        turn = turns[rng.integers(len(turns))]
        begin = round((turn["start_s"] + 3) * rate_hz)
        fastest = np.abs(gyro[begin]).argmax()
        gyro[begin:begin + round(rate_hz), fastest] = 0
    simulate.in_recorded_seconds(unit, clock)
    text = simulate.imu_text(grade) + simulate.site_text(latitude / DEG, gravity)
    text += '[rig]\nkind = "turntable"\nzero_sigma_arcsec = 60\nangle_sigma_arcsec = 60\northogonality_sigma_arcsec = 60\n'
    text += simulate.recording_text("recording.csv", rate_hz)
    for step in steps:
        text += "[[step]]\n" + "".join(f"{k} = {as_toml(v)}\n" for k, v in step.items())
    simulate.write(folder, text, unit, {"recording.csv": np.column_stack([motion.time * (1 + clock), gyro, accel])})
    return unit
