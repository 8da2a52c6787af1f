"""Sessions of a thermal chamber, a rate table and a centrifuge with effects that a sensor model lacks (see simulate.py)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from simulate import DEG, DPH, EARTH, G, GRADES, PPM, UG, UNITS, Motion, columns, imu_text, recording_text, rotation, write
from simulate import SIZES as COMMON

ARCSEC = DEG / 3600
SIZES = COMMON | {
    "gyro.higher_orders": (PPM, (1, 5, 50, 1000)),
    "accel.scale_temperature": (PPM, (1, 3, 20, 250)),
    "gyro.scale_temperature": (PPM, (0.2, 1, 20, 300)),
    "accel.turn_on": (UG, (5, 25, 1000, 5000)),
    "gyro.turn_on": (DPH, (0.0005, 0.0035, 1, 100)),
    "mount.elastic": (ARCSEC / G, (0.5, 1, 5, 30)),
    "thermometer.offset": (1, (0.3, 0.3, 0.3, 0.3)),
    "centrifuge.arm": (1e-3, (0.2, 0.2, 0.2, 0.2)),
    "site.latitude": (DEG, (0.05, 0.05, 0.05, 0.05)),
    "site.north": (DEG, (1, 1, 1, 1)),
}
COUNT = {"accel.cross_terms": 5, "gyro.g_squared": 6, "gyro.higher_orders": 2, "gyro.scale_force": 3}
# What a whole-unit session has besides simulate.UNITS: terms (quadratic 1/(m/s^2), cubic), thermal drift by K, g-sensitivity.
UG2, UG3, DPS = UG / G**2, UG / G**3, DEG
TERMS = {
    "strategic": dict(a2=5 * UG2, a3=1 * UG3, w2=1e-10 / DPS, w3=1e-14 / DPS**2, at=1 * UG, wt=1e-4 * DPH, gs=1e-4 * DPH / G),
    "navigation": dict(a2=20 * UG2, a3=5 * UG3, w2=1e-9 / DPS, w3=1e-13 / DPS**2, at=10 * UG, wt=1e-3 * DPH, gs=0.01 * DPH / G),
    "tactical": dict(a2=50 * UG2, a3=20 * UG3, w2=2e-8 / DPS, w3=1e-11 / DPS**2, at=50 * UG, wt=0.3 * DPH, gs=0.3 * DPH / G),
    "mems": dict(a2=65 * UG2, a3=13 * UG3, w2=2e-4 / DPS, w3=7e-10 / DPS**2, at=400 * UG, wt=50 * DPH, gs=95 * DPH / G),
}
ROOM = 25.0


@dataclass
class Point:
    recording: int  # 0 chamber, 1 rate table, 2 centrifuge
    start: float
    up: tuple[int, int]  # axis, sign
    outward: tuple[int, int]
    rate: float = 0
    radius: tuple[float, float, float] = (0, 0, 0)
    celsius: float = ROOM
    move: float = 0


def six_mounts(face_is_up: bool) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    mounts = []
    for sign in (1, -1):
        for axis in range(3):
            face, other = (axis, sign), ((axis + 1) % 3, 1)
            mounts.append((face, other) if face_is_up else (other, face))
    return mounts


def procedure(record: float, table_rates: np.ndarray, forces: np.ndarray, arm: float = 6.1) -> list[Point]:
    points: list[Point] = []
    clock = [0.0, 0.0, 0.0]

    def add(p: Point, move: float) -> None:
        p.start, p.move = clock[p.recording] + move, move
        clock[p.recording] = p.start + record
        points.append(p)

    for k, celsius in enumerate(range(0, 75, 5)):
        add(Point(0, 0, (2, 1), (0, 1), celsius=celsius), 1800 if k else 0)
    for up, outward in six_mounts(True):
        for k, rate in enumerate(table_rates):
            add(Point(1, 0, up, outward, rate=rate * DEG), 60 if k == 0 else 10)
    place = np.array([[4e-3, -2e-3, 1e-3], [-3e-3, 5e-3, 1e-3], [1e-3, -1e-3, 6e-3]])
    for up, outward in six_mounts(False):
        for force in forces:
            radius = tuple(round(arm + outward[1] * place[i][outward[0]], 4) for i in range(3))
            rate = round(np.sqrt(force * G / arm) / DEG, 2) * DEG
            add(Point(2, 0, up, outward, rate=rate, radius=radius), 60 if clock[2] > 0 else 0)
    return points


def axis_vector(a: tuple[int, int]) -> np.ndarray:
    v = np.zeros(3)
    v[a[0]] = a[1]
    return v


def turned(vector: np.ndarray) -> np.ndarray:
    angle = np.linalg.norm(vector)
    return np.eye(3) if angle == 0 else rotation(vector / angle, np.array([angle]))[0]


def normal_gravity(latitude: float) -> float:
    s2 = np.sin(latitude) ** 2
    return 9.7803253359 * (1 + 0.00193185265241 * s2) / np.sqrt(1 - 0.00669437999013 * s2)


@dataclass
class Place:
    latitude: float
    gravity: float
    north: np.ndarray  # by machine: its turn about up
    tilt: np.ndarray  # by machine: about east, about north
    rate: np.ndarray  # by machine, relative
    mount: dict  # by machine and mount: rotation vector in body axes
    radius: dict


def motion_of(p: Point, place: Place, time: np.ndarray, start_angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Force at each accelerometer and rate, at the samples' middles, by the kinematics of a body on a turning axis."""
    key = (p.recording, p.up, p.outward)
    north, up = axis_vector(p.outward), axis_vector(p.up)
    mounting = np.stack([np.cross(north, up), north, up]) @ turned(place.mount[key])  # body to the machine's axes at zero angle
    tilt = turned(np.array([place.tilt[p.recording][0], place.tilt[p.recording][1], 0]))
    speed = p.rate * (1 + place.rate[p.recording])
    angle = start_angle + speed * (time - p.start) + place.north[p.recording] if p.rate else np.full(len(time), place.north[p.recording])
    C = tilt @ rotation(np.array([0, 0, 1.0]), angle) @ mounting
    earth = EARTH * np.array([0, np.cos(place.latitude), np.sin(place.latitude)])
    spin = mounting.T @ np.array([0, 0, speed])
    of_earth = np.einsum("nji,j->ni", C, earth)
    rate = of_earth + spin
    force = np.einsum("nji,j->ni", C, np.array([0, 0, place.gravity]))
    if p.rate:
        change = np.cross(of_earth, spin)  # of the rate, seen from the body
        outward = mounting.T @ np.array([0, 1.0, 0])
        for i in range(3):
            at = outward * ((p.radius[i] + place.radius[key]) if p.recording == 2 else place.radius[key])
            acceleration = np.cross(change, at) + np.cross(rate, np.cross(rate, at)) - np.cross(of_earth, np.cross(of_earth, at))
            force[:, i] += acceleration[:, i]
    return force, rate


