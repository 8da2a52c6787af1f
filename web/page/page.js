// The page: a log is inspected, its questions are answered, and a verb of the command computes. All text about the data is the command's own.
import { calibrate, command, compensate, inspect, noise, prepare } from "./module/imulab.js";
import { describeCalibration, otherUnit, readCalibration, textOf } from "./calibration.js";
import { questionFields } from "./questions.js";
import { showReport } from "./report.js";
import { saveButton } from "./save.js";

/** @typedef {import("./module/imulab.js").Answer} Answer @typedef {import("./module/imulab.js").Content} Content @typedef {import("./calibration.js").Chosen} Chosen */

/** @param {string} id @returns {any} */
const at = (id) => document.getElementById(id);

/** An element with text, never with markup: names in a file are shown as they are. @param {string} tag @param {string} text @param {object} [more] */
const made = (tag, text, more = {}) => Object.assign(document.createElement(tag), { textContent: text }, more);

const state = {
  /** @type {Record<string, Content>} */ files: {},
  /** @type {Record<string, string>} */ declared: {},
  /** @type {string[]} */ topic: [], // of files with several tables
  /** @type {Answer | null} */ inspection: null,
  inspected: "", // with which declarations
  /** @type {string | null} */ given: null, // the session that was opened
  /** @type {string | null} */ session: null, // of the last result
  /** @type {Chosen | null} */ calibration: null, // of an IMU: it outlasts the log, is shown, and may be changed
  /** @type {AbortController | null} */ running: null,
};

// The work that runs

/** @template T @param {string} label @param {(options: import("./module/imulab.js").VerbOptions) => Promise<T>} work @returns {Promise<T | undefined>} */
async function runs(label, work) {
  state.running?.abort();
  const running = (state.running = new AbortController());
  at("problem").hidden = true;
  at("cancel").disabled = false;
  const begin = performance.now();
  let line = label;
  const show = () => {
    if (at("progress").textContent !== line) at("progress").textContent = line;
    at("clock").textContent = `${Math.round((performance.now() - begin) / 1000)} s`;
  };
  at("progress").textContent = label;
  const clock = setInterval(show, 1000);
  try {
    return await work({ signal: running.signal, onProgress: (/** @type {string} */ text) => text && (line = text) });
  } catch (/** @type {any} */ error) {
    if (!running.signal.aborted) showProblem(error.message);
    return undefined;
  } finally {
    clearInterval(clock);
    if (state.running === running) {
      state.running = null;
      at("cancel").disabled = true;
      at("progress").textContent = running.signal.aborted ? "Cancelled." : "";
      at("clock").textContent = "";
    }
  }
}

/** @param {string} text */
function showProblem(text) {
  at("problem").textContent = text;
  at("problem").hidden = false;
}

// 1. A log

/** @param {Record<string, Content>} files @param {Record<string, string>} [declared] */
async function open(files, declared = {}) {
  const logs = await withoutCalibrations(files);
  if (Object.keys(logs).length === 0) return;
  forget();
  Object.assign(state, { files: logs, declared });
  const session = Object.keys(logs).find((name) => name.endsWith(".toml"));
  if (session) state.given = await textOf(logs[session]);
  await inspectAgain();
}

/** What belongs to a log goes with it. */
function forget() {
  Object.assign(state, { files: {}, declared: {}, topic: [], inspection: null, inspected: "", given: null, session: null });
  at("work-form").reset();
  for (const id of ["inspection", "work", "result"]) at(id).hidden = true;
}

/** A calibration among the files is taken to be applied. @param {Record<string, Content>} files */
async function withoutCalibrations(files) {
  const logs = { ...files };
  for (const name of Object.keys(files).filter((each) => each.endsWith(".json"))) {
    const chosen = await readCalibration(files[name], name);
    if (!chosen) continue;
    delete logs[name];
    takeCalibration(chosen);
    at("progress").textContent = `${describeCalibration(chosen)}: choose a log to apply it to.`;
  }
  return logs;
}

