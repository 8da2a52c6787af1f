"""Rows of binary numbers: NumPy's tofile, and seven doubles a row as PSINS's binfile.m writes them (fwrite(fid, data', 'double'))."""
import numpy as np
from imu import *

imu = np.array([[*[g / 125 for g in gyro(i)], *[a / 125 for a in accel(i)], t(i)] for i in range(SAMPLES)])  # increments, then time
imu.astype("<f8").tofile("psins.bin")
mixed = np.zeros(SAMPLES, dtype=[("us", ">u4"), ("counts", ">i2", (3,)), ("accel", "<f4", (3,)), ("flag", "u1")])
for i in range(SAMPLES):
    mixed[i] = (8000 * (i + 1), counts(i), accel(i), i % 2)
with open("mixed.bin", "wb") as f:
    f.write(b"LOGGER-1" + bytes(8))  # a head of 16 bytes
    mixed.tofile(f)
