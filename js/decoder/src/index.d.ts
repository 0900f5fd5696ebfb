/** Where bytes come from. A URL is read by Range requests if the server supports them, else from front to back. Segments
 * and live streams are recognised by their URL. */
export type Source =
  | string
  | URL
  | {
      url: string | URL;
      headers?: Record<string, string>;
      credentials?: RequestCredentials;
      /** false: one request for all of it, from front to back, and nothing is kept. Default true. */
      seekable?: boolean;
      /** The URL is that of a manifest of segments. Default: true if its path ends with .json. */
      segments?: boolean;
    }
  | {
      /** ws: or wss:, a live stream as fvvserve sends it. */
      url: string | URL;
      protocols?: string | string[];
      /** true: as the option network says. attempts: how many at most since the last data; firstMs, longestMs: in place of those of
       * network. Default: never. */
      reconnect?: boolean | { attempts?: number; firstMs?: number; longestMs?: number };
      /** For environments without one, such as Node before 22; the caller's thread decodes then. */
      WebSocket?: new (url: string, protocols?: string | string[]) => unknown;
    }
  | Blob
  | ArrayBuffer
  | ArrayBufferView
  | ReadableStream<Uint8Array>
  | AsyncIterable<Uint8Array | ArrayBuffer>;

/** All values are optional. */
export interface Limits {
  /** Bytes of one wasm instance; there is one per module in use. Default 512 MiB. */
  memory?: number;
  /** Bytes of URLs and segments that are kept for loops and seeks. Together with the instances they stay below memory.
   * Default 64 MiB; 0: none. */
  cacheBytes?: number;
  maxPayload?: number;
  maxVertices?: number;
  maxFaces?: number;
  maxCameras?: number;
  maxTracks?: number;
  maxDimension?: number;
}

/** Milliseconds; see "Networks that fail" in the README. */
export interface NetworkPolicy {
  /** Until a host responds, or a WebSocket is open. Default 10000. */
  connectMs?: number;
  /** Until the first byte of a body. Default 10000. */
  firstByteMs?: number;
  /** Between two pieces of a body. Default 10000. */
  progressMs?: number;
  /** A host that responded sooner lately, and of which nothing comes for so long, is asked again beside. Default 1500. */
  quickMs?: number;
  /** Of a live connection without a message, until it gets a ping, and then until it is lost. Default 10000. */
  silenceMs?: number;
  /** Until any of these after the event "online". Default 1500. */
  onlineMs?: number;
  /** The first wait, which doubles up to longestMs. Defaults 250 and 2500. */
  firstMs?: number;
  longestMs?: number;
  /** A host that sends a longer Retry-After is not waited for. Default 120000. */
  retryAfterMaxMs?: number;
  /** Without a byte for so long, the error is fatal. Default 60000. */
  budgetMs?: number;
  /** The same while the source is opened. Default 5000. */
  openBudgetMs?: number;
}

/** Requests fail and are tried again. */
export interface Outage {
  url: string;
  reason: string;
  offline: boolean;
  /** From 0 on. */
  attempt: number;
  /** Until the next attempt. */
  retryMs: number;
}

export interface Options {
  /** Time-outs and retries. */
  network?: NetworkPolicy;
  /** As the events stalled and recovered, also while the decoder is created; null: bytes come again. */
  onOutage?: (outage: Outage | null) => void;
  /** Returns what replaces an address that has expired; null: nothing does. */
  renewAddress?: (expired: {
    url: string;
    status: number;
  }) => Promise<string | { url: string; headers?: Record<string, string> } | null>;
  /** Without it, write the stream to decoder.writable. */
  source?: Source;
  limits?: Limits;
  signal?: AbortSignal;
  /** Default: a worker of this package, if the environment has workers. false: none. Or the URL of its script. */
  worker?: boolean | Worker | URL | string | (() => Worker);
  /** Vertex normals, transmitted or computed. Default true. */
  normals?: boolean;
  /** Visibility weights of vertices (clause 17.4). Default true. */
  visibility?: boolean;
  /** "decoded": frames have pictures; "encoded": samples only. Default: decoded with WebCodecs or videoFallback. */
  video?: "decoded" | "encoded";
  /** Decoders for video that WebCodecs cannot decode, or for environments without it: () => import("@fvv/video-fallback").
   * Called in this thread, and only when a track needs it. Default: a warning, and frames without pictures. */
  videoFallback?: () => Promise<VideoFallback | WebAssembly.Module>;
  /** Sound arrives with the event "sound": "decoded" as SoundBlock, "encoded" as SoundPackets. Default false: no sound is read. */
  sound?: false | "decoded" | "encoded";
  /** A decoder of Opus for environments whose WebCodecs has none: () => import("opus-decoder"). Called in this thread, and
   * only when a track needs it. Default: a warning, and silence. */
  soundFallback?: () => Promise<SoundFallback>;
  /** Number of frames that are decoded ahead. Default 4. */
  queue?: number;
  /** Tracks of video, as select takes them, from the first frame on. Default all. */
  tracks?: number[] | null;
  /** Selects tracks for a viewpoint, as look does, from the first frame on. */
  look?: Viewpoint;
  /** Which rung of a ladder is played: "auto" (the default), or its number, 0 for the best. */
  rung?: RungChoice;
}

