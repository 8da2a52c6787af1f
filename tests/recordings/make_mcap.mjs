// Writes imu_none.mcap, imu_lz4.mcap, imu_zstd.mcap, imu_no_chunks.mcap, imu_big_endian.mcap, imu_ros1.mcap, sparse.mcap,
// imu_no_message_index.mcap and imu_bare.mcap (with nothing that a writer may leave out of the summary) with Foxglove's libraries (npm: @mcap/core, @foxglove/cdr,
// @foxglove/rosmsg, @foxglove/rosmsg-serialization, @foxglove/rosmsg2-serialization, @foxglove/wasm-zstd, lz4js). Run by hand; the files are in the tree. The numbers are those of bag_data.py.
import { McapWriter } from "@mcap/core";
import { CdrWriter, EncapsulationKind } from "@foxglove/cdr";
import { parse } from "@foxglove/rosmsg";
import { MessageWriter as Ros1Writer } from "@foxglove/rosmsg-serialization";
import { MessageWriter } from "@foxglove/rosmsg2-serialization";
import zstd from "@foxglove/wasm-zstd";
import lz4 from "lz4js";
import { writeFileSync } from "node:fs";

const FIRST_NS = 1_700_000_000_123_456_789n, INTERVAL_NS = 5_000_000n, SAMPLES = 60, IMAGE_EVERY = 20, TEMPERATURE_EVERY = 10;
const stampNs = (i) => FIRST_NS + BigInt(i) * INTERVAL_NS;
const logNs = (i) => stampNs(i) + 1_000_000n + 1000n * BigInt(i);
const vector = ([x, y, z]) => ({ x, y, z });
const covariance = (first) => [first, 0, 0, 0, first, 0, 0, 0, first];
const header = (i, frame) => ({ stamp: { sec: Number(stampNs(i) / 1_000_000_000n), nanosec: Number(stampNs(i) % 1_000_000_000n) }, frame_id: frame });

const imu = (i) => ({
  header: header(i, "imu"),
  orientation: { x: 0, y: 0, z: 0, w: 1 },
  orientation_covariance: covariance(-1),
  angular_velocity: vector([(i - 30) / 1024, ((7 * i) % 16) / 512, -i / 256]),
  angular_velocity_covariance: covariance(0.25),
  linear_acceleration: vector([i / 64, -(i % 5) / 32, 9.8125]),
  linear_acceleration_covariance: covariance(0.5),
});
const temperature = (i) => ({ header: header(i, "imu"), temperature: 20 + i / 16, variance: 0.125 });
const image = (i, size) => {
  const data = new Uint8Array(size);
  let state = BigInt(i + 1);
  for (let k = 0; k < data.length; ++k) {
    state = (1103515245n * state + 12345n) % 2n ** 31n;
    data[k] = k % 2 ? Number((state >> 16n) & 255n) : 7;
  }
  return { header: header(i, "cam0"), format: "raw", data };
};

const LINE = "=".repeat(80) + "\n";
const COMMON = LINE + "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + LINE + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const TYPES = {
  "sensor_msgs/msg/Imu":
    "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n" +
    "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n" +
    "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n" +
    LINE + "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n" + LINE + "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" + COMMON,
  "sensor_msgs/msg/Temperature": "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n" + COMMON,
  "sensor_msgs/msg/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n" + COMMON,
};

// MessageWriter with the most significant byte first.
function bigEndian(type, m) {
  const cdr = new CdrWriter({ kind: EncapsulationKind.CDR_BE });
  cdr.int32(m.header.stamp.sec).uint32(m.header.stamp.nanosec).string(m.header.frame_id);
  const numbers = (...list) => list.flat().forEach((x) => cdr.float64(x));
  if (type.endsWith("Imu"))
    numbers(Object.values(m.orientation), m.orientation_covariance, Object.values(m.angular_velocity), m.angular_velocity_covariance,
            Object.values(m.linear_acceleration), m.linear_acceleration_covariance);
  else if (type.endsWith("Temperature")) numbers(m.temperature, m.variance);
  else cdr.string(m.format).uint8Array(m.data, true);
  return cdr.data;
}

