// One run of the command, in an instance of its own: words in, output and files out.
import createEngine from "./engine.js";

/** @typedef {import("./imulab.js").RunRequest} RunRequest @typedef {import("./imulab.js").RunResult} RunResult */

const folder = "/session"; // of the instance's own file system

/**
 * @param {{ module?: WebAssembly.Module, bytes?: Uint8Array, streams: object, environment?: object }} settings of the engine
 * @returns {Promise<any>} an instance of WebAssembly with its file system
 */
export function makeInstance({ module, bytes, streams, environment = {} }) {
  const given = {
    noInitialRun: true,
    streams,
    preRun: [(/** @type {any} */ made) => Object.assign(made.ENV, { TMPDIR: "/tmp" }, environment)],
    quit(/** @type {number} */ status, /** @type {unknown} */ exit) {
      throw exit; // emscripten's own would end the process or the worker
    },
    onAbort: (/** @type {unknown} */ reason) => {
      throw new Error(`imulab: stopped: ${reason}`);
    },
  };
  if (bytes) return createEngine({ ...given, wasmBinary: bytes });
  const compiled = /** @type {WebAssembly.Module} */ (module);
  return new Promise((resolve, reject) => {
    const instantiateWasm = (/** @type {any} */ imports, /** @type {(i: WebAssembly.Instance, m: WebAssembly.Module) => void} */ ready) => {
      WebAssembly.instantiate(compiled, imports).then((instance) => ready(instance, compiled), reject);
      return {};
    };
    createEngine({ ...given, instantiateWasm }).then(resolve, reject);
  });
}

/**
 * Runs main. @returns {number} the exit code
 * @param {any} instance @param {string[]} words
 */
export function callMain(instance, words) {
  try {
    return instance.callMain(words) ?? 0;
  } catch (/** @type {any} */ error) {
    if (typeof error?.status === "number") return error.status;
    throw error;
  }
}

/** @param {any} FS @param {string} top @param {Set<string>} before @returns {Record<string, Uint8Array>} files that are new below a folder */
function newFiles(FS, top, before) {
  /** @type {Record<string, Uint8Array>} */
  const files = {};
  const visit = (/** @type {string} */ place) => {
    for (const name of FS.readdir(place)) {
      if (name === "." || name === "..") continue;
      const path = `${place}/${name}`;
      if (FS.isDir(FS.stat(path).mode)) visit(path);
      else if (!before.has(path)) files[path.slice(top.length + 1)] = FS.readFile(path);
    }
  };
  visit(top);
  return files;
}

/** @param {Uint8Array[]} parts */
function joined(parts) {
  const bytes = new Uint8Array(parts.reduce((size, part) => size + part.length, 0));
  parts.reduce((place, part) => (bytes.set(part, place), place + part.length), 0);
  return bytes;
}

/** Puts the files of a request where the command will find them. @param {any} instance @param {RunRequest["files"]} files */
async function putFiles({ FS, WORKERFS }, files) {
  FS.mkdir(folder);
  FS.chdir(folder);
  const present = new Set();
  const large = [];
  for (const [name, content] of Object.entries(files ?? {})) {
    const path = `${folder}/${name}`;
    present.add(path);
    FS.mkdirTree(path.slice(0, path.lastIndexOf("/")));
    if (typeof content === "string" || content instanceof Uint8Array) FS.writeFile(path, content);
    else if (!("FileReaderSync" in globalThis)) FS.writeFile(path, new Uint8Array(await content.arrayBuffer()));
    else large.push({ name, data: content });
  }
  if (large.length > 0) {
    FS.mkdir("/files");
    FS.mount(WORKERFS, { blobs: large }, "/files"); // read where they are, in pieces
    for (const { name } of large) FS.symlink(`/files/${name}`, `${folder}/${name}`);
  }
  return present;
}

/**
 * @param {RunRequest} request
 * @param {(progress: string) => void} tell gets the line of progress whenever it changes
 * @returns {Promise<RunResult>}
 */
export async function run(request, tell) {
  /** @type {Record<number, Uint8Array[]>} */
  const written = { 1: [], 2: [] };
  const input = request.input ?? new Uint8Array();
  let taken = 0;
  const text = new TextDecoder();
  const instance = await makeInstance({
    module: request.module,
    bytes: request.bytes,
    environment: { NO_COLOR: "1", COLUMNS: "100" },
    streams: {
      isTerminal: (/** @type {number} */ number) => number === 2, // so that it shows progress
      read(/** @type {Uint8Array} */ buffer, /** @type {number} */ offset, /** @type {number} */ length) {
        const part = input.subarray(taken, taken + length);
        buffer.set(part, offset);
        taken += part.length;
        return part.length;
      },
      write(/** @type {number} */ number, /** @type {Uint8Array} */ bytes) {
        const line = number === 2 ? text.decode(bytes) : "";
        if (line.startsWith("\r")) tell(line.replace(/\r|\u001b\[K/g, ""));
        else written[number].push(new Uint8Array(bytes));
        return bytes.length;
      },
    },
  });
  const present = await putFiles(instance, request.files);
  const code = callMain(instance, request.words);
  return { code, output: joined(written[1]), messages: text.decode(joined(written[2])), files: newFiles(instance.FS, folder, present) };
}