/** "auto" chooses by throughput and buffer from a URL or segments; from memory and files it takes the best rung. */
export type RungChoice = "auto" | number;

/** A choice among the alternatives of a stream (clause 5.2). */
export interface Rung {
  /** 0 is the best. */
  rung: number;
  /** Nominal, bits per second; 0: not stated. */
  bitRate: number;
  /** Pixels of its video frames; 0: not stated. */
  size: number;
  /** Pixels of the video for a pixel of the cameras' pictures, along one axis; null: it has no tiles. */
  scale: number | null;
  tracks: number[];
}

/** The rung that is played from here on. */
export interface RungChange extends Rung {
  /** "start": nothing is known of the network; "throughput", "buffer", "delay" (of a live stream): the rule that chose; "late": what
   * was chosen would have come too late; "chosen": by setRung. */
  reason: "start" | "throughput" | "buffer" | "delay" | "late" | "chosen";
  /** Bits per second; null: not measured. */
  throughput: number | null;
  /** Seconds that have arrived and are not played; null: not known. */
  buffer: number | null;
}

/** The viewer's position and target in world coordinates, and how a picture from there is textured (docs/tools/fvvrender.md). */
export interface Viewpoint {
  eye: ArrayLike<number>;
  target: ArrayLike<number>;
  /** Metres that the eye may have moved before the next choice takes effect: cameras that it needs there are included. Default 0. */
  margin?: number;
  /** Fraction of the picture that has the same colour as with all cameras. Default 0.95; 1: every camera that gives any
   * colour is selected. */
  share?: number;
  /** Radius of the scene in metres. Default: a fifth of the distance from eye to target. */
  radius?: number;
  /** The rule of the stream (TEXR), which look knows. Default: that of a stream without one. The next three replace its parts. */
  texturing?: Pick<Texturing, "blend" | "threshold" | "best">;
  blend?: "viewer" | "paper";
  /** Number of cameras for a point of the surface. */
  best?: number;
  /** Minimum cosine between the normal and the ray to a camera that gives colour. */
  threshold?: number;
}

/** The cameras that together colour the fraction share of a ball at the target, seen from eye, by the rule of clause 17.5; the
 * largest share first. Empty if no camera shows the target. */
export function camerasFor(cameras: Camera[], viewpoint: Viewpoint): { camera: number; share: number }[];

/** The part of npm's opus-decoder that is used. */
export interface SoundFallback {
  OpusDecoder: new (options: object) => {
    ready: Promise<void>;
    decodeFrames(packets: Uint8Array[]): { channelData: Float32Array[]; errors: { message: string }[] };
    free(): void;
  };
}

/** The interface of @fvv/video-fallback. */
export interface VideoFallback {
  compile(): Promise<WebAssembly.Module>;
}

export type Code =
  | "argument"
  | "memory"
  | "io"
  | "state"
  | "damaged"
  | "truncated"
  | "invalid"
  | "unsupported"
  | "limit"
  | "bug"
  | "gap"
  | "changed"
  | "reconnect"
  | "skipped"
  | "no-range"
  | "no-index"
  | "video"
  | "worker";

