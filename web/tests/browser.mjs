// Chromium without a window, over a pipe, and a server of static files: no package is needed.
import { spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";

const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".webmanifest": "application/manifest+json" };

/** Serves a folder; `requests` gets each path that is asked for. */
export async function serve(folder, requests = []) {
  const server = http.createServer((request, response) => {
    const name = new URL(request.url, "http://localhost").pathname.replace(/\/$/, "/index.html");
    requests.push(name);
    const file = path.join(folder, path.normalize(name));
    if (!fs.existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { "Content-Type": types[path.extname(file)] ?? "application/octet-stream" });
    fs.createReadStream(file).pipe(response);
  });
  await new Promise((ready) => server.listen(0, "127.0.0.1", ready));
  return { address: `http://localhost:${server.address().port}/`, close: () => server.close(), requests };
}

export class Browser {
  #last = 0;
  #waiting = new Map();
  events = [];

  static async start() {
    const browser = new Browser();
    browser.profile = fs.mkdtempSync(path.join(os.tmpdir(), "imulab-browser-"));
    const options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--remote-debugging-pipe", `--user-data-dir=${browser.profile}`];
    const child = (browser.child = spawn("chromium", options, { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] }));
    let text = "";
    child.stdio[4].setEncoding("utf8").on("data", (part) => {
      const messages = (text + part).split("\0");
      text = messages.pop();
      for (const message of messages) browser.#take(JSON.parse(message));
    });
    return browser;
  }
  #take(message) {
    if (!message.id) return this.events.push(message);
    const { resolve, reject } = this.#waiting.get(message.id);
    this.#waiting.delete(message.id);
    if (message.error) reject(new Error(message.error.message));
    else resolve(message.result);
  }
  send(method, params = {}, sessionId = undefined) {
    const id = ++this.#last;
    this.child.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    return new Promise((resolve, reject) => this.#waiting.set(id, { resolve, reject }));
  }
  async page() {
    const { targetId } = await this.send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
    const page = new Page(this, sessionId);
    for (const domain of ["Page", "Runtime", "DOM", "Network", "Log"]) await page.send(`${domain}.enable`);
    return page;
  }
  async close() {
    const ended = new Promise((done) => this.child.on("exit", done));
    this.send("Browser.close").catch(() => {});
    await ended;
    fs.rmSync(this.profile, { recursive: true, force: true });
  }
}

class Page {
  constructor(browser, session) {
    Object.assign(this, { browser, session });
  }
  send(method, params) {
    return this.browser.send(method, params, this.session);
  }
  async open(address) {
    await this.send("Page.navigate", { url: address });
    await this.until("document.documentElement.dataset.ready === 'true'");
  }
  /** The value of an expression, or of its promise. */
  async value(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }
  async until(expression, seconds = 60) {
    const begin = Date.now();
    while (!(await this.value(expression).catch(() => false))) {
      if (Date.now() - begin > 1000 * seconds) throw new Error(`not within ${seconds} s: ${expression}\n${await this.value("document.body.innerText")}`);
      await new Promise((ready) => setTimeout(ready, 20));
    }
    return (Date.now() - begin) / 1000;
  }
  async choose(selector, files) {
    const { root } = await this.send("DOM.getDocument");
    const { nodeId } = await this.send("DOM.querySelector", { nodeId: root.nodeId, selector });
    await this.send("DOM.setFileInputFiles", { nodeId, files });
  }
  click(selector) {
    return this.value(`document.querySelector(${JSON.stringify(selector)}).click()`);
  }
  async size(width, height, dark = false) {
    await this.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 600 });
    await this.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }] });
  }
  /** Of the window, from an element on. */
  async picture(file, selector = "header") {
    await this.value(`document.querySelector(${JSON.stringify(selector)}).scrollIntoView({ behavior: "instant" })`);
    await new Promise((ready) => setTimeout(ready, 300));
    const { data } = await this.send("Page.captureScreenshot");
    fs.writeFileSync(file, Buffer.from(data, "base64"));
  }
  problems() {
    return this.browser.events
      .filter((e) => e.sessionId === this.session && (e.method === "Runtime.exceptionThrown" || (e.method === "Log.entryAdded" && e.params.entry.level === "error")))
      .map((e) => JSON.stringify(e.params.entry?.text ?? e.params.exceptionDetails));
  }
}
