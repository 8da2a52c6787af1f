// import { inspect, calibrate, noise, compensate, report } from "imulab": the verbs of the command as functions. Each call runs the command in a worker
// and an instance of WebAssembly of its own.

const underNode = typeof process === "object" && typeof process.versions?.node === "string";

/** The command said that its input is wrong: the message names file, field and what was expected. */
export class ImulabError extends Error {
  name = "ImulabError";
}

/** @type {Promise<WebAssembly.Module> | undefined} */
let compiled;

/** The compiled module, shared by all calls. @param {Response | Promise<Response>} [source] in place of imulab.wasm beside this file */
export function prepare(source) {
  compiled ??= (async () => {
    const place = new URL("./imulab.wasm", import.meta.url);
    if (underNode && !source) return WebAssembly.compile(new Uint8Array(await (await import("node:fs/promises")).readFile(place)));
    return WebAssembly.compileStreaming(source ?? fetch(place));
  })();
  return compiled;
}

async function startWorker() {
  const place = new URL("./worker.js", import.meta.url);
  if (!underNode) {
    const worker = new Worker(place, { type: "module" });
    return { post: (/** @type {any} */ m) => worker.postMessage(m), end: () => worker.terminate(), on: listen(worker, (/** @type {any} */ e) => e.data) };
  }
  const { Worker: NodeWorker } = await import("node:worker_threads");
  const worker = new NodeWorker(place);
  return { post: (/** @type {any} */ m) => worker.postMessage(m), end: () => worker.terminate(), on: listen(worker, (/** @type {any} */ m) => m) };
}

/** @param {any} worker @param {(event: any) => any} data */
function listen(worker, data) {
  return (/** @type {(message: any) => void} */ take, /** @type {(error: any) => void} */ fail) => {
    const add = (/** @type {string} */ kind, /** @type {any} */ f) => (worker.addEventListener ?? worker.on).call(worker, kind, f);
    add("message", (/** @type {any} */ event) => take(data(event)));
    add("error", (/** @type {any} */ event) => fail(new Error(event.message || "imulab: the worker cannot be started")));
    add("exit", () => fail(new Error("imulab: the worker ended without an answer")));
  };
}

/** @type {import("./imulab.js").command} */
export async function command(words, files = {}, { input, signal, onProgress } = {}) {
  signal?.throwIfAborted();
  const module = await prepare();
  signal?.throwIfAborted();
  const worker = await startWorker();
  try {
    return await new Promise((resolve, reject) => {
      signal?.addEventListener("abort", () => reject(signal.reason), { once: true });
      worker.on((message) => {
        if (message.ready) worker.post({ module, words, files, input });
        if (message.progress !== undefined) onProgress?.(message.progress);
        if (message.result) resolve(message.result);
        if (message.failure) reject(new Error(message.failure));
      }, reject);
    });
  } finally {
    worker.end();
  }
}

const own = new Set(["set", "signal", "onProgress", "name"]);

/** Options of the command from those of a call: { requireAll: true } is --require-all. @param {Record<string, any>} options */
function optionWords(options) {
  const words = Object.entries(options.set ?? {}).flatMap(([key, value]) => ["--set", `${key}=${value}`]);
  for (const [key, value] of Object.entries(options)) {
    if (own.has(key) || value === undefined || value === false || value === null) continue;
    const name = `--${key.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)}`;
    for (const one of [value].flat()) words.push(...(one === true ? [name] : [name, String(one)]));
  }
  return words;
}

/** @param {import("./imulab.js").Input} input @param {string} usual the name of bytes that have none */
function named(input, usual) {
  const list = Array.isArray(input) ? input : [input];
  /** @type {Record<string, any>} */
  const files = {};
  for (const one of list) {
    if (typeof one === "string" || one instanceof Uint8Array || one instanceof Blob) files[/** @type {any} */ (one).name ?? usual] = one;
    else Object.assign(files, one);
  }
  return files;
}

/** Names as arguments: one that begins with a dash is no option. @param {Record<string, any>} files */
const fileWords = (files) => Object.keys(files).map((name) => (name.startsWith("-") ? `./${name}` : name));

/**
 * @param {string} verb @param {string[]} words @param {Record<string, any>} files @param {Record<string, any>} options
 * @returns {Promise<any>} an Answer
 */
async function answer(verb, words, files, options) {
  const done = await command([verb, ...words, ...optionWords(options)], files, options);
  const text = new TextDecoder();
  const messages = done.messages.replaceAll(/^imulab: (warning: )?/gm, "").trim();
  if (done.code > 1) throw new ImulabError(messages);
  const { "page.html": page, ...written } = done.files;
  const document = done.output.length > 0 ? JSON.parse(text.decode(done.output)) : null;
  return {
    supported: done.code === 0,
    messages: messages === "" ? [] : messages.split("\n"),
    data: document,
    page: page ? text.decode(page) : null,
    files: written,
  };
}

const withPage = ["--json", "--report", "page.html"];

/** @type {import("./imulab.js").inspect} */
export function inspect(input, options = {}) {
  const files = named(input, "recording.csv");
  const written = sessionName(files) ? [] : ["-o", "session.toml"]; // a session that is given is opened
  return answer("inspect", [...fileWords(files), ...withPage, ...written], files, options);
}

/** @type {import("./imulab.js").calibrate} */
export function calibrate(input, options) {
  const files = named(input, "recording.csv");
  return answer("calibrate", [...sessionWords(files), ...withPage, "-o", "calibration.json"], files, options);
}

/** @type {import("./imulab.js").noise} */
export function noise(input, options = {}) {
  const files = named(input, "recording.csv");
  return answer("noise", [...sessionWords(files), ...withPage, "-o", "noise.json"], files, options);
}

/** @type {import("./imulab.js").compensate} */
export function compensate(calibration, input, options = {}) {
  const files = named(input, "recording.csv");
  const words = ["calibration.json", ...sessionWords(files), ...withPage, "-o", "compensated.csv"];
  return answer("compensate", words, { ...files, "calibration.json": asText(calibration) }, options);
}

/** @type {import("./imulab.js").report} */
export async function report(result, options = {}) {
  const done = await answer("report", ["result.json", "-o", "page.html", "--json"], { "result.json": asText(result) }, options);
  return done.page;
}

/** The session among files. @param {Record<string, any>} files @returns {string | undefined} */
function sessionName(files) {
  return "session.toml" in files ? "session.toml" : Object.keys(files).find((name) => name.endsWith(".toml"));
}

/** The files to name: a session names its recordings itself. @param {Record<string, any>} files */
function sessionWords(files) {
  const session = sessionName(files);
  return session ? [session] : fileWords(files);
}

/** @param {any} result a document, its text or its bytes */
function asText(result) {
  const isContent = typeof result === "string" || result instanceof Uint8Array || result instanceof Blob;
  return isContent ? result : JSON.stringify(result);
}
