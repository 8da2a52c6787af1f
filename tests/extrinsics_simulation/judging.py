"""What the acceptance runs of this folder share: checks, and a calibration file against the simulated IMU."""

import sys

import numpy as np

failed = []


def check(right, text):
    print(("   " if right else "!! ") + text, flush=True)
    if not right:
        failed.append(text)


def finish():
    print(f"{len(failed)} checks failed")
    sys.exit(1 if failed else 0)


def reasons_of(calibration):
    quality = calibration["quality"]
    return "; ".join([quality["verdict"], *quality["because"]])


def truth_of(unit):
    """By the names of a calibration file: w = W0 + W1 r + C f, f = A0 + A1 r."""
    accel, gyro = np.linalg.inv(unit.accel), np.linalg.inv(unit.gyro)
    return {("accel", "matrix"): accel, ("accel", "offset"): -accel @ unit.accel_bias, ("gyro", "matrix"): gyro,
            ("gyro", "offset"): -gyro @ unit.gyro_bias, ("gyro", "g_sensitivity"): -gyro @ unit.sensitivity}


def rows_of(calibration, unit):
    """Errors and uncertainties of all coefficients that are stated."""
    out = {}
    for (triad, term), true in truth_of(unit).items():
        value, u = (np.array(calibration[of][triad][term], dtype=float) for of in ("model", "standard_uncertainty"))
        for at in np.ndindex(np.shape(true)):
            if np.isfinite(u[at]) and u[at] > 0:
                out[f"{triad}.{term}{list(at)}"] = ((value - true)[at], u[at])
    return out
