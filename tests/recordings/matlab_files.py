"""SciPy writes .mat of versions 4 and 5; h5py writes the structure of version 7.3 (HDF5 after a block of 512 bytes, a class on each dataset)."""
import h5py
import numpy as np
from imu import *
from scipy.io import savemat

time = np.array([t(i) for i in range(SAMPLES)])
gyros = np.array([gyro(i) for i in range(SAMPLES)])
accels = np.array([accel(i) for i in range(SAMPLES)])
increments = np.array([[*[g / 125 for g in gyro(i)], *[a / 125 for a in accel(i)], t(i)] for i in range(SAMPLES)])
stamps = np.array([stamp_ns(i) for i in range(SAMPLES)])
number = np.array([counts(i) for i in range(SAMPLES)], dtype=np.int16)

savemat("v4.mat", {"t": time, "gyro": gyros, "accel": accels, "rate": 125.0}, format="4", oned_as="column")
variables = {"t": time, "stamp": stamps, "imu": {"gyro": gyros, "accel": accels.T, "counts": number}, "single": gyros.astype("f4"), "rate": 125.0, "unit": "rad/s"}
savemat("v5.mat", variables, oned_as="row")
savemat("v5_compressed.mat", variables, do_compression=True, oned_as="row")
savemat("psins.mat", {"imu": increments}, do_compression=True)

def set_class(thing, name):  # as MATLAB does: a text of this length that ends with a zero where there is room
    kind = h5py.h5t.C_S1.copy()
    kind.set_size(len(name))
    kind.set_strpad(h5py.h5t.STR_NULLTERM)
    attribute = h5py.h5a.create(thing.id, b"MATLAB_class", kind, h5py.h5s.create(h5py.h5s.SCALAR))
    attribute.write(np.array(name, dtype=f"S{len(name)}"), mtype=kind)


with h5py.File("v73.mat", "w", userblock_size=512) as f:
    def put(group, name, values, kind):
        data = group.create_dataset(name, data=np.atleast_2d(values).T.copy() if values.ndim == 2 else values.reshape(-1, 1), compression="gzip")
        set_class(data, kind)

    put(f, "t", time, "double")
    put(f, "stamp", stamps, "int64")
    imu = f.create_group("imu")
    set_class(imu, "struct")
    names = np.array([np.array(list(name), dtype="S1") for name in ["gyro", "accel"]], dtype=object)
    imu.attrs.create("MATLAB_fields", names, dtype=h5py.vlen_dtype(np.dtype("S1")))
    put(imu, "gyro", gyros, "double")
    put(imu, "accel", accels, "double")
with open("v73.mat", "r+b") as f:
    f.write(b"MATLAB 7.3 MAT-file, written by h5py".ljust(116) + bytes(8) + b"\x00\x02IM")