export class FvvError extends Error {
  readonly code: Code;
  /** n of FVV-n in spec/issues.md; 0: no rule of the format is violated. */
  readonly issue: number;
  /** Of "error" something is damaged or violates the format; of "warning" something is restricted or was left out. */
  readonly severity: "error" | "warning";
  /** No further frames follow. */
  readonly fatal: boolean;
  /** Type of the chunk; "": none. */
  readonly chunk: string;
  /** Bytes from the beginning of the stream. */
  readonly offset: number | null;
  /** Number of the frame at which damage was found; null: not known. */
  readonly frame: number | null;
  /** Of code "gap": time of the last good frame, and beginning of the next group, in ticks; null: none. Its cause is an FvvError. */
  readonly from: bigint | null;
  readonly to: bigint | null;
}

export class FvvEvent<T> extends Event {
  readonly detail: T;
}

export interface Rect {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** Where a camera's picture, or a part of it, is in the video. */
export interface Tile {
  camera: number;
  source: Rect;
  destination: Rect;
}

export interface Video {
  track: number;
  /** "avc1", "hvc1", "vp09", "av01", "jpeg", "oexr" */
  codec: string;
  /** As WebCodecs takes it; "" for still pictures. */
  codecString: string;
  /** Configuration record as in MP4. */
  record: Uint8Array;
  width: number;
  height: number;
  bitDepth: number;
  shows: "tiles" | "atlas";
  /** Code points of ITU-T H.273. */
  colour: { primaries: number; transfer: number; matrix: number; fullRange: boolean };
  /** For groups without a layout of their own; use frame.tiles. Lists all cameras that the track ever shows. */
  tiles: Tile[];
}

/** World -> camera: R x + t, x right, y down, z forward; pixel centres at +0.5. */
export interface Camera {
  readonly id: number;
  readonly name: string;
  readonly width: number;
  readonly height: number;
  readonly fx: number;
  readonly fy: number;
  readonly cx: number;
  readonly cy: number;
  readonly skew: number;
  readonly lens: "none" | "radtan" | "fisheye";
  readonly distortion: readonly number[];
  readonly rMax: number;
  /** Row-major, 9 numbers. */
  readonly rotation: readonly number[];
  readonly translation: readonly number[];
  readonly moves: boolean;
  /** false: the camera moves and its calibration in this frame is unknown; it gives no colours. */
  readonly calibrated: boolean;
  readonly centre: [number, number, number];
  /** World metres -> u, v, depth; null: behind the camera or beyond the range of its lens. */
  project(x: number, y: number, z: number): [number, number, number] | null;
  /** The same for x y z of many points; NaN instead of null. */
  projectPoints(points: ArrayLike<number>): Float64Array;
  /** Pixel -> ray in the camera's frame with z = 1. */
  unproject(u: number, v: number): [number, number, number] | null;
}

export interface Texturing {
  /** What weights cameras: their angle to the viewer's direction, or to the normal alone, as WHP 235. */
  blend: "viewer" | "paper";
  /** Minimum cosine between the normal and the ray to a camera that gives colour. */
  threshold: number;
  /** Maximum number of cameras that are mixed at a point. */
  best: number;
  /** Colour of surface that no camera shows: 0xRRGGBB, display values. */
  unseen: number;
  /** Tolerance of depth maps, in pixel widths, and relative to the change of depth from pixel to pixel. */
  depthBias: number;
  depthSlope: number;
  /** By how much the surface that cameras show lies inside the mesh, in units of the scene; 0 or more. */
  inset: number;
}

export interface Track {
  id: number;
  kind: string;
  name: string;
  /** Seconds per tick of times in the track's payloads; null: as the scene's. */
  timeBase: { numerator: number; denominator: number } | null;
  /** Tracks with the same number other than 0 show the same thing; rank 0 is the best. */
  alternateGroup: number;
  rank: number;
  /** Nominal, bits per second; 0: not stated. */
  bitRate: number;
  /** Nominal: pixels of a video frame, faces of a mesh; 0: not stated. */
  size: number;
}

/** What is played together is up to the player: among tracks with one language all of them. Their names are in tracks. */
export interface SoundTrack {
  track: number;
  codec: "opus" | "mp4a";
  channels: number;
  /** Samples that each packet decodes to. */
  packetDuration: number;
  /** Packets to decode before the output is right. */
  preroll: number;
  /** From where it is heard, in metres; null: everywhere, as it was mixed. */
  position: [number, number, number] | null;
  /** Each chunk has a position of its own. */
  moves: boolean;
  /** Opus: the header of RFC 7845, clause 5.1; AAC: AudioSpecificConfig. */
  record: Uint8Array;
  /** BCP 47, or empty. */
  language: string;
}

/** Decoded sound, with sound: "decoded". Blocks of a track follow each other; where one does not, there is silence between. */
export interface SoundBlock {
  track: number;
  /** Number of its first sample, from the scene's time 0 on. */
  start: number;
  seconds: number;
  /** Samples per second. */
  rate: number;
  channels: Float32Array[];
  /** At its beginning; it moves in a straight line to that of the next block. null: not placed. */
  position: [number, number, number] | null;
}

/** Encoded sound, with sound: "encoded": the chunks of the stream (clause 20.2). */
export interface SoundPackets {
  track: number;
  /** Number of the sample at which the output of the first packet begins. */
  start: bigint;
  packetCount: number;
  /** Packets at the front that repeat the end of the group before. */
  prerollCount: number;
  /** If the track moves. */
  position: [number, number, number];
  /** Of each packet in data, where they follow one another. */
  sizes: Uint16Array;
  data: Uint8Array;
}

export interface Configuration {
  /** Seconds per tick. */
  timeBase: { numerator: number; denominator: number };
  frameDuration: bigint;
  /** metres = origin + step * index */
  lattice: { origin: [number, number, number]; step: number };
  /** What localPositions of all meshes and environments count from: 0 unless the stream is far from 0, as in map coordinates. */
  localOrigin: [number, number, number];
  upAxis: "unknown" | "x" | "y" | "z" | "-x" | "-y" | "-z";
  /** false: lengths are not in metres. */
  scaleKnown: boolean;
  tracks: Track[];
  cameras: Camera[];
  videos: Video[];
  sounds: SoundTrack[];
  /** JSON texts. */
  metadata: string[];
  /** How the stream is to be coloured (TEXR). Defaults: "viewer", 0.05, 3, 0x808080, 0.2, 0.5, 0. */
  texturing: Texturing;
}

export interface Mesh {
  track: number;
  profile: "raw" | "draco" | "delta" | "field" | "fast" | "patched";
  key: boolean;
  vertexCount: number;
  faceCount: number;
  /** x y z on the lattice. */
  lattice: Int32Array;
  /** x y z in metres. Far from 0 their 32 bits are coarse: 0.25 m at 4,000 km. Draw localPositions. */
  positions: Float32Array;
  /** x y z in metres, relative to origin; the same array as positions where origin is 0. */
  localPositions: Float32Array;
  origin: [number, number, number];
  /** Three per face, counter-clockwise seen from outside. */
  faces: Uint32Array;
  normals: Float32Array | null;
  /** u v, (0, 0) is the top left corner of the atlas. */
  uvs: Float32Array | null;
  /**
   * R G B 255 of each vertex, display values (COLR): for places that no camera shows, and for all of the mesh where there are
   * no pictures. Of low resolution. null if the stream has none for this mesh.
   */
  colours: Uint8Array | null;
}

export interface Visibility {
  track: number;
  meshTrack: number;
  /** Vertices of which no face has a greater cosine to a camera have the weight 127. */
  threshold: number;
  cameras: number[];
  vertexCount: number;
  /** A row of vertexCount visibility weights for each camera, 0 to 255: seen from 127.5 on. */
  weights: Uint8Array;
  weightsOf(camera: number): Uint8Array | null;
}

export interface Sample {
  track: number;
  key: boolean;
  data: Uint8Array;
}

/** A picture of videoFallback in environments without VideoFrame, or without 10-bit VideoFrame. Its planes are in memory. */
export interface PlanarPicture {
  /** I420P10: two bytes per sample, little-endian. null when closed. */
  readonly format: "I420" | "I420P10" | null;
  readonly codedWidth: number;
  readonly codedHeight: number;
  readonly displayWidth: number;
  readonly displayHeight: number;
  readonly codedRect: Rect | null;
  readonly visibleRect: Rect | null;
  /** Microseconds. */
  readonly timestamp: number;
  readonly duration: null;
  /** Names of WebCodecs; null for code points without a name. */
  readonly colorSpace: {
    primaries: string | null;
    transfer: string | null;
    matrix: string | null;
    fullRange: boolean;
  };
  /** Y, U and V one after the other. Belongs to the picture. */
  readonly data: Uint8Array | null;
  allocationSize(options?: CopyOptions): number;
  copyTo(destination: BufferSource, options?: CopyOptions): Promise<{ offset: number; stride: number }[]>;
  clone(): PlanarPicture;
  close(): void;
}

export interface CopyOptions {
  /** x and y have to be even. Default: the whole picture. */
  rect?: Rect;
  /** Of Y, U and V, in bytes. Default: without gaps. */
  layout?: { offset: number; stride: number }[];
  /** Has to be the format of the picture. */
  format?: "I420" | "I420P10";
}

export type Picture = VideoFrame | ImageBitmap | PlanarPicture;

export interface Frame {
  /** Exact if there is an index; else counted from the first frame received. */
  readonly number: number;
  /** Ticks. */
  readonly time: bigint;
  readonly seconds: number;
  /** Seconds of the newest frame of a live stream that had arrived with it, over WebSocket; null: not known. */
  readonly edgeSeconds: number | null;
  readonly duration: number;
  readonly group: { sequence: number; start: bigint; end: bigint };
  readonly configuration: Configuration;
  readonly meshes: Mesh[];
  readonly mesh: Mesh | null;
  readonly visibility: Visibility[];
  /** As they are in this frame. */
  readonly cameras: Camera[];
  /** Of the selected tracks. */
  readonly samples: Sample[];
  /** Tracks of video that were selected for its group; null: all. Other tracks have neither samples nor tiles. */
  readonly tracks: number[] | null;
  /** The rung that the frame is of; null: the stream has no ladder. */
  readonly rung: number | null;
  readonly pictures: { track: number; picture: Picture }[];
  /** Time for decoding meshes, visibility and calibration. */
  readonly decodeMs: number;
  camera(id: number): Camera | null;
  picture(track?: number): Picture | null;
  /** Where each camera's picture is in the video: the layout of the frame's group, which may change with the next group. */
  tiles(track?: number): Tile[];
  /** Closes the pictures; everything else stays valid. */
  close(): void;
}

/** A mesh of the environment, in one colour or textured with one picture. */
export interface EnvironmentPart {
  vertexCount: number;
  faceCount: number;
  /** Metres. */
  positions: Float32Array;
  /** Relative to origin, which is that of the meshes. */
  localPositions: Float32Array;
  origin: [number, number, number];
  faces: Uint32Array;
  /** u v in the picture, (0, 0) is its top left corner; beyond 0 to 1 the picture is repeated, or clamped. */
  uvs: Float32Array | null;
  /** Index in pictures. */
  picture: number | null;
  /** Linear light, 0 to 1; multiplies the picture's. */
  colour: [number, number, number];
  unlit: boolean;
  doubleSided: boolean;
  clamped: boolean;
}

/** As in KHR_lights_punctual of glTF. */
export interface Light {
  type: "directional" | "point" | "spot";
  position: [number, number, number];
  /** The direction in which the light travels. */
  direction: [number, number, number];
  colour: [number, number, number];
  /** Lux for directional lights, else candela. */
  intensity: number;
  /** Metres; 0: unlimited. */
  range: number;
  /** Radians. */
  innerCone: number;
  outerCone: number;
  castsShadows: boolean;
}

export interface Environment {
  track: number;
  parts: EnvironmentPart[];
  /** Whole files, sRGB. */
  pictures: { type: "image/jpeg" | "image/png"; width: number; height: number; data: Uint8Array }[];
  lights: Light[];
}

export interface Stats {
  frames: number;
  /** Decoded on the way to a frame that was sought. */
  skipped: number;
  decodeMs: number;
  pictures: number;
  queued: number;
  memoryBytes: number;
  /** Received from the network. */
  bytesRead: number | null;
  requests: number | null;
  /** Memory of the cache; not included in memoryBytes. */
  cachedBytes: number;
  /** Reads that began with bytes of the cache and saved a request, and the number of bytes taken from the cache. */
  cacheHits: number;
  bytesReused: number;
}

export interface DecoderEvents {
  configuration: Configuration;
  /** All environments that are valid from here on; none after a change of configuration. */
  environment: Environment[];
  /** Playback continues: fatal is false. Missing frames have the code "gap". */
  warning: FvvError;
  /** Playback has ended: fatal is true. */
  error: FvvError;
  stalled: Outage;
  recovered: null;
  end: null;
  /** Sound as soon as it is read, half a second ahead of the frames; a configuration before it. */
  sound: SoundBlock | SoundPackets;
  /** A seek: sound from another time follows. */
  soundrestart: null;
  /** A live stream starts again: times go back. */
  restart: null;
  /** groups, frameCount or seekable have changed: a single response is complete or no longer kept, or the file has
   * changed. */
  groups: readonly Group[] | null;
  stats: Stats;
  /** Another rung of the ladder is played from here on. */
  rung: RungChange;
}

/** A group in the index. */
export interface Group {
  /** Bytes from the beginning of the stream; for segments, as if their files followed the configuration. */
  offset: number;
  size: number;
  /** Ticks: times t with start <= t < end. */
  start: bigint;
  end: bigint;
  sequence: number;
  frameCount: number;
  /** false: part of it is damaged or missing. */
  intact: boolean;
  /** Size of its last chunk, GEND; 0: none. */
  endSize: number;
  /** Where its configuration block is; size 0: not known. */
  configurationOffset: number;
  configurationSize: number;
}

export interface Decoder extends EventTarget, AsyncIterable<Frame> {
  /** null until the first frame. */
  readonly configuration: Configuration | null;
  /** Environments that have arrived; frames don't wait for them. */
  readonly environments: Environment[];
  /** For a host without Range support: true as long as all received bytes are kept. */
  readonly seekable: boolean;
  /** null: not known (yet). */
  readonly frameCount: number | null;
  /** In the order of time; null: not known (yet). */
  readonly groups: readonly Group[] | null;
  readonly inWorker: boolean;
  /** Takes the bytes of the stream if there is no source. */
  readonly writable: WritableStream<Uint8Array> | null;
  frames(): AsyncIterableIterator<Frame>;
  /** null at the end; rejects with a fatal FvvError. */
  next(): Promise<Frame | null>;
  seek(place: ({ frame: number } | { time: bigint } | { seconds: number }) & { rung?: number | null }): Promise<void>;
  /** Tracks of video in frames; null: all. Takes effect with the next group at the latest; see frame.tracks. Other tracks
   * are not decoded, and not fetched from hosts that support Range. */
  select(wanted: { tracks: number[] | null }): Promise<void>;
  /** Rungs of the current configuration, best first; one entry without a ladder. */
  readonly rungs: Rung[];
  /** As it was chosen; frame.rung has the one that is played. */
  readonly rung: RungChoice;
  /** From the next group on at the latest. Groups that were read ahead are read again. */
  setRung(rung: RungChoice): Promise<void>;
  /** Pixels on the screen for a pixel of the cameras' pictures: "auto" takes no rung that is finer than it needs to be. null: not
   * known. */
  setShownScale(scale: number | null): Promise<void>;
  /**
   * The rung that is worth fetching for a frame that stays on screen, by a seek to the same frame: that of setRung, else the best
   * that is shown and that the network carries, at half the speed of playback unless the frame `plays` on. null: there is no
   * ladder, or nothing is known of the network.
   */
  lastingRung(wanted?: { plays?: boolean }): Promise<number | null>;
  /** Selects the tracks that a picture needs (camerasFor), and again when the configuration changes. Before the
   * configuration has arrived both lists are empty, and the selection is made when it arrives. */
  look(viewpoint: Viewpoint): Promise<{ cameras: { camera: number; share: number }[]; tracks: number[] }>;
  stats(): Promise<Stats>;
  /** Times (ticks) that can be played without the network, in order and disjoint: the cached bytes of URLs and segments, and
   * all of Blobs and bytes with an index. */
  buffered(): Promise<{ start: bigint; end: bigint }[]>;
  close(): void;
  addEventListener<T extends keyof DecoderEvents>(
    type: T,
    listener: (event: FvvEvent<DecoderEvents[T]>) => void,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject | null,
    options?: boolean | AddEventListenerOptions,
  ): void;
  removeEventListener<T extends keyof DecoderEvents>(
    type: T,
    listener: (event: FvvEvent<DecoderEvents[T]>) => void,
    options?: boolean | EventListenerOptions,
  ): void;
  removeEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject | null,
    options?: boolean | EventListenerOptions,
  ): void;
}

export function createDecoder(options?: Options): Promise<Decoder>;
