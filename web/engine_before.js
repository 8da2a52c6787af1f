// Emscripten's loader under node asks for modules by require, which an ES module does not have.
const underNode = typeof process === "object" && typeof process.versions?.node === "string";
const require = underNode ? (await import("node:module")).createRequire(import.meta.url) : undefined;
const __dirname = ".";
