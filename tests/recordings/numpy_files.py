"""NumPy 1.24 writes the .npy and .npz files."""
import numpy as np
from imu import *

everything = np.array(rows())
gyros = np.array([gyro(i) for i in range(SAMPLES)])
accels = np.array([accel(i) for i in range(SAMPLES)])
stamps = np.array([stamp_ns(i) for i in range(SAMPLES)], dtype=np.int64)

np.save("rows.npy", everything)
np.save("rows_f4_big.npy", everything.astype(">f4"))
np.save("rows_fortran.npy", np.asfortranarray(everything))
np.save("lying.npy", everything.T.copy())  # 7 x N
np.save("stamps.npy", stamps)
fields = np.zeros(SAMPLES, dtype=[("stamp", "<i8"), ("label", "S3"), ("gyro", ">f4", (3,)), ("imu", [("ax", "f8"), ("ay", "f8"), ("az", "<f4")])])
fields["stamp"] = stamps
fields["label"] = b"abc"
fields["gyro"] = gyros
for k, name in enumerate(["ax", "ay", "az"]):
    fields["imu"][name] = accels[:, k]
np.save("fields.npy", fields)

arrays = {
    "gyro": gyros.astype("f2"),
    "accel": np.asfortranarray(accels),
    "stamp": stamps.astype("u8"),
    "time": stamps.astype("M8[ns]"),
    "counts": np.array([counts(i) for i in range(SAMPLES)], dtype=">i2").T.copy(),  # 3 x N
    "flags": np.array([i % 2 == 0 for i in range(SAMPLES)]),
    "rate": np.array(125.0),
    "unit": np.array("rad/s"),
}
np.savez("arrays.npz", **arrays)
np.savez_compressed("arrays_deflated.npz", **arrays)
most = slice(0, SAMPLES - 3)
np.savez_compressed("two_lengths.npz", gyro_t=stamps, gyro=gyros, accel_t=stamps[most], accel=accels[most])
