// Live: rows of a phone's sensors or of a serial port; the verb `live` says again and again which turns are missing.
import { command, inspect } from "./module/imulab.js";
import { turnPicture } from "./picture.js";
import { keysOf, questionFields } from "./questions.js";
import { saveButton } from "./save.js";

/** @param {string} id @returns {any} */
const at = (id) => document.getElementById(id);
/** @param {string} text */
const say = (text) => (at("live-state").textContent = text);

/** One stream while it comes. */
class Stream {
  /** @type {string[]} */ rows = [];
  /** @type {string | Uint8Array | null} */ session = null;
  ended = false;
  /** @type {() => void} */ close = () => {};
  seen = 0;
  note = "";

  text() {
    return `${this.rows.join("\n")}\n`;
  }
}

/** @type {Stream | null} */
let stream = null;
/** @type {(files: Record<string, string>, declared: Record<string, string>) => void} */
let openLog = () => {};

// A phone's sensors: W3C's accelerationIncludingGravity [m/s^2] and rotationRate [deg/s], whose alpha is about z, beta about x and gamma about y.

const phoneSession = (/** @type {string} */ latitude) => `format = "imulab.session/1"
[imu]
name = "phone"
[site]
latitude_deg = ${Number(latitude)}
[[recording]]
file = "live.csv"
time = { column = "t", unit = "s", zero = 0 }
gyro = { columns = ["gx", "gy", "gz"], output = "rate", unit = "deg/s" }
accel = { columns = ["ax", "ay", "az"], output = "rate", unit = "m/s^2" }
`;

/** The smallest step between readings that differ. @param {number[]} values */
function resolution(values) {
  const sorted = [...new Set(values)].sort((a, b) => a - b);
  return sorted.slice(1).reduce((least, value, i) => Math.min(least, value - sorted[i]), Infinity);
}

async function startMotion() {
  const sensor = /** @type {any} */ (globalThis.DeviceMotionEvent);
  if (!sensor) return say("This browser has no motion sensors.");
  if ((await sensor.requestPermission?.()) === "denied") return say("The browser refuses its motion sensors.");
  const own = begin(phoneSession(at("live-latitude").value));
  own.rows.push("t,gx,gy,gz,ax,ay,az");
  /** @type {number[][]} */
  const first = [];
  let sign = 0;
  let zero = NaN;
  const take = (/** @type {any} */ event) => {
    const { accelerationIncludingGravity: a, rotationRate: w, timeStamp } = event;
    if (a?.z == null || w?.alpha == null) return say("This device has no accelerometer or no gyro.");
    if (Number.isNaN(zero)) zero = timeStamp;
    const row = [(timeStamp - zero) / 1000, w.beta, w.gamma, w.alpha, a.x, a.y, a.z];
    if (sign === 0) {
      first.push(row);
      say("Lay the phone on its back, screen up, and hold it still.");
      if (row[0] < 1) return;
      sign = first.reduce((sum, r) => sum + r[6], 0) < 0 ? -1 : 1; // at rest a positive reading is up
      const step = (/** @type {number} */ from) => resolution(first.flatMap((r) => r.slice(from, from + 3))).toPrecision(2);
      own.note = `Resolution: gyros ${step(1)} deg/s, accelerometers ${step(4)} m/s².${sign < 0 ? " Signs of the accelerometers reversed." : ""}`;
      for (const r of first) own.rows.push(rowText(r, sign));
    } else own.rows.push(rowText(row, sign));
  };
  addEventListener("devicemotion", take);
  own.close = () => removeEventListener("devicemotion", take);
  watch(own);
}

/** @param {number[]} row @param {number} sign */
const rowText = ([t, ...rest], sign) => [t.toFixed(6), ...rest.slice(0, 3), ...rest.slice(3).map((v) => sign * v)].join(",");

// A serial port: a line of text a sample, whose columns `inspect` recognizes.

async function startSerial() {
  const serial = /** @type {any} */ (navigator).serial;
  if (!serial) return say("This browser has no Web Serial; Chromium on a computer has.");
  const port = await serial.requestPort();
  await port.open({ baudRate: Number(at("live-baud").value) });
  const own = begin(null);
  const reader = port.readable.pipeThrough(new TextDecoderStream()).getReader();
  own.close = () => reader.cancel().catch(() => {}).then(() => port.close?.());
  watch(own);
  let rest = "";
  for (let first = true; ; ) {
    const { value, done } = await reader.read();
    if (done) break;
    const lines = (rest + value).split(/\r?\n/);
    rest = lines.pop() ?? "";
    if (first && lines.length > 0) lines.shift(), (first = false); // it may have begun in the middle
    own.rows.push(...lines.filter((line) => line !== ""));
  }
  own.ended = true;
}

