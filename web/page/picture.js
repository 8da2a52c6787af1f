// A unit as a box with its axes, as it lies now and as it should lie next: directions are the command's own texts, such as "the edge +x-y".

/** @typedef {[number, number, number]} Vector */

/** @param {string} text @returns {Vector | null} the direction of "+x", "the edge +x-y", "the corner +x-y+z" */
export function directionOf(text) {
  const signs = [...text.matchAll(/([+-])([xyz])/g)];
  if (signs.length === 0) return null;
  /** @type {Vector} */
  const direction = [0, 0, 0];
  for (const [, sign, axis] of signs) direction["xyz".indexOf(axis)] = sign === "+" ? 1 : -1;
  const length = Math.hypot(...direction);
  return /** @type {Vector} */ (direction.map((c) => c / length));
}

/** @param {Vector} a @param {Vector} b @returns {Vector} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @param {Vector} a @param {Vector} b */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** The view of a body whose direction `up` points up: a function to the plane of the picture. @param {Vector} up */
function viewOf(up) {
  const side = /** @type {Vector} */ (Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  const along = dot(side, up);
  const right = /** @type {Vector} */ (side.map((c, i) => c - along * up[i]));
  const length = Math.hypot(...right);
  const unit = /** @type {Vector} */ (right.map((c) => c / length));
  const back = cross(up, unit);
  return (/** @type {Vector} */ v) => {
    const [x, y, z] = [dot(v, unit), dot(v, back), dot(v, up)]; // to the right, away, up
    return [0.87 * x + 0.5 * y, -(z + 0.35 * y - 0.2 * x)];
  };
}

const size = /** @type {Vector} */ ([0.5, 0.8, 0.25]); // half of a box, so that its sides differ

/** @param {string} name @param {Record<string, string | number>} attributes @param {string} [text] */
function part(name, attributes, text) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  if (text) element.textContent = text;
  return element;
}

/** @param {Vector} up @param {Vector | null} axis of the turn @param {string} title @param {number} shift */
function box(up, axis, title, shift) {
  const view = viewOf(up);
  const group = part("g", { transform: `translate(${shift} 110) scale(62)`, fill: "none", stroke: "currentColor", "stroke-width": 0.03 });
  const corner = (/** @type {number} */ code) => view(/** @type {Vector} */ (size.map((s, i) => (code & (1 << i) ? s : -s))));
  for (let from = 0; from < 8; ++from)
    for (const bit of [1, 2, 4]) {
      if (from & bit) continue;
      const [[x1, y1], [x2, y2]] = [corner(from), corner(from | bit)];
      group.append(part("line", { x1, y1, x2, y2 }));
    }
  for (const [i, name] of ["x", "y", "z"].entries()) {
    const end = /** @type {Vector} */ ([0, 0, 0]);
    end[i] = size[i] + 0.45;
    const [x2, y2] = view(end);
    const [x, y] = view(/** @type {Vector} */ (end.map((c) => 1.25 * c)));
    group.append(part("line", { x1: 0, y1: 0, x2, y2, "stroke-dasharray": 0.06 }));
    const middle = { "text-anchor": "middle", "dominant-baseline": "central" };
    group.append(part("text", { x, y, "font-size": 0.26, fill: "currentColor", stroke: "none", ...middle }, `+${name}`));
  }
  if (axis) {
    const [x, y] = view(/** @type {Vector} */ (axis.map((c) => 1.3 * c)));
    group.append(part("line", { x1: -x, y1: -y, x2: x, y2: y, stroke: "#d06000", "stroke-width": 0.05 }));
    group.append(part("circle", { cx: x, cy: y, r: 0.08, fill: "#d06000", stroke: "none" }));
  }
  group.append(part("text", { x: 0, y: -1.78, "font-size": 0.24, fill: "currentColor", stroke: "none", "text-anchor": "middle" }, title));
  return group;
}

/** @param {string} up the side that points up now @param {string} next "turn by 90 deg about -y until +x points up" */
export function turnPicture(up, next) {
  const picture = part("svg", { viewBox: "-20 -14 390 214", role: "img", "aria-label": next || up });
  const now = directionOf(up);
  const [, axis, then] = /about (\S+) until (.*) points up/.exec(next) ?? [];
  if (now) picture.append(box(now, axis ? directionOf(axis) : null, "now", 80));
  const target = then ? directionOf(then) : null;
  if (target) picture.append(box(target, null, "next", 270));
  return picture;
}