def change_of(name: str, c: np.ndarray, r: int, m: Motion, gravity: float, full: tuple[float, float], points: dict, warm: np.ndarray):
    """What an effect of these sizes adds to force and rate in recording r."""
    nothing = np.zeros_like(m.force)
    if name == "gyro.higher_orders":
        x = m.rate / full[1]
        return nothing, (c[0] * x**4 + c[1] * x**5) * full[1]
    if name == "accel.fourth_order":
        return c[0] * ((m.force / full[0]) ** 4 - (gravity / full[0]) ** 4 / 5) * full[0], nothing
    if name == "accel.scale_temperature":
        return c[0] * warm[:, None] * m.force, nothing
    if name == "gyro.scale_temperature":
        return nothing, c[0] * warm[:, None] * m.rate
    if name.endswith("turn_on"):
        shift = np.broadcast_to((c - c.mean(axis=0))[r], m.force.shape)
        return (shift, nothing) if name.startswith("accel") else (nothing, shift)
    if name == "mount.elastic":
        angle = m.force @ c.T
        return np.cross(m.force, angle), np.cross(m.rate, angle)
    if name == "centrifuge.arm":
        return c[0, 0] * points["stretching"], nothing
    if name.startswith(("site", "thermometer")):
        return nothing, nothing  # in the motion, and in the temperature that is read
    own = c[2 * r : 2 * r + 2] if "drift" in name else c
    change = sum(ck * phi for ck, phi in zip(own, columns(name, m, gravity)))
    return (change, nothing) if name.startswith("accel") else (nothing, change)


