// web/tests/corpus.mjs PACKAGE FOLDER...: any bytes to the readers: each file as a recording, a session, a calibration, a noise result and an import. The
// command answers or says what is wrong; nothing traps.
import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";

const [place, ...folders] = process.argv.slice(2);
const { run } = await import(pathToFileURL(path.resolve(place, "run.js")));
const module = await WebAssembly.compile(fs.readFileSync(path.join(place, "imulab.wasm")));
const uses = [
  ["inspect", "input"],
  ["calibrate", "input", "--method", "handheld", "--set", "latitude_deg=45"],
  ["report", "input", "-o", "page.html"],
  ["import", "input", "-o", "imported.json"],
  ["budget", "input", "--runs", "2"],
];
process.setMaxListeners(0); // each instance has its own
let runs = 0;
for (const folder of folders)
  for (const name of fs.readdirSync(folder, { recursive: true })) {
    const file = path.join(folder, name);
    if (!fs.statSync(file).isFile() || fs.statSync(file).size > 1_000_000) continue;
    for (const words of uses) {
      const { code, messages } = await run({ module, words, files: { input: new Uint8Array(fs.readFileSync(file)) } }, () => {});
      assert.ok([0, 1, 2].includes(code) && (code === 0 || messages.includes("imulab: ")), `${words[0]} ${file}: ${code} ${messages}`);
      ++runs;
    }
  }
console.log(`corpus: ${runs} runs, each answers or says what is wrong`);
