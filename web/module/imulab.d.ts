/** What a call takes: bytes, text, a file of the browser, or files by name. */
export type Content = Uint8Array | string | Blob;
export type Input = Content | Record<string, Content> | Array<File | Record<string, Content>>;

/** What a verb answers. */
export interface Answer<Data = any> {
  /** False where the data do not support all of the request: the messages say why, and what could be determined is here. */
  supported: boolean;
  messages: string[];
  /** The JSON document that the command prints: https://github.com/imulab/imulab/blob/main/docs/reference/recordings.md */
  data: Data;
  /** One HTML page with pictures, self-contained; null where there is none. */
  page: string | null;
  /** What the command wrote, by name: session.toml, calibration.json, noise.json, compensated.csv. */
  files: Record<string, Uint8Array>;
}

export interface Conclusion {
  verdict: string | null;
  headline: string;
  warnings: string[];
}
export interface InspectedColumn {
  name: string;
  role: string;
  unit: string;
  evidence: string;
}
export interface Inspection extends Conclusion {
  file: string;
  topic: string;
  format: string;
  rows: number;
  columns: InspectedColumn[];
  time: { unit: string; rate_hz: number | null; jitter_s: number; gaps: number };
  evidence: string[];
  /** Questions that the data leave open: "KEY: why"; answered by `set`. */
  ambiguous: string[];
  problems: string[];
  /** The calibration methods that the recording supports. */
  methods: string[];
}

export interface CallOptions {
  /** Ends the call, and its worker, at once. */
  signal?: AbortSignal;
  /** Gets the line of progress that a terminal would show. */
  onProgress?: (line: string) => void;
}
/** Options of the command without dashes and in camel case: { require: "gyro.offset <= 1 deg/h" }. */
export interface VerbOptions extends CallOptions {
  /** Declares of a recording what its data leave open: { rate_hz: 100, latitude_deg: 48 }. */
  set?: Record<string, string | number>;
  [option: string]: unknown;
}
export type Method = "static" | "handheld" | "turntable" | "hybrid" | "whole-unit" | "drive" | "reference";

/** What a recording holds, with the evidence; files["session.toml"] where nothing is open. A session among the input is opened with its files. */
export function inspect(input: Input, options?: VerbOptions): Promise<Answer<Inspection>>;
/** A calibration with its uncertainties; files["calibration.json"]. The site: set.latitude_deg or set.gravity_mps2, or a session.toml among the input. */
export function calibrate(input: Input, options: VerbOptions & { method: Method }): Promise<Answer>;
/** Allan deviation and noise coefficients of a log at rest; files["noise.json"]. */
export function noise(input: Input, options?: VerbOptions): Promise<Answer>;
/** A calibration applied; files["compensated.csv"]. */
export function compensate(calibration: object | Content, input: Input, options?: VerbOptions): Promise<Answer>;
/** The page of a saved result; { certificate: true } for a calibration certificate. */
export function report(result: object | Content, options?: VerbOptions): Promise<string>;

export interface RunResult {
  /** 0: done; 1: the data do not support the request; 2: the command or a file is wrong. */
  code: number;
  output: Uint8Array;
  messages: string;
  files: Record<string, Uint8Array>;
}
export interface RunRequest {
  module?: WebAssembly.Module;
  bytes?: Uint8Array;
  words: string[];
  files?: Record<string, Content>;
  input?: Uint8Array;
}
/** Any command line, on files that are in its folder: command(["predict", "handheld.toml", "--json"], { "handheld.toml": text }). */
export function command(
  words: string[],
  files?: Record<string, Content>,
  options?: CallOptions & { input?: Uint8Array },
): Promise<RunResult>;
/** Compiles the module before the first call; `source` in place of imulab.wasm beside the module's file. */
export function prepare(source?: Response | Promise<Response>): Promise<WebAssembly.Module>;
/** The command said that its input is wrong. */
export class ImulabError extends Error {}
