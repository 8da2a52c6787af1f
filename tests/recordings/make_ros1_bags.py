"""Writes imu_none.bag, imu_bz2.bag, imu_lz4.bag and sparse.bag with ROS's own library: Debian's python3-rosbag. Run by hand; the bags are in the tree."""

import sys

import genpy
import genpy.dynamic
import rosbag

import bag_data as data

LINE = "=" * 80 + "\n"
HEADER = "uint32 seq\ntime stamp\nstring frame_id\n"
IMU = ("std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
       "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
       "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n"
       + LINE + "MSG: std_msgs/Header\n" + HEADER
       + LINE + "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
       + LINE + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n")
TEMPERATURE = "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n" + LINE + "MSG: std_msgs/Header\n" + HEADER
IMAGE = "std_msgs/Header header\nstring format\nuint8[] data\n" + LINE + "MSG: std_msgs/Header\n" + HEADER


def message_class(name, text):
    return genpy.dynamic.generate_dynamic(name, text)[name]


def ros_time(ns):
    return genpy.Time(ns // 10**9, ns % 10**9)


def fill_header(message, i, frame):
    message.header.seq = i
    message.header.stamp = ros_time(data.stamp_ns(i))
    message.header.frame_id = frame
    return message


def write(path, compression, samples=data.SAMPLES, picture_size=768, chunk=6000):
    Imu, Temperature = message_class("sensor_msgs/Imu", IMU), message_class("sensor_msgs/Temperature", TEMPERATURE)
    Image = message_class("sensor_msgs/CompressedImage", IMAGE)
    with rosbag.Bag(path, "w", compression=compression, chunk_threshold=chunk) as bag:
        for i in range(samples):
            at = ros_time(data.log_ns(i))
            imu = fill_header(Imu(), i, "imu")
            imu.orientation.x, imu.orientation.y, imu.orientation.z, imu.orientation.w = data.orientation(i)
            imu.orientation_covariance = data.covariance(-1)
            imu.angular_velocity.x, imu.angular_velocity.y, imu.angular_velocity.z = data.gyro(i)
            imu.angular_velocity_covariance = data.covariance(0.25)
            imu.linear_acceleration.x, imu.linear_acceleration.y, imu.linear_acceleration.z = data.accel(i)
            imu.linear_acceleration_covariance = data.covariance(0.5)
            bag.write("/imu0", imu, at)
            if i % data.TEMPERATURE_EVERY == 0:
                t = fill_header(Temperature(), i, "imu")
                t.temperature, t.variance = data.temperature(i), 0.125
                bag.write("/temp", t, at)
            if i % data.IMAGE_EVERY == 0:
                picture = fill_header(Image(), i, "cam0")
                picture.format, picture.data = "raw", data.image(i, picture_size)
                bag.write("/cam0", picture, at)


folder = sys.argv[1] if len(sys.argv) > 1 else "."
for compression in ("none", "bz2", "lz4"):
    write(f"{folder}/imu_{compression}.bag", compression)
write(f"{folder}/sparse.bag", "none", data.SPARSE_SAMPLES, data.SPARSE_IMAGE, 1 << 20)
