"""Extrinsics of simulated bodies against the truth: ./dev accept extrinsics [--bodies N] [--seed N]

Bodies of 2 to 6 IMUs, clean, must have uncertainties that hold; bodies with a fault must not be falsely sure."""

import argparse
import json
import pathlib
import subprocess
import tempfile

import numpy as np

import judging
import simulate as s
import together
from judging import check

parser = argparse.ArgumentParser()
parser.add_argument("imulab", type=lambda name: pathlib.Path(name).resolve())
parser.add_argument("--bodies", type=int, default=40)
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--only", default="", choices=("", "extrinsics", "reference", "joint"))
options = parser.parse_args()


def vector(c):
    """Rotation vector of a small rotation."""
    return np.array([c[2, 1] - c[1, 2], c[0, 2] - c[2, 0], c[1, 0] - c[0, 1]]) / 2


def found(folder, names, rates, grade):
    s.session(folder / "session.toml", list(zip(names, rates)), grade)
    result = subprocess.run([options.imulab, "extrinsics", folder, "-o", folder / "e.json"], capture_output=True, text=True)
    file = folder / "e.json"
    return (json.loads(file.read_text()) if file.exists() else None), result


def errors(answer, imus, seconds):
    """Of each mounting: error over its standard uncertainty, of 9 numbers."""
    rows = []
    for mounting, imu in zip(answer["mountings"], imus[1:]):
        u = mounting["standard_uncertainty"]
        turn = vector(np.array(mounting["rotation"]) @ imu.rotation.T) / s.DEG
        epoch = answer["epoch_s"] + answer.get("first_s", 0)
        offset = mounting["clock_offset_s"] - imu.offset - imu.drift * (epoch - seconds / 2)
        rows.append(np.concatenate([turn / u["rotation_deg"], (np.array(mounting["lever_arm_m"]) - imu.arm) / u["lever_arm_m"],
                                    [offset / u["clock_offset_s"], (mounting["clock_drift_ppm"] - 1e6 * imu.drift) / u["clock_drift_ppm"],
                                     (mounting["accel_delay_s"] - imu.delay) / u["accel_delay_s"]]]))
    return rows


def body(seed, folder, *, imus=None, grade="mems", seconds=60, axis=None, fault=None):
    random = np.random.default_rng([seed, options.seed])
    count = imus or int(random.integers(2, 7))
    rates = [float(random.choice([50, 100, 200, 400, 1000])) for _ in range(count)]
    motion = s.Motion(random, seconds, axis=axis)
    units = [s.Imu(random, grade, rate, first=k == 0, arm=1 / np.sqrt(3)) for k, rate in enumerate(rates)]
    if fault == "late accelerometers":
        units[1].delay = 0.02
    names = [f"imu{k}" for k in range(count)]
    start = None
    for k, (name, unit) in enumerate(zip(names, units)):
        moved, bend = motion, None
        if fault == "another body" and k == 1:
            moved = s.Motion(random, seconds)
        if fault == "elastic mount" and k == 1:
            bend = lambda m: 0.05 * np.roll(m.rate, 40, axis=0)[:, [1, 2, 0]]
        stamps, rate, force = unit.read(random, moved, seconds, bend)
        if fault == "mirrored" and k == 1:
            rate[:, 2], force[:, 2] = -rate[:, 2], -force[:, 2]
        if fault == "clock steps" and k == 1:
            stamps = stamps + 0.03 * (stamps > seconds / 2)
        start = stamps[0] if start is None else start
        s.write(folder / f"{name}.csv", stamps, rate, force)
    answer, result = found(folder, names, rates, grade)
    if answer:
        answer["first_s"] = start
    return answer, result, units, seconds


def clean(grade):
    all_rows, good, u = [], 0, []
    for seed in range(options.bodies):
        with tempfile.TemporaryDirectory() as name:
            answer, result, units, seconds = body(seed, pathlib.Path(name), grade=grade)
        if not answer or answer["verdict"] != "good":
            print(f"   body {seed}: {result.stderr.strip() or answer['headline']}")
            continue
        good += 1
        all_rows += errors(answer, units, seconds)
        u += [[max(m["standard_uncertainty"]["rotation_deg"]), 1e3 * max(m["standard_uncertainty"]["lever_arm_m"]),
               1e3 * m["standard_uncertainty"]["clock_offset_s"]] for m in answer["mountings"]]
    rows, u = np.array(all_rows), np.median(u, axis=0)
    inside = (np.abs(rows) < 1.96).mean()
    check(good >= 0.98 * options.bodies, f"{grade}: {good} of {options.bodies} bodies good")
    print(f"   {grade}: RMS of error over u: rotation {np.sqrt((rows[:, :3] ** 2).mean()):.2f}, lever arm {np.sqrt((rows[:, 3:6] ** 2).mean()):.2f}, "
          f"clock offset, drift, delay {', '.join(f'{x:.2f}' for x in np.sqrt((rows[:, 6:] ** 2).mean(0)))}; largest {np.abs(rows).max():.1f}")
    print(f"   {grade}: median u: rotation {u[0]:.3f} deg, lever arm {u[1]:.2f} mm, clock {u[2]:.4f} ms")
    # 9 numbers of a mounting are correlated, and rotations of uncalibrated IMUs have priors for most of their u: more may be inside, not fewer.
    check(inside > 0.93, f"{grade}: {100 * inside:.1f} % of {rows.size} numbers within 1.96 u")


