// web/tests/page.mjs PAGE IMULAB PICTURES: the page in Chromium: each flow, wrong and hostile files, a cancelled work, no storage, offline, live by
// injected events; its answers against those of the native command.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { Browser, serve } from "./browser.mjs";

const [page, imulab, pictures] = process.argv.slice(2).map((name) => path.resolve(name));
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "imulab-page-"));
fs.mkdirSync(pictures, { recursive: true });
process.chdir(folder);
const native = (...words) => execFileSync(imulab, words, { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
const file = (name) => path.join(folder, name);
native("procedure", "handheld", "-o", "hand.toml");
native("simulate", "hand.toml", "-o", "session");
const recording = file("session/recording.csv");

const browser = await Browser.start();
const server = await serve(page);
const tab = await browser.page();
const text = (id) => tab.value(`document.getElementById("${id}").innerText`);
const shown = (id) => tab.until(`!document.getElementById("${id}").hidden`);
const set = (selector, value) => tab.value(`document.querySelector(${JSON.stringify(selector)}).value = ${JSON.stringify(value)}`);
const figures = {};

/** What a button of the page would save. */
const saved = (name) =>
  tab.value(`new Promise((done) => {
    const original = URL.createObjectURL;
    URL.createObjectURL = (blob) => (blob.text().then(done), (URL.createObjectURL = original), original(blob));
    HTMLAnchorElement.prototype.click = () => {};
    [...document.querySelectorAll("#saves button")].find((b) => b.textContent === "Save ${name}").click();
  })`);

/** The same model within a millionth of its uncertainties' scale: rounding reaches 1e-12. */
function assertSameModel(a, b) {
  const numbers = (value) => (typeof value === "number" ? [value] : value && typeof value === "object" ? Object.values(value).flatMap(numbers) : []);
  const [x, y] = [numbers(a), numbers(b)];
  assert.equal(x.length, y.length);
  x.forEach((value, i) => assert.ok(Math.abs(value - y[i]) <= 1e-9 * Math.max(1, Math.abs(y[i])), `${value} ${y[i]}`));
}

async function firstVisit() {
  const begin = Date.now();
  await tab.size(1280, 900);
  await tab.open(server.address);
  figures["ready, s"] = (Date.now() - begin) / 1000;
  assert.match(await text("version"), /^imulab \d/);
}

async function calibrateAFile() {
  await tab.choose("#files", [recording]);
  await shown("work");
  assert.equal(await text("inspection-headline"), "understood: calibrate with --method static or --method handheld");
  await set("[name=latitude_deg]", "45");
  await tab.click("#work-form [type=submit]");
  await shown("result");
  const native_text = native("calibrate", recording, "--method", "handheld", "--set", "latitude_deg=45", "--json");
  assertSameModel(JSON.parse(await saved("calibration.json")).model, JSON.parse(native_text).model);
  await tab.until("Number(document.querySelector('#result-page iframe').height) > 800");
  await tab.picture(path.join(pictures, "calibrated-1280.png"), "#result");
  await tab.size(390, 844, true);
  await tab.picture(path.join(pictures, "calibrated-390-dark.png"), "#result");
  await tab.picture(path.join(pictures, "inspected-390-dark.png"), "#inspection");
  assert.ok(await tab.value("document.documentElement.scrollWidth <= 390"), "wider than a phone");
  await tab.size(1280, 900);
  fs.writeFileSync(file("calibration.json"), await saved("calibration.json"));
}

async function exportAndCompensate() {
  await tab.until("document.getElementById('export-target').options.length > 5");
  await tab.value("document.querySelector('[value=compensate]').click()");
  await tab.click("#work-form [type=submit]");
  await tab.until("document.getElementById('saves').innerText.includes('compensated.csv')");
  const rows = (await saved("compensated.csv")).trim().split("\n");
  native("compensate", "calibration.json", recording, "--set", "latitude_deg=45", "-o", "native.csv");
  assert.equal(rows.length, fs.readFileSync("native.csv", "utf8").trim().split("\n").length);
}

async function noiseOfTheExample() {
  await tab.click("[data-example=rest]");
  await tab.until("document.getElementById('inspection-headline').innerText !== '' && !document.getElementById('work').hidden", 120);
  await tab.value("document.querySelector('[value=noise]').click()");
  await tab.click("#work-form [type=submit]");
  await shown("result");
  assert.equal(JSON.parse(await saved("noise.json")).axes.length, 6);
}

async function questions() {
  const rows = fs.readFileSync(recording, "utf8").trim().split("\n").slice(1).map((row) => row.split(",").slice(1).join(" "));
  fs.writeFileSync(file("unstamped.txt"), `${rows.join("\n")}\n`); // no stamps: the rate is asked for
  await tab.choose("#files", [file("unstamped.txt")]);
  await tab.until("!document.getElementById('questions').hidden");
  assert.match(await text("question-fields"), /^rate_hz: /);
  await tab.picture(path.join(pictures, "questions-1280.png"), "#inspection");
  await set("[name=rate_hz]", "100");
  await tab.click("#questions [type=submit]");
  await shown("work");
}

async function wrongFiles() {
  const hostile = "<img src=x onerror=alert(1)>\u001b[2J.csv";
  fs.writeFileSync(file(hostile), "no numbers here\n");
  await tab.choose("#files", [file(hostile)]);
  await tab.until("!document.getElementById('problem').hidden || !document.getElementById('inspection').hidden");
  assert.equal(await tab.value("document.querySelectorAll('main img').length"), 0);
  const bytes = Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919) % 256));
  for (const [name, content] of Object.entries({ "empty.csv": "", "bytes.bin": bytes, "matlab.mat": "MATLAB 5.0 MAT-file\n" })) {
    fs.writeFileSync(file(name), content);
    await tab.choose("#files", [file(name)]);
    await tab.until(`!document.getElementById('problem').hidden && document.getElementById('problem').innerText.includes(${JSON.stringify(name)})`);
  }
}

