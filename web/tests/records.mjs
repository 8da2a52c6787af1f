// Logs as people bring them, in the page: what it says about each is what the native command says.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";

/** What the data of real records do not tell. */
const declared = {
  drive_0708: { "accel.unit": "g", latitude_deg: "48" },
  imu_tk_xsens: { gravity_mps2: "9.81744" },
  mpu9150_by_hand: { rate_hz: "100", gravity_mps2: "9.80665" },
  imucal_ferraris: { rate_hz: "102.4", latitude_deg: "49.6" },
};
const together = ["imu_tk_xsens", "same_names", "six_files", "zyx"]; // files of one recording, or of one session

/** Lists of files, each a log. */
function logsOf(folder) {
  const places = fs.readdirSync(folder, { withFileTypes: true }).filter((entry) => entry.isDirectory());
  return places.flatMap(({ name }) => {
    const files = fs.readdirSync(path.join(folder, name)).filter((file) => /\.(csv|txt|mat|log)$/.test(file) && file !== "README.txt");
    const all = files.sort().map((file) => path.join(folder, name, file));
    return together.includes(name) ? [all] : all.map((file) => [file]);
  });
}

/** Seconds of whitespace are no difference. */
const plain = (text) => text.replaceAll("imulab: ", "").replace(/\s+/g, " ").trim();

/** @param {any} tab @param {string} imulab the native command @param {string} folder with a folder for each record */
export async function sameWordsAsNative(tab, imulab, folder) {
  const text = (id) => tab.value(`document.getElementById("${id}").hidden ? "" : document.getElementById("${id}").innerText`);
  const ended = () => tab.until("document.getElementById('cancel').disabled && (!inspection.hidden || !problem.hidden)", 120);
  let calibrated = 0;
  const logs = logsOf(folder);
  for (const log of logs) {
    const [place, names] = [path.dirname(log[0]), log.map((file) => path.basename(file))];
    const own = fs.mkdtempSync(path.join(os.tmpdir(), "imulab-native-"));
    for (const name of names) fs.copyFileSync(path.join(place, name), path.join(own, name));
    const native = (...words) => spawnSync(imulab, words, { cwd: own, encoding: "utf8", maxBuffer: 1e8 });
    await tab.value("problem.hidden = inspection.hidden = true");
    await tab.choose("#files", log);
    await ended();
    const seen = native("inspect", ...names, "--json");
    if (seen.stdout === "") assert.equal(plain(await text("problem")), plain(seen.stderr));
    else assert.equal(await text("inspection-headline"), JSON.parse(seen.stdout).headline);
    calibrated += await calibrateRecord(tab, native, names, declared[path.basename(place)]);
    fs.rmSync(own, { recursive: true });
  }
  return `${logs.length} logs, ${calibrated} calibrated`;
}

/** With what is declared about a real record; whether a calibration came of it. */
async function calibrateRecord(tab, native, names, known) {
  if (!known) return 0;
  await tab.value(`for (const [key, value] of Object.entries(${JSON.stringify(known)}))
    for (const field of document.querySelectorAll('[name="' + key + '"]')) field.value = value`);
  if (!(await tab.value("questions.hidden"))) {
    await tab.value("inspection.hidden = true; questions.requestSubmit()");
    await tab.until("!inspection.hidden && document.getElementById('cancel').disabled", 120);
  }
  const work = await tab.value("work.hidden ? '' : document.querySelector('[name=work]:checked').value");
  if (!work.startsWith("calibrate ")) return 0;
  await tab.value(`for (const key of ["latitude_deg", "height_m", "gravity_mps2"])
    document.getElementById("work-form").elements[key].value = (${JSON.stringify(known)})[key] ?? ""`);
  await tab.click("#work-form [type=submit]");
  await tab.until("!result.hidden || !problem.hidden", 120);
  native("inspect", ...names, ...Object.entries(known).flatMap(([key, value]) => ["--set", `${key}=${value}`]), "-o", "session.toml");
  const done = native("calibrate", "session.toml", "--method", work.split(" ")[1], "--json");
  const verdict = done.stdout === "" ? plain(done.stderr) : JSON.parse(done.stdout).quality.verdict;
  const shown = await tab.value("result.hidden ? problem.innerText : document.getElementById('result-headline').innerText");
  assert.ok(plain(shown).startsWith(verdict), `${names}: ${shown}, natively ${verdict}`);
  return 1;
}
