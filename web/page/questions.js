// Open questions as form fields.

/** What the units of a key may be; a text beyond these is the command's to judge. @type {Record<string, string>} */
const units = { "gyro.unit": "rad/s deg/s deg/h count", "accel.unit": "m/s^2 g count", "time.unit": "s ms us ns" };

/** A field whose label is the question. @param {string} question "gyro.unit: why" @param {string} value */
export function questionField(question, value) {
  const key = question.slice(0, question.indexOf(":"));
  const label = Object.assign(document.createElement("label"), { textContent: question });
  const input = Object.assign(document.createElement("input"), { name: key, required: true, value, autocomplete: "off" });
  label.append(input);
  if (units[key]) {
    const list = Object.assign(document.createElement("datalist"), { id: `choices-${key}` });
    list.append(...units[key].split(" ").map((unit) => Object.assign(document.createElement("option"), { value: unit })));
    input.setAttribute("list", list.id);
    label.append(list);
  }
  return label;
}