/** A grade changes what is assumed of the noise, and is in the session that can be saved. */
async function grade() {
  await tab.choose("#files", [recording]);
  await shown("work");
  for (const [name, value] of Object.entries({ grade: "mems", latitude_deg: "45", height_m: "" })) await set(`[name=${name}]`, value);
  await tab.click("#work-form [type=submit]");
  await shown("result");
  const session = await saved("session.toml");
  assert.match(session, /^grade = "mems"$/m);
  assert.match(session, /^latitude_deg = 45$/m);
  fs.writeFileSync(file("recording.csv"), fs.readFileSync(recording));
  fs.writeFileSync(file("graded.toml"), session);
  assertSameModel(JSON.parse(await saved("calibration.json")).model, JSON.parse(native("calibrate", "graded.toml", "--method", "handheld", "--json")).model);
  await set("[name=grade]", "");
}

/** What a browser refuses in a private window. */
async function withoutStorage() {
  const refused = await browser.page();
  const names = JSON.stringify(["localStorage", "sessionStorage", "indexedDB", "caches"]);
  const source = `{
    const refuse = { get() { throw new DOMException("denied", "SecurityError"); } };
    for (const name of ${names}) Object.defineProperty(globalThis, name, refuse);
    Object.defineProperty(Navigator.prototype, "serviceWorker", refuse);
  }`;
  await refused.send("Page.addScriptToEvaluateOnNewDocument", { source });
  await refused.open(server.address);
  await refused.choose("#files", [recording]);
  await refused.until("!document.getElementById('work').hidden");
  assert.deepEqual(refused.problems(), []);
}

/** Memory that runs out is an error in words, and the page goes on. */
async function outOfMemory() {
  const large = fs.openSync(file("large.csv"), "w");
  fs.ftruncateSync(large, 5_000_000_000);
  fs.closeSync(large);
  await tab.choose("#files", [file("large.csv")]);
  await tab.until("!document.getElementById('problem').hidden", 120);
  assert.match(await text("problem"), /^large\.csv: has .* GiB; expected less than 4 GiB on a 32-bit system/);
  await tab.choose("#files", [recording]);
  await shown("work");
}

async function cancel() {
  const head = fs.readFileSync(recording, "utf8").split("\n");
  const rows = head.slice(1, -1).map((row) => row.slice(row.indexOf(",")));
  const long = fs.openSync(file("long.csv"), "w");
  fs.writeSync(long, `${head[0]}\n`);
  for (let k = 0, i = 0; k < 12; ++k) fs.writeSync(long, `${rows.map((row) => `${(++i / 100).toFixed(2)}${row}`).join("\n")}\n`);
  fs.closeSync(long);
  await tab.choose("#files", [file("long.csv")]);
  await tab.until("!document.getElementById('cancel').disabled");
  await tab.click("#cancel");
  await tab.until("document.getElementById('progress').innerText === 'Cancelled.'", 2);
  await tab.choose("#files", [file("long.csv")]); // more than is copied: it is mapped
  await shown("work");
}

