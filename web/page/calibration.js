// The calibration that the page applies: what it is, and whether the log is of the same unit.

/** @typedef {import("./module/imulab.js").Content} Content */
/** @typedef {{ content: Content, imu: string, serial: string | null, method: string, created: string, from: string }} Chosen */

/** @param {Content} content @returns {Promise<string>} */
export const textOf = async (content) =>
  typeof content === "string" ? content : content instanceof Uint8Array ? new TextDecoder().decode(content) : content.text();

/** Null for what is no calibration. @param {Content} content @param {string} from its file, or the log that it was computed from @returns {Promise<Chosen | null>} */
export async function readCalibration(content, from) {
  try {
    const { format, imu, serial, method, created } = JSON.parse(await textOf(content));
    return String(format).startsWith("imulab.calibration/") ? { content, imu, serial: serial ?? null, method, created, from } : null;
  } catch {
    return null;
  }
}

/** "calibration of IMU-7, serial 12 (handheld, 2026-03-31 12:00), from walk.csv" @param {Chosen} c */
export function describeCalibration(c) {
  const when = String(c.created ?? "").slice(0, 16).replace("T", " ");
  const how = [c.method, when].filter(Boolean).join(", ");
  return `calibration of ${c.imu}${c.serial ? `, serial ${c.serial}` : ", no serial number"}${how ? ` (${how})` : ""}, from ${c.from}`;
}

/** The serial number that a session declares. @param {string | null} session @returns {string | null} */
export function serialOf(session) {
  const imu = /^\[imu\][ \t]*\r?\n((?:(?!\[)[^\n]*\n?)*)/m.exec(session ?? "")?.[1] ?? "";
  const found = /^[ \t]*serial[ \t]*=[ \t]*(?:"((?:[^"\\]|\\.)*)"|'([^']*)')/m.exec(imu);
  return found ? (found[1] ?? found[2]) : null;
}

/** The question that two serial numbers ask; empty where one is not known or they are the same. @param {Chosen | null} c @param {string | null} session */
export function otherUnit(c, session) {
  const serial = serialOf(session);
  return c?.serial && serial && c.serial !== serial ? `The log is of serial ${serial}, the calibration of ${c.serial}: apply it all the same` : "";
}
