// The static environment and the lights (clause 18), decoded from the payload of a BACK chunk by a module of its own.

import { FvvError } from "./errors.js";
import { localOriginOf, readEnvironmentList, readDiagnostic, readPart } from "./wasm_structs.js";
import { createEnvironment } from "./wasm.js";

/** payload: {track, data}. module(): the compiled module. */
async function readEnvironment({ track, data }, { module, session }) {
  const { limits } = session;
  const core = await createEnvironment(await module(), limits.memory);
  const { exports } = core;
  const fail = (status) => {
    const diagnostic = readDiagnostic(core.memory, exports.fvvback_diagnostic());
    if (diagnostic.status === 0) diagnostic.status = status;
    throw FvvError.fromDiagnostic(diagnostic, { fatal: false });
  };
  const address = exports.fvvback_alloc(data.length);
  if (!address) throw new FvvError({ code: "memory", fatal: false, message: "no memory for an environment" });
  new Uint8Array(core.memory.buffer, address, data.length).set(data);
  const status = exports.fvvback_load(address, data.length, limits.maxVertices, limits.maxFaces, limits.maxDimension);
  if (status < 0) fail(status);
  const { codecs, partCount, pictures, lights, lattice } = readEnvironmentList(core.memory, exports.fvvback_data());
  // All of a stream counts from one place.
  const origin = localOriginOf(session.lattice);
  await session.lendCodecs(core, codecs);
  const parts = Array.from({ length: partCount }, (_, i) => {
    const part = exports.fvvback_part(i);
    if (!part) fail(0);
    return readPart(core.memory, part, lattice, origin);
  });
  return { track, parts, pictures, lights };
}

/** The environments of a stream in the order of arrival: one per environment track and configuration. */
export class Environments {
  #module;
  #session;
  #emit;
  tracks = new Set();
  #configuration = null;
  /** emit("environment", environment; null: the former ones are no longer valid), emit("warning", error). */
  constructor({ module, session, emit }) {
    this.#module = module;
    this.#session = session;
    this.#emit = emit;
  }
  /** configuration: the digest in the header of a group. */
  begin(configuration) {
    if (configuration === this.#configuration) return;
    if (this.tracks.size) this.#emit("environment", null);
    this.#configuration = configuration;
    this.tracks.clear();
  }
  /** payloads: each {track, data}, or null. */
  async take(payloads) {
    for (const payload of payloads) {
      if (!payload || this.tracks.has(payload.track)) continue;
      this.tracks.add(payload.track);
      const configuration = this.#configuration;
      try {
        const found = await readEnvironment(payload, { module: this.#module, session: this.#session });
        if (configuration === this.#configuration) this.#emit("environment", found);
      } catch (error) {
        if (!(error instanceof FvvError)) throw error;
        error.fatal = false;
        this.#emit("warning", error);
      }
    }
  }
}