/** A recording of 10 MB: three times the turns. The same rows three times over would not do: that they repeat is a fault, which a fit searches for. */
async function speed() {
  const [head, first, ...steps] = fs.readFileSync(file("hand.toml"), "utf8").split("[[step]]");
  const again = [first.replace(/move_s = 0\b/, "move_s = 2"), ...steps];
  fs.writeFileSync(file("thrice.toml"), [head, first, ...steps, "\n", ...again, "\n", ...again].join("[[step]]").replaceAll("[[step]]\n[[step]]", "\n[[step]]"));
  native("simulate", "thrice.toml", "-o", "thrice");
  fs.renameSync(file("thrice/recording.csv"), file("ten.csv"));
  figures["10 MB"] = fs.statSync(file("ten.csv")).size;
  await tab.choose("#files", [file("ten.csv")]);
  figures["10 MB inspected, s"] = await shown("work");
  await set("[name=latitude_deg]", "45");
  await tab.click("#work-form [type=submit]");
  figures["10 MB calibrated, s"] = await tab.until("!document.getElementById('result').hidden", 300);
}

/** Samples of a recording as a phone's events, faster than it would give them, with accelerations of the other sign. */
async function live() {
  const session = native("simulate", "hand.toml", "-o", "other", "--seed", "2");
  assert.ok(session);
  const rows = fs.readFileSync(file("other/recording.csv"), "utf8").trim().split("\n").slice(1).filter((_, i) => i % 2 === 0);
  await tab.click("#go-live");
  await tab.until("document.getElementById('live-motion').onclick !== null");
  await tab.click("#live-motion");
  await tab.value(`window.rows = ${JSON.stringify(rows.map((row) => row.split(",").map(Number)))}; window.feed = (begin, end) => {
    for (const [t, gx, gy, gz, ax, ay, az] of window.rows.slice(begin, end)) {
      const event = new Event("devicemotion");
      const degrees = 180 / Math.PI;
      Object.defineProperty(event, "timeStamp", { value: 1000 * t });
      event.rotationRate = { beta: gx * degrees, gamma: gy * degrees, alpha: gz * degrees };
      event.accelerationIncludingGravity = { x: ax, y: ay, z: az };
      dispatchEvent(event);
    }
  }; window.feed(0, 4000)`);
  await tab.until("document.querySelector('#live-picture svg') !== null && document.getElementById('live-requirements').children.length > 0");
  assert.match(await text("live-state"), /rests in \d+ s\. .*Resolution: gyros/s);
  await tab.picture(path.join(pictures, "live-1280.png"), "#live");
  await tab.value("window.feed(4000, window.rows.length)");
  await tab.until("document.getElementById('live-stop').disabled", 300); // every requirement is met
  assert.match(await text("live-state"), /^\d+ rests in \d+ s\. Done/);
  await shown("work");
}

async function serial() {
  await tab.value(`{
    const rows = window.rows.map((row) => row.join(" ") + "\\r\\n").join("");
    const readable = new ReadableStream({ start(c) {
      for (let at = 0; at < rows.length; at += 5001) c.enqueue(new TextEncoder().encode(rows.slice(at, at + 5001)));
      c.close();
    } });
    Object.defineProperty(navigator, "serial", { value: { requestPort: async () => ({ open: async () => {}, close: async () => {}, readable }) } });
  }`);
  await tab.click("#live-serial");
  await tab.until("/Done/.test(document.getElementById('live-state').innerText)", 300);
}

async function offline() {
  await tab.value("navigator.serviceWorker.ready.then(() => true)");
  const before = server.requests.length;
  server.close();
  await tab.send("Network.emulateNetworkConditions", { offline: true, latency: 0, downloadThroughput: -1, uploadThroughput: -1 });
  await tab.open(server.address);
  await tab.choose("#files", [recording]);
  await shown("work");
  assert.equal(server.requests.length, before);
}

/** Everything that was asked for is a file of the page: nothing else left the machine. */
function expectOwnRequests() {
  const files = fs.readdirSync(page, { recursive: true }).map((name) => `/${name}`);
  for (const request of server.requests) assert.ok(files.includes(request), `asked for ${request}`);
  const asked = browser.events.filter((e) => e.method === "Network.requestWillBeSent").map((e) => e.params.request);
  for (const { url, method } of asked) assert.ok(method === "GET" && (url.startsWith(server.address) || /^(blob|data|about):/.test(url)), url);
}

try {
  for (const step of [firstVisit, calibrateAFile, exportAndCompensate, noiseOfTheExample, questions, grade, wrongFiles, withoutStorage, outOfMemory, cancel, speed, live, serial, offline]) {
    const begin = Date.now();
    await step();
    console.log(`page: ${step.name} ${((Date.now() - begin) / 1000).toFixed(1)} s`);
  }
  expectOwnRequests();
  assert.deepEqual(tab.problems(), []);
  console.log("page:", figures);
} finally {
  await browser.close();
  server.close();
  process.chdir("/");
  fs.rmSync(folder, { recursive: true, force: true });
}
