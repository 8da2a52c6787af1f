"""walk.zip: a text for each sensor, as a telephone's logger writes them. Python 3."""

import zipfile

import imu


def table(readings):
    rows = [",".join([str(imu.stamp_ns(i)), *(repr(v) for v in readings(i))]) for i in range(imu.SAMPLES)]
    return "\n".join(["time,x,y,z", *rows, ""])


with zipfile.ZipFile("walk.zip", "w", zipfile.ZIP_DEFLATED) as archive:
    for name, readings in (("Gyroscope.csv", imu.gyro), ("TotalAcceleration.csv", imu.accel)):
        archive.writestr(zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0)), table(readings), zipfile.ZIP_DEFLATED)
