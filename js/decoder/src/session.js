// One stream in one instance of the core: bytes in, events and frames out. Synchronous, except for loading codecs.

import { FvvError, IO } from "./errors.js";
import {
  readConfiguration,
  readDiagnostic,
  readEvent,
  readFrame,
  readGroups,
  readLattice,
  readSample,
} from "./wasm_structs.js";
import { createCodec, createCore } from "./wasm.js";

const events = ["need data", "configuration", "group", "frame", "damage", "end", "done", "between"];
const WANT = { floats: 1, normals: 2, visibility: 4 };
const END = 2;
/** Bytes per push. */
const PUSH_SIZE = 1 << 18;

export const defaultLimits = {
  memory: 512 * 2 ** 20,
  cacheBytes: 64 * 2 ** 20,
  maxPayload: 0,
  maxVertices: 0,
  maxFaces: 0,
  maxCameras: 0,
  maxTracks: 0,
  maxDimension: 0,
};

export class Session {
  #codec;
  #core;
  #exports;
  #decoder;
  #buffer;

  /** module: of the core. codec(name): returns the module of a codec when it is needed. */
  static async create({ module, codec, limits = {}, read }) {
    const session = new Session();
    session.#codec = codec;
    session.limits = { ...defaultLimits, ...limits };
    session.#core = await createCore(module, {
      memoryBytes: session.limits.memory,
      read,
    });
    const { exports } = session.#core;
    session.#exports = exports;
    session.#decoder = exports.fvvjs_create();
    session.#buffer = exports.fvvjs_alloc(PUSH_SIZE);
    if (!session.#decoder || !session.#buffer)
      throw new FvvError({ code: "memory", message: "out of memory while creating the decoder" });
    const l = session.limits;
    exports.fvvjs_limits(
      session.#decoder,
      l.maxPayload,
      l.maxVertices,
      l.maxFaces,
      l.maxCameras,
      l.maxTracks,
      l.maxDimension,
    );
    return session;
  }

  get #memory() {
    return this.#core.memory;
  }
  get memoryBytes() {
    return this.#memory.buffer.byteLength + this.#core.codecs.memoryBytes;
  }

  #diagnostic() {
    return readDiagnostic(this.#memory, this.#exports.fvvjs_diagnostic(this.#decoder));
  }
  #check(status) {
    if (status >= 0) return status;
    const diagnostic = this.#diagnostic();
    if (diagnostic.status === 0) diagnostic.status = status;
    throw FvvError.fromDiagnostic(diagnostic);
  }

  /** Reads the index through read; false: fetch the bytes that read lacked and try again. */
  open(size) {
    const status = this.#exports.fvvjs_open(this.#decoder, size);
    return status === IO ? false : (this.#check(status), true);
  }
  /** 0: none, 1: read from the file, 2: rebuilt from all of its bytes. */
  get indexState() {
    return this.#exports.fvvjs_index_state(this.#decoder);
  }
  groups() {
    const count = this.#exports.fvvjs_group_count(this.#decoder);
    return count ? readGroups(this.#memory, this.#exports.fvvjs_group(this.#decoder, 0), count) : [];
  }
  /** Starts at the first byte of a stream. */
  start(offset = 0) {
    this.#check(this.#exports.fvvjs_start(this.#decoder, offset, 0));
  }
  /** Starts with the file header and a configuration block, and continues with any group. */
  join() {
    this.#check(this.#exports.fvvjs_join(this.#decoder));
  }
  /** Whether the configuration of a group of the index can be read and has the digest that the group names; bytes that are missing are noted as in open. */
  hasConfiguration(group, digest) {
    return this.#exports.fvvjs_find_configuration(this.#decoder, group, digest) >= 0;
  }
  /** Starts at a group of the index; false as in open. */
  play(group) {
    const status = this.#exports.fvvjs_play(this.#decoder, group);
    return status === IO ? false : (this.#check(status), true);
  }

  /**
   * Starts at a group of the index, chunk by chunk: next reports it as far as read has the bytes, and nothing is pushed.
   * false as in open. Throws if the group is damaged or violates the rules; pushing all of its bytes gives more details.
   */
  pick(group) {
    const status = this.#exports.fvvjs_pick_group(this.#decoder, group);
    return status === IO ? false : (this.#check(status), true);
  }
  /** At the beginning of a group: no track is left out. */
  takeAll() {
    this.#check(this.#exports.fvvjs_leave_out_none(this.#decoder));
  }
  /** Then: frames come without these tracks as well, and their damage costs nothing. */
  leaveOut(tracks) {
    for (const track of tracks) this.#check(this.#exports.fvvjs_leave_out(this.#decoder, track));
  }
  /** The ranges of the other tracks' chunks: [{from, end}]. */
  picked() {
    const ranges = [];
    for (let i = 0; ;) {
      const address = this.#exports.fvvjs_picked(this.#decoder, i);
      if (!address) return ranges;
      const [from, end, next] = new Float64Array(this.#memory.buffer, address, 3);
      ranges.push({ from, end });
      i = next;
    }
  }

  /** Pushes bytes piece by piece; all events have to be taken after each piece. */
  *push(bytes) {
    for (let at = 0; at < bytes.length; at += PUSH_SIZE) {
      const piece = bytes.subarray(at, at + PUSH_SIZE);
      new Uint8Array(this.#memory.buffer, this.#buffer, piece.length).set(piece);
      this.#check(this.#exports.fvvjs_push(this.#decoder, this.#buffer, piece.length));
      yield piece.length;
    }
  }
  finish() {
    this.#exports.fvvjs_finish(this.#decoder);
  }

  /** "need data", "frame", ...; throws an error that ends the stream. */
  next() {
    return events[this.#check(this.#exports.fvvjs_next(this.#decoder))];
  }
  about() {
    return readEvent(this.#memory, this.#exports.fvvjs_event(this.#decoder));
  }
  /** Whether what was damaged is of no use for frames: sound, an environment, or a track that is left out. */
  get isSpared() {
    return this.about().whole;
  }
  /** The error of the event "damage". */
  damage() {
    return FvvError.fromDiagnostic(this.#diagnostic(), { fatal: false });
  }
  configuration() {
    const address = this.#exports.fvvjs_configuration(this.#decoder);
    return address ? readConfiguration(this.#memory, address) : null;
  }
  /** null: no configuration was read yet. */
  get lattice() {
    const address = this.#exports.fvvjs_configuration(this.#decoder);
    return address ? readLattice(this.#memory, address) : null;
  }

  /** Payload of the environment that is valid for a group of the index: {data}; null: none; false as in open. */
  findEnvironment(group, track) {
    const status = this.#exports.fvvjs_find_environment(this.#decoder, group, track);
    if (status === END) return null;
    if (status === IO) return false;
    this.#check(status);
    return readSample(this.#memory, this.#exports.fvvjs_environment(this.#decoder));
  }

  /** Whether codecs have to be loaded before decode. */
  get lacksCodecs() {
    return this.#core.codecs.lacks(this.#exports.fvvjs_codecs(this.#decoder));
  }
  /** Begins to load what the frame that is still arriving needs. */
  prepareCodecs() {
    this.#core.codecs.prepare(this.#exports.fvvjs_codecs_ahead(this.#decoder), this.#codec);
  }
  loadCodecs() {
    return this.lendCodecs(this.#core, this.#exports.fvvjs_codecs(this.#decoder));
  }
  /** Loads the codecs that an instance of a module asks for. */
  lendCodecs({ codecs }, wanted) {
    return codecs.load(wanted, async (name) => createCodec(await this.#codec(name), this.limits.memory, name));
  }

  /**
   * Decodes the frame that next reported. want null: only as a reference for later frames; the result has samples only.
   * Throws an FvvError that is not fatal if the frame violates the rules.
   */
  decode(want) {
    const flags = want
      ? WANT.floats | (want.normals ? WANT.normals : 0) | (want.visibility ? WANT.visibility : 0)
      : WANT.visibility;
    const status = this.#exports.fvvjs_decode(this.#decoder, flags);
    if (status < 0) {
      const diagnostic = this.#diagnostic();
      throw FvvError.fromDiagnostic(diagnostic, { fatal: status === -2 });
    }
    const address = this.#exports.fvvjs_frame_data(this.#decoder);
    return readFrame(this.#memory, address, this.lattice);
  }

  close() {
    this.#exports.fvvjs_destroy(this.#decoder);
    this.#core = this.#exports = null;
  }
}