const rowsInspected = 1500;

/** The session of a serial port's rows, once enough of them are here and the questions are answered. @param {Stream} own */
async function sessionOf(own) {
  if (own.rows.length < rowsInspected && !own.ended) return say(`Reading: ${own.rows.length} of ${rowsInspected} rows; turn the unit meanwhile.`);
  const asked = [...at("live-questions").children].map((question) => [...question.querySelectorAll("input")]);
  if (asked.some((fields) => fields.every((field) => field.value === ""))) return;
  const fields = asked.flat().filter((field) => field.value !== "");
  const set = { latitude_deg: at("live-latitude").value, ...Object.fromEntries(fields.map((field) => [field.name, field.value])) };
  const answer = await inspect({ "live.csv": own.text() }, { set });
  own.session = answer.files["session.toml"] ?? null;
  if (own.session) return at("live-questions").replaceChildren();
  say(answer.data.headline);
  const keys = new Set(asked.flat().map((field) => field.name));
  const open = answer.data.ambiguous.filter((/** @type {string} */ text) => !keysOf(text).every((key) => keys.has(key)));
  at("live-questions").append(...open.map((/** @type {string} */ text) => questionFields(text, {}, [])));
}

// What is missing

/** @param {Stream} own */
async function advise(own) {
  if (!own.session) await sessionOf(own);
  if (!own.session) return;
  const words = ["live", "live.csv", "--session", "session.toml", "--json"];
  const { code, output, messages } = await command(words, { "live.csv": own.text(), "session.toml": own.session });
  const last = new TextDecoder().decode(output).trim().split("\n").pop();
  if (!last) return say(own.rows.length > 1 ? messages.replaceAll("imulab: ", "") : "Waiting for rows.");
  show(JSON.parse(last), own);
  if (code === 0) stop();
}

/** @param {any} view @param {Stream} own */
function show(view, own) {
  const time = `${view.rests} rests in ${view.time_s.toFixed(0)} s`;
  const next = view.next ? `Next: ${view.next}` : !view.done && !view.problem && "No turn is missing, but the data contradict: stop, and compute";
  const parts = [time, view.done && "Done: every requirement is met", view.problem, next];
  say(`${parts.filter(Boolean).join(". ")}. ${own.note}`);
  at("live-picture").replaceChildren(turnPicture(view.up ?? "", view.next ?? ""));
  at("live-requirements").replaceChildren(
    ...view.requirements.map((/** @type {any} */ r) =>
      Object.assign(document.createElement("li"), { textContent: `${r.met ? "met" : r.reached === null ? "not determined" : "not yet"}: ${r.text}` }),
    ),
  );
}

/** @param {string | null} session */
function begin(session) {
  stop();
  stream = Object.assign(new Stream(), { session });
  at("live-stop").disabled = false;
  for (const id of ["live-questions", "live-saves"]) at(id).replaceChildren();
  say("Waiting for rows.");
  return stream;
}

/** @param {Stream} own */
async function watch(own) {
  let took = 0; // of the last advice, ms: all rows are read again, and at most half of the time is spent so
  while (stream === own) {
    await new Promise((ready) => setTimeout(ready, Math.max(1000, took)));
    if (stream !== own) return;
    const ended = own.ended;
    if (own.rows.length > own.seen || !own.session) {
      own.seen = own.rows.length;
      const begin = performance.now();
      await advise(own).catch((error) => say(error.message));
      took = performance.now() - begin;
    }
    if (ended && own.session) stop();
  }
}

/** Ends the stream; what came is a log like any other. */
function stop() {
  const own = stream;
  stream = null;
  at("live-stop").disabled = true;
  if (!own) return;
  own.close();
  if (own.rows.length < 2) return;
  /** @type {Record<string, string>} */
  const files = { "live.csv": own.text() };
  const saved = { ...files, ...(own.session ? { "session.toml": own.session } : {}) };
  at("live-saves").replaceChildren(...Object.entries(saved).map(([name, content]) => saveButton(name, content)));
  openLog(files, { latitude_deg: at("live-latitude").value });
}

/** @param {typeof openLog} open takes the recording at the end */
export function startLive(open) {
  openLog = open;
  at("live-motion").onclick = () => startMotion().catch((error) => say(error.message));
  at("live-serial").onclick = () => startSerial().catch((error) => say(error.message));
  at("live-stop").onclick = stop;
}
