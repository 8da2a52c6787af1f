// The worker of one run, in browsers and in node.
import { run } from "./run.js";

/** @type {any} */
const port = typeof self !== "undefined" && "postMessage" in self ? self : (await import("node:worker_threads")).parentPort;

/** @param {import("./imulab.js").RunRequest} request */
async function answer(request) {
  try {
    const result = await run(request, (progress) => port.postMessage({ progress }));
    port.postMessage({ result });
  } catch (/** @type {any} */ error) {
    port.postMessage({ failure: `the calculation broke off: ${error?.message ?? error}; expected less data, or the installed command for it` });
  }
}

if (port === globalThis.self) self.onmessage = ({ data }) => answer(data);
else port.on("message", answer);
port.postMessage({ ready: true });
