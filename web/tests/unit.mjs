// A unit in a hand, sampled at 50 Hz: turned about its axes, and at rest. Its errors and noise are those of a fair MEMS.

/** @typedef {[number, number, number]} Vector */

/** "+x-z" as a unit vector. */
function directionOf(text) {
  const direction = [0, 0, 0];
  for (const [, sign, axis] of text.matchAll(/([+-])([xyz])/g)) direction["xyz".indexOf(axis)] = sign === "+" ? 1 : -1;
  return direction.map((c) => c / Math.hypot(...direction));
}

/** Rodrigues' rotation of v about a unit vector. */
function rotated(v, axis, angle) {
  const along = v.reduce((sum, c, i) => sum + c * axis[i], 0) * (1 - Math.cos(angle));
  const cross = axis.map((_, i) => axis[(i + 1) % 3] * v[(i + 2) % 3] - axis[(i + 2) % 3] * v[(i + 1) % 3]);
  return v.map((c, i) => c * Math.cos(angle) + cross[i] * Math.sin(angle) + axis[i] * along);
}

const times = (matrix, v) => matrix.map((row) => row.reduce((sum, c, i) => sum + c * v[i], 0));
const gyro = { matrix: [[1.01, 0.004, -0.002], [0.003, 0.992, 0.005], [-0.006, 0.001, 1.004]], offset: [0.4, -0.7, 0.2], noise: 0.01 }; // deg/s
const accel = { matrix: [[0.99, 0, 0], [0.005, 1.008, 0], [-0.003, 0.004, 1.012]], offset: [0.1, -0.05, 0.2], noise: 0.004 }; // m/s^2
const rate = 50;
const earth = (15.041 / 3600) * Math.SQRT1_2; // deg/s to the north and up, at a latitude of 45 deg

export class Unit {
  #up = [0, 0, 1]; // in the unit's axes: a phone on its back
  #north = [0, 1, 0];
  #samples = 0;
  #state = 1;

  #random() {
    this.#state = (this.#state * 48271) % 2147483647; // Park and Miller
    return this.#state / 2147483647;
  }
  #read({ matrix, offset, noise }, truth) {
    const white = () => Math.sqrt(-2 * Math.log(this.#random())) * Math.cos(2 * Math.PI * this.#random()) * noise;
    return times(matrix, truth).map((c, i) => c + offset[i] + white());
  }
  /** Rows of t, rates [deg/s] and specific forces [m/s^2] while it turns by degrees about an axis of its own. */
  #move(seconds, axis, degrees) {
    const count = Math.round(seconds * rate);
    const angle = (i) => degrees * (i / count - Math.sin((2 * Math.PI * i) / count) / (2 * Math.PI)); // it starts and ends at rest
    return Array.from({ length: count }, (_, i) => {
      const step = angle(i + 1) - angle(i);
      const back = (v) => rotated(v, axis, (-step * Math.PI) / 180);
      [this.#up, this.#north] = [back(this.#up), back(this.#north)];
      const rates = this.#read(gyro, axis.map((c, k) => c * step * rate + earth * (this.#up[k] + this.#north[k])));
      return [++this.#samples / rate, ...rates, ...this.#read(accel, this.#up.map((c) => 9.806 * c))];
    });
  }
  rest(seconds) {
    return this.#move(seconds, [1, 0, 0], 0);
  }
  /** @param {string} axis "+x-z" */
  turn(degrees, axis) {
    return this.#move(Math.max(1, degrees / 60), directionOf(axis), degrees);
  }
}
