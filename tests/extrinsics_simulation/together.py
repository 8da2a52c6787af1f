"""Units with effects that a sensor model lacks, two on one body that is turned by hand from rest to rest, calibrated jointly and each alone."""

import importlib.util
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

simulator = importlib.util.spec_from_file_location("units", pathlib.Path(__file__).parents[1] / "effects_simulation" / "simulate.py")
units = sys.modules["units"] = importlib.util.module_from_spec(simulator)
simulator.loader.exec_module(units)

GRAVITY, RATE_HZ, LATITUDE = 9.809, 50, 48 * units.DEG
ARM = np.array([0.06, -0.04, 0.03])


def mounted(motion, rotation, arm):
    """The motion of another place on the body."""
    slope = np.gradient(motion.rate, 1 / RATE_HZ, axis=0)
    force = motion.force + np.cross(slope, arm) + np.cross(motion.rate, np.cross(motion.rate, arm))
    return units.Motion(motion.time, force @ rotation.T, motion.rate @ rotation.T, motion.rest)


def write(folder, seed, grade, effects, rests=30, clock=1e-4):
    """A session of two units, the second of which has a faster clock. Returns them."""
    random = np.random.default_rng([seed, 69])
    motion = units.hand_motion(random, rests, 5, RATE_HZ, LATITUDE, GRAVITY)
    axis = random.normal(size=3)
    turn = units.rotation(axis / np.linalg.norm(axis), np.array([random.uniform(0, np.pi)]))[0]
    text, drawn = units.imu_text(grade) + units.site_text(LATITUDE / units.DEG, GRAVITY), []
    for name, moved in (("a", motion), ("b", mounted(motion, turn, ARM))):
        unit = units.drawn_unit(random, grade, effects)
        accel, gyro = units.readings(random, unit, moved, grade, RATE_HZ, GRAVITY)
        np.savetxt(folder / f"{name}.csv", np.column_stack([moved.time * (1 + clock * (name == "b")), gyro, accel]), delimiter=",", header="t,gx,gy,gz,ax,ay,az", comments="", fmt="%.13g")
        text += units.recording_text(f"{name}.csv", RATE_HZ, f'imu = "{name}"\n')
        units.in_recorded_seconds(unit, clock * (name == "b"))
        drawn.append(unit)
    (folder / "session.toml").write_text(text)
    return drawn


def errors_of(file, unit):
    """By coefficient: error and standard uncertainty; and chi-square of all."""
    c = json.loads(file.read_text())
    names, P = c["covariance"]["coefficients"], np.array(c["covariance"]["matrix"])

    def value(name):
        triad, term, place = name.split(".")
        at = tuple("xyz".index(a) if a in "xyz" else int(a) for a in place)
        return np.array(c["model"][triad][term])[at]

    e = np.array([value(n) - unit.values().get(n, 0) for n in names])
    return dict(zip(names, zip(e, np.sqrt(np.diag(P))))), float(e @ np.linalg.lstsq(P, e, rcond=1e-14)[0]), c["quality"]


def studied(imulab, seed, grade, effects, change=None):
    """Of each unit: its results alone and jointly. `change`: of the units' readings' files in their folder."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        drawn = write(folder, seed, grade, effects)
        if change:
            change(folder)

        def calibrated(*more):
            return subprocess.run([imulab, "calibrate", "session.toml", "--method", "handheld", *more], cwd=folder, capture_output=True, text=True)

        said = calibrated("-o", "c.json")
        for which in "ab":
            calibrated("--recording", f"{which}.csv", "-o", f"alone-{which}.json")
        out = []
        for k, which in enumerate("ab"):
            files = folder / f"alone-{which}.json", folder / f"c-{k}.json"
            out.append([errors_of(file, drawn[k]) for file in files] if all(f.exists() for f in files) else None)
        return out, said
