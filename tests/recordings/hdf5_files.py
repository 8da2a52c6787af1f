"""h5py writes HDF5: datasets in groups, chunked and compressed, of compound elements, 3 x N, and in single precision with the most significant byte first."""
import h5py
import numpy as np
from imu import *

time = np.array([t(i) for i in range(SAMPLES)])
gyros = np.array([gyro(i) for i in range(SAMPLES)])
accels = np.array([accel(i) for i in range(SAMPLES)])
stamps = np.array([stamp_ns(i) for i in range(SAMPLES)])

with h5py.File("groups.h5", "w") as f:
    f["imu/t"] = time
    f["imu/stamp"] = stamps
    f["imu/gyro"] = gyros.astype(">f4")
    f["imu/gyro"].attrs["units"] = "rad/s"  # of varying length: not read
    f.create_dataset("imu/accel", data=accels, chunks=(7, 2), compression="gzip", shuffle=True)
    f["imu/accel"].attrs["units"] = np.bytes_("m/s^2")
    f.create_dataset("imu/counts", data=np.array([counts(i) for i in range(SAMPLES)], dtype="i2").T, chunks=(3, 16))  # 3 x N
    f["imu/names"] = ["x", "y", "z"]
    f["rate"] = 125.0
    f["imu/sampling_rate"] = 125.0
    f["baro/height"] = np.arange(10.0)

fields = np.zeros(SAMPLES, dtype=[("stamp", "<i8"), ("label", "S3"), ("gyro", ">f4", (3,)), ("imu", [("ax", "f8"), ("ay", "f8"), ("az", "<f4")])])
fields["stamp"] = stamps
fields["gyro"] = gyros
for k, name in enumerate(["ax", "ay", "az"]):
    fields["imu"][name] = accels[:, k]
with h5py.File("compound.h5", "w", libver="latest") as f:
    f["samples"] = fields
    f.attrs["fs"] = 125.0

with h5py.File("external.h5", "w") as f:  # numbers that are not in the file, but in another
    f.create_dataset("t", (SAMPLES,), "i1", external=[("/etc/passwd", 0, SAMPLES)])

with h5py.File("elsewhere.h5", "w") as f:  # what the library would give as zeros, or not at all
    for n, name in ((SAMPLES, "virtual"), (SAMPLES + 1, "partial"), (SAMPLES + 2, "unwritten"), (SAMPLES + 3, "packed")):
        if name == "virtual":
            layout = h5py.VirtualLayout(shape=(n,), dtype="f8")
            layout[:] = h5py.VirtualSource("groups.h5", "imu/t", shape=(n,))
            f.create_virtual_dataset(name, layout)
        elif name == "partial":
            f.create_dataset(name, (n,), "f8", chunks=(8,))[:8] = 1
        elif name == "unwritten":
            f.create_dataset(name, (n,), "f8")
        else:
            f.create_dataset(name, data=np.arange(float(n)), compression="lzf")
