"""Writes imu.db3: a ROS 2 bag in SQLite, with the tables of rosbag2 (schema version 3) and CDR packed here. Run by hand; the bag is in the tree."""

import sqlite3
import struct
import sys

import bag_data as data


class Cdr:
    """Little endian: numbers are aligned to their size, counted after the four bytes of encapsulation."""

    def __init__(self):
        self.body = bytearray()

    def put(self, code, *values):
        size = struct.calcsize("<" + code)
        for value in values:
            self.body += b"\0" * (-len(self.body) % size)
            self.body += struct.pack("<" + code, value)
        return self

    def text(self, text):
        self.put("I", len(text) + 1)
        self.body += text.encode() + b"\0"
        return self

    def message(self):
        return b"\0\1\0\0" + bytes(self.body)


def header(i, frame):
    return Cdr().put("i", data.stamp_ns(i) // 10**9).put("I", data.stamp_ns(i) % 10**9).text(frame)


def imu(i):
    m = header(i, "imu_link")
    m.put("d", *data.orientation(i), *data.covariance(-1), *data.gyro(i), *data.covariance(0.25), *data.accel(i), *data.covariance(0.5))
    return m.message()


def temperature(i):
    return header(i, "imu_link").put("d", data.temperature(i), 0.125).message()


def image(i):
    picture = header(i, "cam0").text("raw").put("I", len(data.image(i)))
    picture.body += data.image(i)
    return picture.message()


path = sys.argv[1] if len(sys.argv) > 1 else "imu.db3"
bag = sqlite3.connect(path)
bag.executescript("""
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES (3, 'humble');
""")
for number, (topic, kind) in enumerate([("/imu0", "Imu"), ("/temp", "Temperature"), ("/cam0", "CompressedImage")], 1):
    bag.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, topic, "sensor_msgs/msg/" + kind))
for i in range(data.SAMPLES):
    rows = [(1, imu(i))]
    if i % data.TEMPERATURE_EVERY == 0:
        rows.append((2, temperature(i)))
    if i % data.IMAGE_EVERY == 0:
        rows.append((3, image(i)))
    bag.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", [(t, data.log_ns(i), m) for t, m in rows])
bag.commit()
bag.close()
