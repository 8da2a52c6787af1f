"""Calibration against poses of a tracked body: ./dev accept poses [--sessions N] [--seed N]

A MEMS IMU and markers in a hand, clean: uncertainties must hold. With a fault of the poses: a named cause, and nothing falsely sure."""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np

import judging
import simulate as s
from judging import check, reasons_of, rows_of

parser = argparse.ArgumentParser()
parser.add_argument("imulab", type=lambda name: pathlib.Path(name).resolve())
parser.add_argument("--sessions", type=int, default=100)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--seconds", type=float, default=60)
parser.add_argument("--only", default="")
options = parser.parse_args()

AID = '[[aid]]\nkind = "pose"\nfile = "poses.txt"\nposition_sigma_m = 0.001\nattitude_sigma_deg = 0.05\n'
DELAYS = {"accelerometers 20 ms late": 0.02, "gyros 40 ms late": -0.04}  # s


def run(seed, folder, fault=None, frame="free", aid=AID):
    random = np.random.default_rng([seed, options.seed])
    motion = s.Motion(random, options.seconds, plane=fault == "a robot on a floor")
    unit, tracker = s.Imu(random, "mems", 200.0, first=True), s.Tracker(random, frame=frame)
    unit.delay = DELAYS.get(fault, 0)
    stamps, rate, force = unit.read(random, motion, options.seconds)
    s.write(folder / "imu.csv", stamps, rate, force)
    at, places, quaternions = tracker.read(random, motion, options.seconds)
    if fault == "left-handed":
        places[:, 1], quaternions[:, [0, 2]] = -places[:, 1], -quaternions[:, [0, 2]]
    elif fault == "inverse":
        quaternions[:, :3] = -quaternions[:, :3]
    elif fault == "jump":
        places[len(at) // 2:] += 0.05
    elif fault == "millimetres":
        places = 1000 * places
    elif fault == "another motion":
        at, places, quaternions = tracker.read(random, s.Motion(random, options.seconds), options.seconds)
    elif fault == "loose":
        wobble = s.Sines(random, 0.03, 0.3, 2).at(at)
        quaternions = np.array([s.quaternion(matrix(q) @ s.rotation(v)) for q, v in zip(quaternions, wobble)])
    s.write_poses(folder / "poses.txt", at, places, quaternions)
    s.session(folder / "session.toml", [("imu", 200.0)], "mems")
    with open(folder / "session.toml", "a") as file:
        file.write("[site]\nlatitude_deg = 50\ngravity_mps2 = 9.81\n" + aid.replace('file =', f'frame = "{frame}"\nfile ='))
    result = subprocess.run([options.imulab, "calibrate", folder, "--method", "drive", "-o", folder / "c.json"], capture_output=True, text=True)
    file = folder / "c.json"
    return (json.loads(file.read_text()) if file.exists() else None), result, unit


def matrix(q):
    x, y, z, w = q
    v = np.array([x, y, z])
    return (w * w - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * w * s.cross(v)


def clean(frame):
    good, all_rows = 0, {}
    for seed in range(options.sessions):
        with tempfile.TemporaryDirectory() as name:
            calibration, result, unit = run(seed, pathlib.Path(name), frame=frame)
        if not calibration or calibration["quality"]["verdict"] != "good":
            print(f"   session {seed}: {reasons_of(calibration) if calibration else result.stderr.strip()}")
            continue
        good += 1
        for key, row in rows_of(calibration, unit).items():
            all_rows.setdefault(key, []).append(row)
    check(good >= 0.98 * options.sessions, f"{frame}: {good} of {options.sessions} sessions good")
    ratios = []
    for key, rows in all_rows.items():
        e, u = np.array(rows).T
        ratios += list(e / u)
        print(f"   {key:24} RMS error {np.sqrt((e**2).mean()):.3g}, median u {np.median(u):.3g}, RMS of error over u {np.sqrt(((e / u) ** 2).mean()):.2f}")
    inside = (np.abs(ratios) < 1.96).mean()
    check(0.93 <= inside, f"{frame}: {100 * inside:.1f} % of {len(ratios)} coefficients within 1.96 u; largest {np.abs(ratios).max():.1f}")


def faulty():
    for fault in ("left-handed", "inverse", "jump", "millimetres", "another motion", "loose", "a robot on a floor", *DELAYS):
        wrong, worst, said = 0, 0, []
        for seed in range(max(3, options.sessions // 20)):
            with tempfile.TemporaryDirectory() as name:
                calibration, result, unit = run(seed, pathlib.Path(name), fault, "level" if fault == "a robot on a floor" else "free")
            if calibration and calibration["quality"]["verdict"] == "good":
                largest = max(abs(e / u) for e, u in rows_of(calibration, unit).values())
                worst, wrong = max(worst, largest), wrong + (largest > 5)
            said.append(reasons_of(calibration) if calibration else (result.stderr.strip() or "?").splitlines()[-1])
        check(wrong == 0, f"{fault}: {wrong} of {len(said)} good and more than 5 u off (worst {worst:.1f}); said: {said[0][:300]}")


if options.only != "faults":
    for frame in ("free", "level") if not options.only else (options.only,):
        clean(frame)
if options.only in ("", "faults"):
    faulty()
judging.finish()