def faulty():
    for fault, axis in (("another body", None), ("elastic mount", None), ("mirrored", None), ("clock steps", None), ("late accelerometers", None),
                        ("one axis", (0, 0, 1))):
        said, wrong, worst, named = [], 0, 0, 0
        for seed in range(max(4, options.bodies // 10)):
            with tempfile.TemporaryDirectory() as name:
                answer, result, units, seconds = body(seed, pathlib.Path(name), imus=2, seconds=40, axis=axis, fault=fault)
            if answer and answer["verdict"] == "good":
                rows = np.abs(errors(answer, units, seconds))
                worst = max(worst, rows.max())
                wrong += rows.max() > 5
            named += bool(answer) and "lever arm along z" in answer["mountings"][0]["not_shown"]
            said.append((answer["verdict"] + ": " + "; ".join(answer["warnings"])) if answer else result.stderr.strip().splitlines()[-1])
        if axis:
            check(named == len(said), f"{fault}: {named} of {len(said)} name the lever arm along it")
        check(wrong == 0, f"{fault}: {wrong} of {len(said)} good and more than 5 u off (worst {worst:.1f}); said: {said[0][:220]}")


def by_reference(drive):
    """A MEMS IMU beside a tactical one that has no calibration."""
    ratios, good, scales = [], 0, []
    seconds = 600 if drive else 60
    sessions = max(4, options.bodies // (10 if drive else 4))
    for seed in range(sessions):
        random = np.random.default_rng([seed, options.seed, 7])
        motion = s.Motion(random, seconds, drive=drive)
        units = [s.Imu(random, "tactical", 100.0, first=True), s.Imu(random, "mems", 100.0)]
        if drive:
            units[1].rotation = s.rotation(0.02 * random.normal(size=3))  # parallel, or no axis is the one about which the vehicle turns
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for which, unit in zip(("good", "cheap"), units):
                s.write(folder / f"{which}.csv", *unit.read(random, motion, seconds))
            s.session(folder / "session.toml", [("good", 100.0), ("cheap", 100.0)], "mems")
            result = subprocess.run([options.imulab, "calibrate", folder, "--method", "reference", "--reference", "good", "--calibration", "tactical",
                                     "-o", folder / "c.json"], capture_output=True, text=True)
            file = folder / "c.json"
            calibration = json.loads(file.read_text()) if file.exists() else None
        if not calibration or calibration["quality"]["verdict"] != "good":
            print(f"   session {seed}: {judging.reasons_of(calibration) if calibration else result.stderr.strip()}")
            continue
        good += 1
        rows = judging.rows_of(calibration, units[1])
        ratios += [e / u for e, u in rows.values()]
        scales.append(rows["gyro.matrix[2, 2]"][1])
    name = "drives of 10 minutes" if drive else "motions by hand of a minute"
    check(good >= 0.98 * sessions, f"reference, {name}: {good} of {sessions} good")
    inside = (np.abs(ratios) < 1.96).mean()
    check(inside > 0.93, f"reference, {name}: {100 * inside:.1f} % of {len(ratios)} coefficients within 1.96 u, largest {np.abs(ratios).max():.1f}; "
          f"u of the gyro scale z {1e6 * np.median(scales):.0f} ppm")


def jointly(grade, size):
    """Two units of a grade, with effects of this size in their priors, by hand: alone and jointly."""
    sessions, effects = max(4, options.bodies // 2), {name: size for name in together.units.SIZES if size}
    units = [unit for seed in range(sessions) for unit in together.studied(options.imulab, 1000 * options.seed + seed, grade, effects)[0]]
    both = [u for u in units if u and u[0][2]["verdict"] == u[1][2]["verdict"] == "good" and any(f["code"] == "joint-estimate" for f in u[1][2]["findings"])]
    name = f"jointly, {grade}, effects of {size:g} sigma"
    check(len(both) >= 0.9 * len(units), f"{name}: {len(both)} of {len(units)} units good alone and jointly")
    if not both:
        return
    per, largest, ratios = [[], []], [0, 0], []
    for unit in both:
        for k, (rows, chi2, _) in enumerate(unit):
            per[k].append(chi2 / len(rows))
            largest[k] = max(largest[k], *(abs(e) / u for e, u in rows.values()))
        alone, joint = unit[0][0], unit[1][0]
        ratios += [joint[n][1] / alone[n][1] for n in joint if n.split(".")[1] == "matrix"]
    check(np.mean(per[1]) < max(1, np.mean(per[0])) + 0.1, f"{name}: chi-square per coefficient {np.mean(per[0]):.2f} alone, {np.mean(per[1]):.2f} jointly; "
          f"largest {largest[0]:.1f} and {largest[1]:.1f} u; u of scales and misalignments {np.median(ratios):.2f} of that alone, {min(ratios):.2f} to {max(ratios):.2f}")
    check(max(ratios) < 1 + 1e-6, f"{name}: none less certain than alone")


if options.only in ("", "joint"):
    for grade, size in (("mems", 0), ("mems", 1), ("tactical", 0), ("tactical", 1)):
        jointly(grade, size)
if options.only in ("", "extrinsics"):
    for grade in ("mems", "tactical"):
        clean(grade)
    faulty()
if options.only in ("", "reference"):
    by_reference(drive=False)
    by_reference(drive=True)
judging.finish()
