// Open questions as form fields.

/** What the units of a key may be; a text beyond these is the command's to judge. @type {Record<string, string>} */
const units = { "gyro.unit": "rad/s deg/s deg/h count", "accel.unit": "m/s^2 g count", "time.unit": "s ms us ns" };

/** The keys that answer a question: "gyro.columns, accel.columns: why". @param {string} question */
export function keysOf(question) {
  return question.slice(0, question.indexOf(":")).split(", ").filter((key) => /^[a-z0-9_.]+$/.test(key));
}

/** What an answer would mean, as the question says: "deg/s gives N 0.3 deg/sqrt(h), as grade mems". @param {string} question @param {string} choice */
function consequence(question, choice) {
  const begin = question.indexOf(`${choice} gives `);
  return begin < 0 ? "" : question.slice(begin + choice.length + 1).split(";")[0];
}

/** The answers that there are: units, tables, or three columns that stand together. @param {string} key @param {string} question @param {string[]} columns @returns {string[][]} */
function choicesOf(key, question, columns) {
  if (units[key]) return units[key].split(" ").map((unit) => [unit, consequence(question, unit)]);
  if (key === "topic") return question.slice(question.indexOf(": ") + 2).split(", ").map((name) => [name, ""]);
  if (!key.endsWith(".columns")) return [];
  const names = columns.map((name, i) => (/^$|[,;\s]/.test(name) ? String(i + 1) : name)); // as a declaration names them
  return names.slice(2).map((_, i) => [names.slice(i, i + 3).join(","), ""]);
}

/**
 * Fields whose legend is the question, one a key.
 * @param {string} question "gyro.unit: why" @param {Record<string, string>} declared @param {string[]} columns of the recording
 */
export function questionFields(question, declared, columns) {
  const make = (/** @type {string} */ tag, /** @type {object} */ more) => Object.assign(document.createElement(tag), more);
  const keys = keysOf(question);
  const all = make("fieldset", {});
  all.append(make("legend", { textContent: question }));
  for (const key of keys) {
    const label = make("label", { textContent: `${key} ` });
    const input = make("input", { name: key, required: keys.length === 1, value: declared[key] ?? "", autocomplete: "off" });
    label.append(input);
    const choices = choicesOf(key, question, columns);
    if (choices.length > 0) {
      const list = make("datalist", { id: `choices-${key}` });
      list.append(...choices.map(([value, means]) => make("option", { value, label: means ? `${value} ${means}` : value })));
      input.setAttribute("list", list.id);
      input.setAttribute("placeholder", key.endsWith(".columns") ? "three columns: x,y,z" : "");
      label.append(list);
    }
    all.append(label);
  }
  return all;
}
