#!/usr/bin/env node
// The command: files where they are, standard streams as they are.
import fs from "node:fs";
import { callMain, makeInstance } from "../run.js";

const wait = new Int32Array(new SharedArrayBuffer(4));

/** Reads or writes; again where a pipe is not ready. @param {() => number} once */
function untilReady(once) {
  for (;;)
    try {
      return once();
    } catch (/** @type {any} */ error) {
      if (error.code === "EOF") return 0; // the end of standard input on Windows
      if (error.code === "EPIPE") process.exit(2);
      if (error.code !== "EAGAIN") throw error;
      Atomics.wait(wait, 0, 0, 10);
    }
}

const streams = {
  isTerminal: (/** @type {number} */ number) => [process.stdin, process.stdout, process.stderr][number].isTTY === true,
  read(/** @type {Uint8Array} */ buffer, /** @type {number} */ offset, /** @type {number} */ length) {
    return untilReady(() => fs.readSync(0, buffer, offset, length, null));
  },
  write(/** @type {number} */ number, /** @type {Uint8Array} */ bytes) {
    return untilReady(() => fs.writeSync(number, bytes));
  },
};

/** As WebAssembly names files: C:\logs\a.csv is /C:/logs/a.csv. @param {string} word */
const asPath = (word) => (/^[A-Za-z]:[\\/]/.test(word) ? `/${word.replaceAll("\\", "/")}` : word);

/** Folders of this system under the same names. @param {any} instance */
function mountFolders({ FS, NODEFS }) {
  const windows = process.platform === "win32";
  const tops = windows ? [process.cwd().slice(0, 2)] : [...fs.readdirSync("/").filter((name) => name !== "dev" && name !== "proc"), "dev/shm"];
  for (const name of tops) {
    const root = windows ? `${name}\\` : `/${name}`;
    if (!fs.statSync(root, { throwIfNoEntry: false })?.isDirectory()) continue;
    FS.mkdirTree(`/${name}`);
    FS.mount(NODEFS, { root }, `/${name}`);
  }
  FS.chdir(asPath(process.cwd()));
}

const environment = { ...process.env };
if (process.platform === "win32") delete environment.TMPDIR;
else environment.TMPDIR ??= fs.existsSync("/var/tmp") ? "/var/tmp" : "/tmp";
const bytes = fs.readFileSync(new URL("../imulab.wasm", import.meta.url));
const instance = await makeInstance({ bytes, streams, environment });
mountFolders(instance);
process.exitCode = callMain(instance, process.argv.slice(2).map(asPath));