def raw_readings(model: dict[str, np.ndarray], triad: str, out: np.ndarray, warm: np.ndarray) -> np.ndarray:
    """U for which W0 + W1 V + W2 V^2 + W3 V^3 is the output, V = U - c1 tau - c2 tau^2."""
    inverse = np.linalg.inv(model[triad + ".matrix"])
    V = (out - model[triad + ".offset"]) @ inverse.T
    for _ in range(30):
        bent = model[triad + ".quadratic"] * V**2 + model[triad + ".cubic"] * V**3
        V = (out - model[triad + ".offset"] - bent) @ inverse.T
    tau = warm[:, None]
    return V + model[triad + ".thermal"][:, 0] * tau + model[triad + ".thermal"][:, 1] * tau**2


class Unit:
    def __init__(self, rng: np.random.Generator, grade: str, effects: dict[str, float]):
        u, t = UNITS[grade], TERMS[grade]
        off = 1 - np.eye(3)
        self.model = {
            "accel.offset": rng.normal(size=3) * u["ab"],
            "gyro.offset": rng.normal(size=3) * u["gb"],
            "accel.matrix": np.eye(3) + np.diag(rng.normal(size=3) * u["s"]) + off * rng.normal(size=(3, 3)) * u["m"],
            "gyro.matrix": np.eye(3) + np.diag(rng.normal(size=3) * u["s"]) + off * rng.normal(size=(3, 3)) * u["m"],
            "accel.quadratic": rng.normal(size=3) * t["a2"],
            "accel.cubic": rng.normal(size=3) * t["a3"],
            "gyro.quadratic": rng.normal(size=3) * t["w2"],
            "gyro.cubic": rng.normal(size=3) * t["w3"],
            "accel.thermal": rng.normal(size=(3, 2)) * t["at"] * np.array([1, 1 / 150]),
            "gyro.thermal": rng.normal(size=(3, 2)) * t["wt"] * np.array([1, 1 / 150]),
            "gyro.g_sensitivity": rng.normal(size=(3, 3)) * t["gs"],
        }
        self.effects = {}
        for name, size in effects.items():
            scale, priors = SIZES[name]
            count = 6 if "drift" in name else 3 if name in ("mount.elastic", "site.north", "thermometer.offset") or name.endswith("turn_on") else COUNT.get(name, 1)
            self.effects[name] = size * scale * priors[GRADES.index(grade)] * rng.normal(size=(count, 3))

    def values(self) -> dict[str, float]:
        out: dict[str, float] = {}
        for name, value in self.model.items():
            for i, a in enumerate("xyz"):
                if value.ndim == 1:
                    out[f"{name}.{a}"] = value[i]
                else:
                    second = "12" if name.endswith("thermal") else "xyz"
                    out |= {f"{name}.{a}{b}": value[i, j] for j, b in enumerate(second)}
        return out


def drawn_place(rng: np.random.Generator, unit: Unit, points: list[Point], latitude: float) -> Place:
    def angle(name: str) -> np.ndarray:
        return unit.effects.get(name, np.zeros((3, 3)))[:, 0]

    true = latitude + angle("site.latitude")[0]
    keys = list(dict.fromkeys((p.recording, p.up, p.outward) for p in points))
    return Place(true, normal_gravity(true) + rng.normal() * 3e-4, angle("site.north"), rng.normal(size=(3, 2)) * 5 * ARCSEC,
                 rng.normal(size=3) * 10 * PPM * np.array([0, 1, 1]), {k: rng.normal(size=3) * 10 * ARCSEC for k in keys},
                 {k: rng.normal() * 1e-4 * (k[0] > 0) for k in keys})


MACHINES = ("chamber", "rate_table", "centrifuge")


