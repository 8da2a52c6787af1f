// web/tests/npm.mjs PACKED: the packed package, installed in an empty folder, as a command and as a module.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import zlib from "node:zlib";

const packed = path.resolve(process.argv[2]);
const source = process.cwd();
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "imulab-npm-"));
process.chdir(folder);
try {
  fs.writeFileSync("package.json", '{"private": true, "type": "module"}');
  execFileSync("npm", ["install", "--offline", "--no-audit", "--no-fund", "--silent", packed]);
  const imulab = (...words) => spawnSync("npx", ["--no", "--", "imulab", ...words], { encoding: "utf8" });

  // The command: files where they are, standard streams, exit codes.
  assert.match(imulab("--version").stdout, /^imulab \d+\.\d+\.\d+\n/);
  assert.equal(imulab("procedure", "handheld", "-o", "hand.toml").status, 0);
  const simulated = imulab("simulate", "hand.toml", "-o", "session");
  assert.equal(simulated.status, 0, simulated.stderr);
  assert.equal(fs.statSync("session/recording.csv").mode & 0o777, 0o644);
  const bin = path.join(folder, "node_modules/imulab/bin/imulab.js");
  const piped = spawnSync("node", [bin, "inspect", "-"], { input: fs.readFileSync("session/recording.csv"), encoding: "utf8" });
  assert.match(piped.stdout, /^understood: calibrate with --method/, piped.stderr);
  const wrong = imulab("calibrate", "none.toml", "--method", "handheld");
  assert.equal(wrong.status, 2);
  assert.match(wrong.stderr, /^imulab: none\.toml: /);
  assert.equal(imulab("calibrate", "session", "--method", "handheld", "-o", "by-command.json", "--report", "by-command.html").status, 0);

  // The module.
  fs.writeFileSync("use.js", 'export * from "imulab";');
  const { calibrate, compensate, ImulabError, inspect, noise, report } = await import(path.join(folder, "use.js"));
  const log = fs.readFileSync("session/recording.csv");
  const seen = await inspect(log);
  assert.equal(seen.supported, true);
  assert.deepEqual(seen.data.methods, ["static", "handheld"]);
  assert.match(seen.page, /<html/);
  assert.ok("session.toml" in seen.files);

  const files = { "recording.csv": log, "session.toml": fs.readFileSync("session/session.toml") };
  const opened = await inspect(files);
  assert.deepEqual([opened.data.methods, Object.keys(opened.files)], [["static", "handheld"], []], "a session is opened");
  const calibrated = await calibrate(files, { method: "handheld" });
  assert.equal(calibrated.data.quality.verdict, JSON.parse(fs.readFileSync("by-command.json", "utf8")).quality.verdict);
  assert.deepEqual(calibrated.data.model, JSON.parse(fs.readFileSync("by-command.json", "utf8")).model);
  for (const [name, bytes] of Object.entries({ "log.csv.gz": zlib.gzipSync(log), "log.csv.xz": execFileSync("xz", ["-c"], { input: log, maxBuffer: 1e9 }) }))
    assert.equal((await inspect({ [name]: bytes })).data.rows, 26400, name);
  const hostile = await inspect({ "-o\u001b[2J<img>.csv": log });
  assert.equal(hostile.data.rows, 26400);

  const corrected = await compensate(calibrated.data, files);
  assert.match(new TextDecoder().decode(corrected.files["compensated.csv"].subarray(0, 20)), /^t,gx,gy,gz,ax,ay,az/);
  assert.match(await report(calibrated.data), /<html/);
  assert.match(await report(calibrated.data, { certificate: true, number: "7" }), /<html/);
  const head = fs.readFileSync("hand.toml", "utf8");
  fs.writeFileSync("still.toml", `${head.slice(0, head.indexOf("[[step]]"))}[[step]]\nkind = "hold"\nduration_s = 300\n`);
  assert.equal(imulab("simulate", "still.toml", "-o", "still").status, 0);
  assert.equal((await noise(fs.readFileSync("still/recording.csv"), { set: { "gyro.unit": "rad/s" } })).data.axes.length, 6);

  // A drive whose epochs go to a temporary file, in memory.
  assert.equal(imulab("trajectory", path.join(source, "tests/portable/drive.toml"), "--errors", "-o", "drive").status, 0);
  const drive = Object.fromEntries(fs.readdirSync("drive").map((name) => [name, fs.readFileSync(`drive/${name}`)]));
  assert.equal(imulab("calibrate", "drive", "--method", "drive", "-o", "drive.json").status, 0);
  assert.deepEqual((await calibrate(drive, { method: "drive" })).data.model, JSON.parse(fs.readFileSync("drive.json", "utf8")).model);

  // Errors and the end of a call.
  await assert.rejects(inspect("no numbers\n"), ImulabError);
  await assert.rejects(calibrate(log, { method: "by-foot" }), /--method/);
  const controller = new AbortController();
  const cancelled = calibrate(files, { method: "handheld", signal: controller.signal });
  setTimeout(() => controller.abort(), 50);
  await assert.rejects(cancelled, { name: "AbortError" });
  console.log("npm: the packed package works as a command and as a module");
} finally {
  process.chdir("/");
  fs.rmSync(folder, { recursive: true, force: true });
}
