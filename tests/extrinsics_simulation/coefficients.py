"""Coefficients of a calibration file against those of a simulated IMU."""

import numpy as np


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