def session_text(points: list[Point], grade: str, record: float, rate_hz: float, latitude: float, extra: str) -> str:
    text = imu_text(grade) + f"{extra}\n[site]\nlatitude_deg = {latitude / DEG:.9g}\nheight_m = 0\n"
    for name in MACHINES:
        of_rate = "" if name == "chamber" else "rate_sigma_ppm = 10\nradius_sigma_mm = 0.1\n"
        text += f'[[rig]]\nname = "{name}"\nkind = "{name}"\nzero_sigma_arcsec = 5\nmount_sigma_arcsec = 10\n{of_rate}'
    for name in MACHINES:
        text += recording_text(f"{name}.csv", rate_hz, f'rig = "{name}"\nextent = "steps"\n')
        text += "".join(f'{triad}_temperature = {{ columns = ["T"], unit = "degC", noise = 0.01 }}\n' for triad in ("gyro", "accel"))
    for p in points:
        a = ["+-"[s < 0] + "xyz"[i] for i, s in (p.up, p.outward)]
        text += f'[[step]]\nkind = "{"spin" if p.rate else "hold"}"\nrecording = "{MACHINES[p.recording]}.csv"\n'
        text += f'duration_s = {record:g}\nmove_s = {p.move:g}\nup = "{a[0]}"\noutward = "{a[1]}"\n'
        if p.rate:
            text += f"rate_dps = {p.rate / DEG:.9g}\n" + (f"radius_m = {list(p.radius)}\n" if p.recording == 2 else "")
        if p.recording == 0:
            text += f"temperature_degC = {p.celsius:g}\n"
    return text


def write_session(folder: Path, seed: int, grade: str, effects: dict[str, float], *, record: float = 7.2, rate_hz: float = 20,
                  latitude: float = 48 * DEG, wrong_sign: bool = False, extra: str = "", fixed: dict[str, float] | None = None) -> Unit:
    """`wrong_sign`: of the declared latitude. `fixed`: sizes in the unit of the table instead of draws, equal or opposite by axis and column."""
    rng = np.random.default_rng(seed)
    points = procedure(record, np.arange(-400, 401, 50), np.arange(0, 31, 5))
    unit = Unit(rng, grade, effects | dict.fromkeys(fixed or {}, 0.0))
    for name, size in (fixed or {}).items():
        unit.effects[name] = size * SIZES[name][0] * rng.choice([-1, 1], size=unit.effects[name].shape)
    place = drawn_place(rng, unit, points, latitude)
    n = round(record * rate_hz)
    per_recording = []
    for r in range(3):
        mine = [p for p in points if p.recording == r]
        middle = np.concatenate([p.start + (np.arange(n) + 0.5) / rate_hz for p in mine])
        motions = [motion_of(p, place, middle[k * n : (k + 1) * n], rng.uniform(0, 2 * np.pi)) for k, p in enumerate(mine)]
        f, w = (np.concatenate([m[i] for m in motions]) for i in (0, 1))
        warm = np.repeat([p.celsius - ROOM for p in mine], n)
        arm_full = max((abs(p.rate) for p in points if p.recording == 2), default=1)
        stretching = np.concatenate([np.tile(-axis_vector(p.outward) * p.rate**2 * (p.rate / arm_full) ** 2 * (r == 2), (n, 1)) for p in mine])
        per_recording.append((Motion(middle, f, w, np.ones(len(f), bool)), warm, {"stretching": stretching}))
    full = tuple(max(np.abs(getattr(m, what)).max() for m, _, _ in per_recording) for what in ("force", "rate"))
    u, recordings = UNITS[grade], {}
    for r, (m, warm, more) in enumerate(per_recording):
        force, rate = m.force.copy(), m.rate.copy()
        for name, c in unit.effects.items():
            change = change_of(name, c, r, m, place.gravity, full, more, warm)
            force, rate = force + change[0], rate + change[1]
        accel = raw_readings(unit.model, "accel", force, warm)
        gyro = raw_readings(unit.model, "gyro", rate - m.force @ unit.model["gyro.g_sensitivity"].T, warm)
        accel += rng.normal(size=accel.shape) * u["na"] * np.sqrt(rate_hz)
        gyro += rng.normal(size=gyro.shape) * u["ng"] * np.sqrt(rate_hz)
        celsius = ROOM + warm + unit.effects.get("thermometer.offset", np.zeros((3, 3)))[r, 0] + rng.normal(size=len(warm)) * 0.01
        recordings[f"{MACHINES[r]}.csv"] = np.column_stack([m.time + 0.5 / rate_hz, gyro, accel, celsius])
    write(folder, session_text(points, grade, record, rate_hz, -latitude if wrong_sign else latitude, extra), unit, recordings)
    return unit