// The header of ROS 1 has a sequence number, and its time is a type of the language.
const ros1Definition = (text) =>
  text.replace("builtin_interfaces/Time stamp", "uint32 seq\ntime stamp").replace(LINE + "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n", "");

class Memory {
  parts = [];
  size = 0n;
  async write(bytes) {
    this.parts.push(Uint8Array.from(bytes));
    this.size += BigInt(bytes.byteLength);
  }
  position() {
    return this.size;
  }
}

async function write(path, options, { big = false, ros1 = false, samples = SAMPLES, pictureSize = 768 } = {}) {
  const writable = new Memory();
  const writer = new McapWriter({ writable, chunkSize: 6000, ...options });
  await writer.start({ profile: ros1 ? "ros1" : "ros2", library: "fixture" });
  const channels = {};
  for (const [topic, schema] of [["/imu0", "sensor_msgs/msg/Imu"], ["/temp", "sensor_msgs/msg/Temperature"], ["/cam0", "sensor_msgs/msg/CompressedImage"]]) {
    const definition = ros1 ? ros1Definition(TYPES[schema]) : TYPES[schema];
    const schemaId = await writer.registerSchema({
      name: ros1 ? schema.replace("/msg", "") : schema, encoding: ros1 ? "ros1msg" : "ros2msg", data: new TextEncoder().encode(definition) });
    const id = await writer.registerChannel({ schemaId, topic, messageEncoding: ros1 ? "ros1" : "cdr", metadata: new Map([["offered_qos_profiles", ""]]) });
    const messages = ros1 ? new Ros1Writer(parse(definition)) : new MessageWriter(parse(definition, { ros2: true }));
    let sequence = 0;
    channels[topic] = async (i, message) => {
      if (ros1) message.header = { seq: i, stamp: { sec: message.header.stamp.sec, nsec: message.header.stamp.nanosec }, frame_id: message.header.frame_id };
      const data = big ? bigEndian(schema, message) : messages.writeMessage(message);
      await writer.addMessage({ channelId: id, sequence: sequence++, logTime: logNs(i), publishTime: stampNs(i), data });
    };
  }
  for (let i = 0; i < samples; ++i) {
    await channels["/imu0"](i, imu(i));
    if (i % TEMPERATURE_EVERY === 0) await channels["/temp"](i, temperature(i));
    if (i % IMAGE_EVERY === 0) await channels["/cam0"](i, image(i, pictureSize));
    if (i === 40) {
      await writer.addMetadata({ name: "place", metadata: new Map([["room", "12"]]) });
      await writer.addAttachment({ logTime: logNs(i), createTime: 0n, name: "note.txt", mediaType: "text/plain", data: new TextEncoder().encode("a note") });
    }
  }
  await writer.end();
  writeFileSync(path, Buffer.concat(writable.parts));
}

await zstd.isLoaded;
const folder = process.argv[2] ?? ".";
const packing = (compression, pack) => ({ compressChunk: (bytes) => ({ compression, compressedData: pack(bytes) }) });
await write(`${folder}/imu_none.mcap`, {});
await write(`${folder}/imu_lz4.mcap`, packing("lz4", (bytes) => lz4.compress(bytes)));
await write(`${folder}/imu_zstd.mcap`, packing("zstd", (bytes) => zstd.compress(bytes, 3)));
await write(`${folder}/imu_no_chunks.mcap`, { useChunks: false });
await write(`${folder}/imu_big_endian.mcap`, packing("zstd", (bytes) => zstd.compress(bytes, 3)), { big: true });
await write(`${folder}/imu_ros1.mcap`, packing("lz4", (bytes) => lz4.compress(bytes)), { ros1: true });
await write(`${folder}/sparse.mcap`, { chunkSize: 1 << 20 }, { samples: 4, pictureSize: 40_000 });
await write(`${folder}/imu_no_message_index.mcap`, { useMessageIndex: false });
const bare = Object.fromEntries(["repeatSchemas", "useStatistics", "useSummaryOffsets", "useAttachmentIndex", "useMetadataIndex"].map((what) => [what, false]));
await write(`${folder}/imu_bare.mcap`, { ...packing("zstd", (bytes) => zstd.compress(bytes, 3)), ...bare });
