// web/tests/page.mjs PAGE IMULAB PICTURES [LOGS...]: the page in Chromium: each flow, wrong and hostile files, a cancelled work, no storage, offline, live by
// injected events; its answers against those of the native command.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { Browser, serve } from "./browser.mjs";
import { sameWordsAsNative } from "./records.mjs";
import { Unit } from "./unit.mjs";

const [page, imulab, pictures, ...logs] = process.argv.slice(2).map((name) => path.resolve(name));
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
    [...document.querySelectorAll("button")].find((b) => b.textContent === "Save ${name}").click();
  })`);

/** The same model within a millionth of its uncertainties' scale: rounding reaches 1e-12. */
function assertSameModel(a, b) {
  const numbers = (value) => (typeof value === "number" ? [value] : value && typeof value === "object" ? Object.values(value).flatMap(numbers) : []);
  const [x, y] = [numbers(a), numbers(b)];
  assert.equal(x.length, y.length);
  x.forEach((value, i) => assert.ok(Math.abs(value - y[i]) <= 1e-9 * Math.max(1, Math.abs(y[i])), `${value} ${y[i]}`));
}

async function firstVisit() {
  const line = (rate) => tab.send("Network.emulateNetworkConditions", { offline: false, latency: 0, downloadThroughput: rate, uploadThroughput: rate });
  await tab.size(1280, 900);
  await line(10e6 / 8); // bytes a second
  const begin = Date.now();
  await tab.open(server.address);
  figures["ready at 10 Mbit/s, s"] = (Date.now() - begin) / 1000;
  await line(-1);
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

/** What belongs to a log goes with it; a calibration stays, is shown, and is asked about where a session has another serial number. */
async function anotherUnit() {
  await tab.choose("#files", [recording]);
  await tab.until("document.getElementById('result').hidden");
  await shown("work");
  assert.deepEqual(await tab.value("['latitude_deg', 'gravity_mps2', 'grade'].map((name) => document.querySelector(`[name=${name}]`).value)"), ["", "", ""]);
  await tab.value("document.querySelector('[value=compensate]').click()");
  assert.match(await text("calibration-shown"), /^calibration of recording, no serial number \(handheld, \d{4}-\d\d-\d\d \d\d:\d\d\), from recording\.csv$/);
  fs.mkdirSync("b");
  fs.copyFileSync(recording, "b/recording.csv");
  fs.writeFileSync("b/session.toml", fs.readFileSync("session/session.toml", "utf8").replace("[imu]", '[imu]\nserial = "B"'));
  fs.writeFileSync("b/A.json", JSON.stringify({ ...JSON.parse(fs.readFileSync("calibration.json", "utf8")), serial: "A" }));
  await tab.choose("#files", ["b/recording.csv", "b/session.toml", "b/A.json"].map(file));
  await tab.until("document.getElementById('work').hidden");
  await shown("work");
  assert.match(await text("inspection-headline"), /^understood: /);
  assert.ok(await tab.value("document.getElementById('site').hidden"), "the session declares it");
  await tab.value("document.querySelector('[value=compensate]').click()");
  assert.match(await text("calibration-shown"), /serial A \(handheld, .*\), from A\.json$/);
  await tab.click("#work-form [type=submit]");
  await shown("problem");
  assert.match(await text("problem"), /^The log is of serial B, the calibration of A: apply it all the same\?$/);
  await tab.click("[name=other_unit]");
  await tab.click("#work-form [type=submit]");
  await tab.until("document.getElementById('saves').innerText.includes('compensated.csv')");
}

/** A question about two keys has two fields; choices say what they mean. */
async function twoKeys() {
  const rows = Array.from({ length: 300 }, (_, i) => Array.from({ length: 7 }, (_, k) => (k === 0 ? i / 100 : Math.sin(i * (k + 1)))).join(","));
  fs.writeFileSync(file("bare.csv"), `${rows.join("\n")}\n`);
  await tab.choose("#files", [file("bare.csv")]);
  await tab.until("document.getElementById('question-fields').innerText.startsWith('accel.columns, gyro.columns: ')");
  for (const [key, columns] of [["gyro", "2,3,4"], ["accel", "5,6,7"]]) await set(`[name='${key}.columns']`, columns);
  await tab.click("#questions [type=submit]");
  await tab.until("/^gyro.unit: |\\ngyro.unit: /.test(document.getElementById('question-fields').innerText)");
}

/** Compressed logs; of an archive of two, one is asked for. */
async function archives() {
  const [head, ...rows] = fs.readFileSync(recording, "utf8").split("\n");
  fs.mkdirSync("two");
  fs.writeFileSync("two/first.csv", [head, ...rows].join("\n"));
  fs.writeFileSync("two/second.csv", [head.replace(/^t,/, "time_s,"), ...rows].join("\n"));
  execFileSync("tar", ["-czf", "two.tgz", "-C", "two", "first.csv", "second.csv"]);
  execFileSync("xz", ["-1k", "two/first.csv"]);
  await tab.choose("#files", [file("two/first.csv.xz")]);
  await shown("work");
  await tab.choose("#files", [file("two.tgz")]);
  await tab.until("document.getElementById('question-fields').innerText.startsWith('topic: first, second')");
  assert.match(await text("problem"), /^two\.tgz: several tables .* expected a topic of first, second$/);
  await set("[name=topic]", "second");
  await tab.click("#questions [type=submit]");
  await shown("work");
  assert.ok((await text("columns")).includes("time_s"));
  await set("[name=latitude_deg]", "45"); // inspected anew
  await tab.click("#work-form [type=submit]");
  await shown("result");
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
  await tab.send("Page.bringToFront"); // a browser slows what is behind
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

/** Half a gigabyte at rest: mapped in pieces, inspected, and its noise. */
async function large() {
  const head = fs.readFileSync(file("hand.toml"), "utf8");
  fs.writeFileSync(file("still.toml"), `${head.slice(0, head.indexOf("[[step]]"))}[[step]]\nkind = "hold"\nduration_s = 38000\n`);
  native("simulate", "still.toml", "-o", "still");
  const log = file("still/recording.csv");
  figures["large, MB"] = fs.statSync(log).size / 1e6;
  const begin = Date.now();
  await tab.choose("#files", [log]);
  await tab.until("!document.getElementById('questions').hidden", 300);
  figures["large inspected, s"] = (Date.now() - begin) / 1000;
  await set("[name='gyro.unit']", "rad/s");
  await tab.click("#questions [type=submit]");
  await tab.until("!document.getElementById('work').hidden", 300);
  await set("[name=latitude_deg]", ""); // with a new site it would be inspected anew
  await tab.value("document.querySelector('[value=noise]').click()");
  await tab.click("#work-form [type=submit]");
  figures["noise of large, s"] = await tab.until("!document.getElementById('result').hidden", 300);
  assert.equal(JSON.parse(await saved("noise.json")).axes.length, 6);
  fs.rmSync(log);
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
  await tab.value("work.hidden = true");
  const begin = Date.now();
  await tab.choose("#files", [file("ten.csv")]);
  await shown("work");
  figures["10 MB inspected, s"] = (Date.now() - begin) / 1000;
  await set("[name=latitude_deg]", "45");
  await tab.click("#work-form [type=submit]");
  figures["10 MB calibrated, s"] = await tab.until("!document.getElementById('result').hidden", 300);
}

/** By the keyboard alone; each control has a name for a screen reader. */
async function keyboard() {
  const { nodes } = await tab.send("Accessibility.getFullAXTree");
  const controls = nodes.filter((node) => !node.ignored && /^(button|textbox|spinbutton|radio|combobox|link)$/.test(node.role.value));
  assert.ok(controls.length > 12);
  for (const { role, name } of controls) assert.notEqual(name.value, "", role.value);
  const press = async (key, windowsVirtualKeyCode, text) => {
    for (const type of ["keyDown", "keyUp"]) await tab.send("Input.dispatchKeyEvent", { type, key, code: key, windowsVirtualKeyCode, text });
  };
  await tab.value("scrollTo(0, 0), document.activeElement.blur()");
  for (let presses = 0; !(await tab.value("document.activeElement.dataset.example === 'handheld'")); ++presses) {
    assert.ok(presses < 30);
    await press("Tab", 9);
  }
  await press("Enter", 13, "\r");
  await tab.until("work.hidden");
  await shown("work");
}

/** Real records, and logs as people bring them. */
async function records() {
  for (const folder of logs) figures[path.basename(folder)] = await sameWordsAsNative(tab, imulab, folder);
}

/** A hand that turns a phone as `live` says, until it is done. Its events come faster than a phone's, with accelerations of the other sign. */
async function live() {
  const unit = new Unit();
  const feed = (rows) => tab.value(`window.feed(${JSON.stringify(rows)})`);
  await tab.click("#go-live");
  await tab.until("document.getElementById('live-motion').onclick !== null");
  await tab.click("#live-motion");
  await tab.value(`window.feed = (rows) => {
    for (const [t, gx, gy, gz, ...force] of rows) {
      const [x, y, z] = force.map((a) => -a);
      const event = new Event("devicemotion");
      Object.defineProperty(event, "timeStamp", { value: 1000 * t });
      Object.assign(event, { rotationRate: { beta: gx, gamma: gy, alpha: gz }, accelerationIncludingGravity: { x, y, z } });
      dispatchEvent(event);
    }
  }`);
  await feed(unit.rest(6));
  for (let rests = 1, done = false; !done; ++rests) {
    await tab.until(`/^${rests} rests in .*(Next: turn|Done)/.test(document.getElementById("live-state").innerText)`, 120);
    const said = await text("live-state");
    done = said.includes("Done: every requirement is met. Resolution: gyros");
    const [, degrees, axis] = /turn by (\d+) deg about (\S+)/.exec(said) ?? [];
    if (rests === 6) await tab.picture(path.join(pictures, "live-1280.png"), "#live");
    if (!done) await feed([...unit.turn(Number(degrees), axis), ...unit.rest(6)]);
    figures["turns as live says"] = rests - 1;
  }
  await tab.until("document.getElementById('live-stop').disabled");
  assert.match(await text("live-state"), /Signs of the accelerometers reversed/);
  assert.match(await saved("live.csv"), /^t,gx,gy,gz,ax,ay,az\n0\.000000,/);
  await shown("work");
  assert.equal(await tab.value("document.querySelector('[name=latitude_deg]').value"), "45");
}

async function serial() {
  native("simulate", "hand.toml", "-o", "other", "--seed", "2");
  const rows = fs.readFileSync(file("other/recording.csv"), "utf8").trim().split("\n").slice(1).filter((_, i) => i % 2 === 0);
  await tab.value(`{
    const rows = ${JSON.stringify(`${rows.join("\r\n")}\r\n`)}.replaceAll(",", " ");
    const readable = new ReadableStream({ start(c) {
      for (let at = 0; at < rows.length; at += 5001) c.enqueue(new TextEncoder().encode(rows.slice(at, at + 5001)));
      c.close();
    } });
    Object.defineProperty(navigator, "serial", { value: { requestPort: async () => ({ open: async () => {}, close: async () => {}, readable }) } });
  }`);
  await tab.value("document.getElementById('live-state').textContent = ''");
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
  const flows = [firstVisit, calibrateAFile, exportAndCompensate, anotherUnit, noiseOfTheExample, questions, twoKeys, archives, grade, keyboard];
  const limits = [wrongFiles, withoutStorage, outOfMemory, large, cancel, speed];
  for (const step of [...flows, records, ...limits, live, serial, offline]) {
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