/** @param {Iterable<File>} list */
const byName = (list) => Object.fromEntries([...list].map((file) => [file.name, file]));

/** @param {string} kind */
async function openExample(kind) {
  forget();
  const text = new TextDecoder();
  const done = await runs("Simulating the example", async (options) => {
    const { output } = await command(["procedure", "handheld"], {}, options);
    const head = text.decode(output);
    const rest = `${head.slice(0, head.indexOf("[[step]]"))}[[step]]\nkind = "hold"\nduration_s = 1800\n`;
    return command(["simulate", "example.toml", "-o", "example"], { "example.toml": kind === "rest" ? rest : head }, options);
  });
  if (done) await open({ "example.csv": done.files["example/recording.csv"] }, { "gyro.unit": "rad/s", latitude_deg: "48", height_m: "300" });
}

// 2. What it holds

async function inspectAgain() {
  const answer = await runs("Inspecting", (options) => inspect(state.files, { ...options, set: state.declared, topic: state.topic }));
  if (!answer && !at("problem").hidden) askForTopic(at("problem").textContent);
  if (!answer) return;
  takeInspection(answer, state.declared);
  showInspection(answer);
}

/** The tables that an error names are a question. @param {string} problem */
function askForTopic(problem) {
  const [, names, two] = /; expected a topic of (.*?)( \(--topic, once for each of two\))?$/.exec(problem) ?? [];
  if (!names) return;
  const ambiguous = [`${two ? "topic, topic" : "topic"}: ${names}`];
  showInspection({ data: { headline: "several tables", columns: [], evidence: [], ambiguous, problems: [problem], methods: [] }, page: null });
}

/** @param {Answer} answer @param {Record<string, string>} declared */
function takeInspection(answer, declared) {
  Object.assign(state, { inspection: answer, inspected: JSON.stringify(declared) });
}

/** @param {Pick<Answer, "data" | "page">} answer */
function showInspection(answer) {
  const { headline, columns, evidence, ambiguous, problems, methods } = answer.data;
  at("inspection-headline").textContent = headline;
  const head = made("tr", "");
  for (const name of ["column", "role", "unit", "evidence"]) head.append(made("th", name, { scope: "col" }));
  const rows = columns.map((/** @type {any} */ column) => {
    const row = made("tr", "");
    for (const key of ["name", "role", "unit", "evidence"]) row.append(made("td", column[key]));
    return row;
  });
  at("columns").replaceChildren(head, ...rows);
  at("evidence").replaceChildren(...evidence.map((/** @type {string} */ text) => made("li", text)));
  at("columns").hidden = columns.length === 0;
  at("evidence").parentElement.hidden = evidence.length === 0;
  at("question-fields").replaceChildren(
    ...ambiguous.map((/** @type {string} */ text) => questionFields(text, state.declared, columns.map((/** @type {any} */ column) => column.name))));
  at("questions").hidden = ambiguous.length === 0;
  showReport(at("recording-page"), answer.page, { lazy: true });
  at("inspection").hidden = false;
  if (problems.length > 0) showProblem(problems.join("\n"));
  offerWork(ambiguous.length + problems.length > 0 ? [] : methods, ambiguous.length + problems.length === 0);
}

// 3. Work

/** @param {string[]} methods @param {boolean} understood */
function offerWork(methods, understood) {
  const works = methods.map((method) => ({ value: `calibrate ${method}`, label: `calibrate (${method})` })).reverse();
  works.push({ value: "noise", label: "noise of a log at rest" }, { value: "compensate", label: "apply a calibration" });
  const radios = works.map(({ value, label }, index) => {
    const outer = made("label", "");
    outer.append(Object.assign(document.createElement("input"), { type: "radio", name: "work", value, checked: index === 0 }), label);
    return outer;
  });
  at("works").replaceChildren(...radios);
  at("site").hidden = state.given !== null; // a session declares it
  for (const key of siteKeys) at("work-form").elements[key].value = state.declared[key] ?? "";
  chooseWork();
  at("work").hidden = !understood;
}

const siteKeys = ["latitude_deg", "height_m", "gravity_mps2"];

function chooseWork() {
  at("calibration").hidden = at("work-form").elements.work.value !== "compensate";
  at("calibration-shown").textContent = state.calibration ? describeCalibration(state.calibration) : "none chosen";
  const question = otherUnit(state.calibration, state.given);
  at("other-unit").hidden = question === "";
  at("other-unit-question").textContent = question;
}

/** @param {Chosen} chosen */
function takeCalibration(chosen) {
  state.calibration = chosen;
  at("work-form").elements.other_unit.checked = false; // asked anew
  if (!at("work").hidden) chooseWork();
}

async function chooseCalibration() {
  const file = at("work-form").elements.calibration.files[0];
  const chosen = file && (await readCalibration(file, file.name));
  at("work-form").elements.calibration.value = ""; // what is applied is shown beside it
  if (chosen) takeCalibration(chosen);
  else if (file) showProblem(`${file.name}: is no calibration; expected a calibration.json`);
}

async function compute() {
  const form = at("work-form").elements;
  const set = { ...state.declared };
  for (const key of siteKeys) {
    if (form[key].value !== "") set[key] = form[key].value;
    else delete set[key];
  }
  state.declared = set;
  const [verb, method] = form.work.value.split(" ");
  if (verb === "compensate" && !state.calibration) return showProblem("Choose the calibration to apply.");
  if (verb === "compensate" && !at("other-unit").hidden && !form.other_unit.checked) return showProblem(`${at("other-unit-question").textContent}?`);
  const calibration = state.calibration?.content ?? "";
  at("result").hidden = true;
  const answer = await runs("Computing", async (options) => {
    const all = { ...options, set, topic: state.topic };
    if (state.inspected !== JSON.stringify(set)) takeInspection(await inspect(state.files, all), set);
    state.session = graded(state.inspection?.files["session.toml"], form.grade.value);
    const session = form.grade.value || Object.keys(state.files).length > 1 ? state.session : null; // files of one recording belong together there
    const [files, more] = session ? [{ ...state.files, "session.toml": session }, options] : [state.files, state.given ? options : all];
    if (verb === "noise") return noise(files, more);
    if (verb === "compensate") return compensate(calibration, files, more);
    return calibrate(files, { ...more, method });
  });
  if (answer) await showResult(answer);
}

/** A session that declares the grade. @param {Uint8Array | undefined} session @param {string} grade @returns {string | null} */
function graded(session, grade) {
  if (!session) return null;
  const text = new TextDecoder().decode(session);
  return grade ? text.replace(/^\[imu\]$/m, `[imu]\ngrade = "${grade}"`) : text;
}

// 4. The result

/** @param {Answer} answer */
async function showResult(answer) {
  const { data, page, files, messages } = answer;
  at("result-headline").textContent = [data?.verdict ?? data?.quality?.verdict, data?.headline].filter(Boolean).join(": ");
  at("result-messages").replaceChildren(...messages.map((text) => made("li", text)));
  const saved = { ...(page ? { "report.html": page } : {}), ...files, ...(state.session ? { "session.toml": state.session } : {}) };
  at("saves").replaceChildren(...Object.entries(saved).map(([name, content]) => saveButton(name, content)));
  const computed = files["calibration.json"] && (await readCalibration(files["calibration.json"], Object.keys(state.files).join(", ")));
  if (computed) takeCalibration(computed);
  at("export-form").hidden = !("calibration.json" in files);
  if ("calibration.json" in files && at("export-target").length === 0) offerChoices("export", /\[(c-header,[^\]]*)\]/, at("export-target"));
  showReport(at("result-page"), page);
  at("result").hidden = false;
  at("result-title").scrollIntoView({ behavior: "smooth" });
}

/** Choices are those that the command's help names. @param {string} verb @param {RegExp} list @param {any} select */
async function offerChoices(verb, list, select) {
  const help = new TextDecoder().decode((await command(["help", verb])).output).replace(/\s+/g, " ");
  const names = list.exec(help)?.[1].split(", ") ?? [];
  select.append(...names.filter((name) => name !== "all").map((name) => made("option", name)));
}

async function saveExport() {
  const target = at("export-target").value;
  const words = ["export", "calibration.json", "--to", target];
  const done = await runs("Exporting", (options) => command(words, { "calibration.json": state.calibration?.content ?? "" }, options));
  if (!done) return;
  if (done.code > 1) return showProblem(done.messages);
  saveButton(`${target}.txt`, done.output).click();
}

// Events

function listen() {
  at("files").addEventListener("change", () => {
    const chosen = byName(at("files").files);
    at("files").value = ""; // the same log may be chosen again
    if (Object.keys(chosen).length > 0) open(chosen);
  });
  for (const kind of ["dragover", "dragleave", "drop"])
    addEventListener(kind, (/** @type {any} */ event) => {
      event.preventDefault();
      at("drop").classList.toggle("over", kind === "dragover");
      if (kind === "drop" && event.dataTransfer.files.length > 0) open(byName(event.dataTransfer.files));
    });
  for (const button of document.querySelectorAll("[data-example]"))
    button.addEventListener("click", () => openExample(/** @type {HTMLElement} */ (button).dataset.example ?? ""));
  at("questions").addEventListener("submit", (/** @type {Event} */ event) => {
    event.preventDefault();
    const fields = [...at("question-fields").querySelectorAll("input")];
    const topics = fields.flatMap(({ name, value }) => (name === "topic" && value.trim() !== "" ? [value.trim()] : []));
    if (topics.length > 0) state.topic = topics;
    for (const { name, value } of fields.filter((field) => field.name !== "topic"))
      if (value.trim() !== "") state.declared[name] = value;
      else delete state.declared[name];
    inspectAgain();
  });
  at("works").addEventListener("change", chooseWork);
  at("work-form").elements.calibration.addEventListener("change", chooseCalibration);
  at("work-form").addEventListener("submit", (/** @type {Event} */ event) => {
    event.preventDefault();
    compute();
  });
  at("export-form").addEventListener("submit", (/** @type {Event} */ event) => {
    event.preventDefault();
    saveExport();
  });
  at("cancel").addEventListener("click", () => state.running?.abort());
  at("go-live").addEventListener("click", async () => {
    forget();
    at("live").hidden = false;
    at("live").scrollIntoView({ behavior: "smooth" });
    (await import("./live.js")).startLive(open);
  });
}

/** The module is kept compressed: any server sends it as it is. */
async function startModule() {
  const packed = await fetch("module/imulab.wasm.gz");
  if (!packed.ok || !packed.body) throw new Error(`the module cannot be loaded: ${packed.status}`);
  const headers = { "Content-Type": "application/wasm" };
  await prepare(new Response(packed.body.pipeThrough(new DecompressionStream("gzip")), { headers }));
  const { output } = await command(["--version"]);
  at("version").textContent = new TextDecoder().decode(output).split("\n")[0];
  await offerChoices("plan", /grade of the IMU's noise \[([a-z0-9, -]*)\]/, at("work-form").elements.grade);
  document.documentElement.dataset.ready = "true";
}

/** After the module, with which its own requests would share the line. */
function keepForOffline() {
  try {
    navigator.serviceWorker?.register("offline.js").catch(() => {});
  } catch {} // without storage the page works all the same, online
}

listen();
startModule().catch((error) => showProblem(error.message)).finally(keepForOffline);
