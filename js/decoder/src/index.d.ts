/** Where bytes come from. A URL is read by Range where the server can, else from front to back; segments and live streams
 * by their URL. */
export type Source =
  | string
  | URL
  | {
      url: string | URL;
      headers?: Record<string, string>;
      credentials?: RequestCredentials;
      /** false: one request for all of it, from front to back, and nothing is kept. Default true. */
      seekable?: boolean;
      /** The URL is that of a manifest of segments. Default: its path ends with .json. */
      segments?: boolean;
    }
  | {
      /** ws: or wss:, a live stream as fvvserve sends it. */
      url: string | URL;
      protocols?: string | string[];
      /** Waits double from firstMs (250) to longestMs (8000). Default: no attempt. */
      reconnect?: { attempts?: number; firstMs?: number; longestMs?: number };
      /** Where there is none, as in Node before 22; then the thread of the caller decodes. */
      WebSocket?: new (url: string, protocols?: string | string[]) => unknown;
    }
  | Blob
  | ArrayBuffer
  | ArrayBufferView
  | ReadableStream<Uint8Array>
  | AsyncIterable<Uint8Array | ArrayBuffer>;

/** Every value can be left out. memory is that of one wasm instance in bytes; there are one or, with Draco, two. */
export interface Limits {
  /** Bytes. Default 512 MiB. */
  memory?: number;
  /** Bytes of URLs and segments that are kept for loops and seeks; they and the instances stay below memory together.
   * Default 64 MiB; 0: none. */
  cacheBytes?: number;
  maxPayload?: number;
  maxVertices?: number;
  maxFaces?: number;
  maxCameras?: number;
  maxTracks?: number;
  maxDimension?: number;
}

export interface Options {
  /** Without it, write the stream to decoder.writable. */
  source?: Source;
  limits?: Limits;
  signal?: AbortSignal;
  /** A worker of this package by default where there are workers; false: none; or where its script lies. */
  worker?: boolean | Worker | URL | string | (() => Worker);
  /** Normals of the vertices, sent or computed. Default true. */
  normals?: boolean;
  visibility?: boolean;
  /** Shares of vertices too (clause 17.4), which shaders take. Default false. */
  shares?: boolean;
  /** "pictures", or "samples": encoded only. Default pictures where there is WebCodecs or videoFallback. */
  video?: "pictures" | "samples";
  /** Decoders for video that WebCodecs can't decode here, or for where there is none: () => import("@fvv/video-fallback").
   * Called in this thread, and only when a track needs it. Default: a warning, and frames without pictures. */
  videoFallback?: () => Promise<VideoFallback | WebAssembly.Module>;
  /** Frames that are decoded ahead. Default 4. */
  queue?: number;
  /** Tracks of video, as select takes them, from the first frame on. Default all. */
  tracks?: number[] | null;
  /** The same for a viewpoint, as look takes it. */
  look?: Viewpoint;
}

/** Where a viewer stands and looks, in world coordinates, and how a picture from there is textured
 * (docs/fvvrender.md). */
export interface Viewpoint {
  eye: ArrayLike<number>;
  target: ArrayLike<number>;
  /** Cameras for a point of the surface. Default 3. */
  best?: number;
  /** Cosine between normal and ray to the camera below which it gives no colour. Default 0.25. */
  threshold?: number;
  /** Part of the picture that comes from where it would with all cameras. Default 0.9; 1: no camera is left out that
   * gives anything. */
  share?: number;
}

/** Of a ball at the target, seen from eye: cameras that give the part share of it, those first that give most. None
 * when no camera shows the target. */
export function camerasFor(cameras: Camera[], viewpoint: Viewpoint): { camera: number; share: number }[];

/** What @fvv/video-fallback is. */
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
  | "changed"
  | "reconnect"
  | "skipped"
  | "no-range"
  | "no-index"
  | "video"
  | "worker";

export class FvvError extends Error {
  readonly code: Code;
  /** n of FVV-n in spec/issues.md; 0: no rule of the format is concerned. */
  readonly issue: number;
  /** Type of the chunk, "" for none. */
  readonly chunk: string;
  /** In the stream, bytes. */
  readonly offset: number | null;
  readonly severity: "error" | "warning";
  /** Nothing follows. */
  readonly fatal: boolean;
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

/** Where a camera's picture, or a part of it, stands in the video. */
export interface Tile {
  camera: number;
  source: Rect;
  destination: Rect;
}

export interface Video {
  track: number;
  /** "avc1", "hvc1", "vp09", "av01", "jpeg", "oexr" */
  codec: string;
  /** As WebCodecs takes it; "" for pictures of their own. */
  codecString: string;
  /** Configuration record of MP4. */
  record: Uint8Array;
  width: number;
  height: number;
  bitDepth: number;
  shows: "tiles" | "camera" | "atlas";
  camera: number | null;
  /** ITU-T H.273. */
  colour: { primaries: number; transfer: number; matrix: number; fullRange: boolean };
  /** Of groups that have no layout of their own: ask frame.tiles. All cameras that the track ever shows. */
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
  /** Row-major, 9. */
  readonly rotation: readonly number[];
  readonly translation: readonly number[];
  readonly moves: boolean;
  /** false: it moves, and where it is in this frame is not known: take no colours from it. */
  readonly calibrated: boolean;
  readonly centre: [number, number, number];
  /** World metres -> u, v, depth; null: behind the camera or beyond its lens. */
  project(x: number, y: number, z: number): [number, number, number] | null;
  /** The same for x y z of many points; NaN for null. */
  projectPoints(points: ArrayLike<number>): Float64Array;
  /** Pixel -> ray in the camera's frame with z = 1. */
  unproject(u: number, v: number): [number, number, number] | null;
}

export interface Texturing {
  /** Least cosine between the normal and the way to a camera whose colour is taken. */
  threshold: number;
  /** Cameras mixed at a place, at most. */
  best: number;
  /** 0xRRGGBB, display values, where no camera shows the surface. */
  unseen: number;
  /** Tolerance of depth maps: breadths of a pixel, and times what the surface recedes in a pixel. */
  depthBias: number;
  depthSlope: number;
}

export interface Configuration {
  /** Seconds a tick. */
  timeBase: { numerator: number; denominator: number };
  frameDuration: bigint;
  /** metres = origin + step * index */
  lattice: { origin: [number, number, number]; step: number };
  upAxis: "unknown" | "x" | "y" | "z" | "-x" | "-y" | "-z";
  /** false: lengths are not in metres. */
  scaleKnown: boolean;
  tracks: { id: number; kind: string; name: string }[];
  cameras: Camera[];
  videos: Video[];
  /** JSON texts. */
  metadata: string[];
  /** How the stream is meant to be coloured (TEXR), else the defaults: 0.25, 3, 0x808080, 0.2, 0.5. */
  texturing: Texturing;
}

export interface Mesh {
  track: number;
  profile: "raw" | "draco" | "delta" | "field" | "fast";
  key: boolean;
  vertexCount: number;
  faceCount: number;
  /** x y z on the lattice. */
  lattice: Int32Array;
  /** x y z in metres. */
  positions: Float32Array;
  /** Three a face, counter-clockwise from outside. */
  indices: Uint32Array;
  normals: Float32Array | null;
  /** u v, (0, 0) is the top left corner of the atlas. */
  uvs: Float32Array | null;
}

export interface Visibility {
  track: number;
  meshTrack: number;
  domain: "faces" | "vertices" | "shares";
  /** Cosine below which nothing is seen. */
  threshold: number;
  cameras: number[];
  elementCount: number;
  /**
   * A row of elementCount for each camera: 0 averse, 1 hidden, 2 seen. Elements of shares are vertices; near an outline
   * they are 3 or 5, hidden, and 4 or 6, seen: what is odd is hidden.
   */
  states: Uint8Array;
  of(camera: number): Uint8Array | null;
  /** A row of vertexCount for each camera, 0 to 255: seen from 127.5 on. null without the option. */
  shares: Uint8Array | null;
  vertexCount: number;
  sharesOf(camera: number): Uint8Array | null;
}

export interface Sample {
  track: number;
  key: boolean;
  data: Uint8Array;
}

/** What videoFallback decodes where there is no VideoFrame, or none of 10 bits. As a VideoFrame, with planes in memory. */
export interface PlanarPicture {
  /** I420P10: two bytes a sample, the lower one first. null when it is closed. */
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
  /** Names of WebCodecs; null for code points that it has no name for. */
  readonly colorSpace: {
    primaries: string | null;
    transfer: string | null;
    matrix: string | null;
    fullRange: boolean;
  };
  /** Y, U and V one behind the other. Belongs to the picture. */
  readonly data: Uint8Array | null;
  allocationSize(options?: CopyOptions): number;
  copyTo(destination: BufferSource, options?: CopyOptions): Promise<{ offset: number; stride: number }[]>;
  clone(): PlanarPicture;
  close(): void;
}

export interface CopyOptions {
  /** x and y are even. Default all of it. */
  rect?: Rect;
  /** Of Y, U and V, in bytes. Default without gaps. */
  layout?: { offset: number; stride: number }[];
  /** No other than its own. */
  format?: "I420" | "I420P10";
}

export type Picture = VideoFrame | ImageBitmap | PlanarPicture;

export interface Frame {
  /** Exact where there is an index; else counted from the first frame that came. */
  readonly number: number;
  /** Ticks. */
  readonly time: bigint;
  readonly seconds: number;
  readonly duration: number;
  readonly group: { sequence: number; start: bigint; end: bigint };
  readonly configuration: Configuration;
  readonly meshes: Mesh[];
  readonly mesh: Mesh | null;
  readonly visibility: Visibility[];
  /** As they are in this frame. */
  readonly cameras: Camera[];
  /** Of the tracks that were selected. */
  readonly samples: Sample[];
  /** Tracks of video that were selected for its group; null: all. Of others there are neither samples nor tiles. */
  readonly tracks: number[] | null;
  readonly pictures: { track: number; image: Picture }[];
  /** What meshes, visibility and calibration took. */
  readonly decodeMs: number;
  camera(id: number): Camera | null;
  picture(track?: number): Picture | null;
  /** Where each camera's picture is in that one: the layout of the frame's group, which may be another in the next. */
  tiles(track?: number): Tile[];
  /** Closes the pictures; everything else stays. */
  close(): void;
}

/** A mesh of the environment, in one colour or with one picture. */
export interface BackgroundPart {
  vertexCount: number;
  faceCount: number;
  /** Metres. */
  positions: Float32Array;
  indices: Uint32Array;
  /** u v in the picture, (0, 0) is its top left corner; beyond 0 to 1 it begins again, or is clamped. */
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
  /** In which the light travels. */
  direction: [number, number, number];
  colour: [number, number, number];
  /** Lux for directional lights, else candela. */
  intensity: number;
  /** Metres; 0: no end. */
  range: number;
  /** Radians. */
  innerCone: number;
  outerCone: number;
  castsShadows: boolean;
}

export interface Background {
  track: number;
  parts: BackgroundPart[];
  /** Whole files, sRGB. */
  pictures: { type: "image/jpeg" | "image/png"; width: number; height: number; data: Uint8Array }[];
  lights: Light[];
}

export interface Gap {
  /** Time of the last good frame and beginning of the next group; null: there is none. */
  from: bigint | null;
  to: bigint | null;
  error: FvvError;
}

export interface Stats {
  frames: number;
  /** Decoded on the way to where was sought. */
  passed: number;
  decodeMs: number;
  pictures: number;
  queued: number;
  memoryBytes: number;
  /** From the network. */
  bytesRead: number | null;
  requests: number | null;
  /** Memory that the cache takes; not a part of memoryBytes. */
  cachedBytes: number;
  /** Reads that began with bytes of the cache, where a request was spared, and how many bytes came out of it. */
  cacheHits: number;
  bytesReused: number;
}

export interface DecoderEvents {
  configuration: Configuration;
  /** All that hold from here on; none when the configuration changes. */
  background: Background[];
  gap: Gap;
  corrupt: FvvError;
  warning: FvvError;
  error: FvvError;
  end: null;
  /** A live stream begins anew: times go back. */
  restart: null;
  /** groups, frameCount or seekable are others from here on: one answer has come as a whole, or is not kept any more, or the
   * file has changed. */
  groups: readonly Group[] | null;
  stats: Stats;
}

/** What the index says of a group. */
export interface Group {
  /** Bytes from the beginning of the stream; of segments, as if their files stood behind the configuration. */
  offset: number;
  size: number;
  /** Ticks: times t with start <= t < end. */
  start: bigint;
  end: bigint;
  sequence: number;
  frameCount: number;
  /** false: part of it is damaged or missing. */
  intact: boolean;
  /** Bytes of its last chunk, GEND; 0 without one. */
  endSize: number;
}

export interface Decoder extends EventTarget, AsyncIterable<Frame> {
  /** null until the first frame. */
  readonly configuration: Configuration | null;
  /** Environments that have come along: frames don't wait for them. */
  readonly backgrounds: Background[];
  /** Of a host without Range as long as all that has gone by is kept. */
  readonly seekable: boolean;
  /** null: not known, or not yet. */
  readonly frameCount: number | null;
  /** In the order of time; null: not known, or not yet. */
  readonly groups: readonly Group[] | null;
  readonly inWorker: boolean;
  /** Takes the stream when there is no source. */
  readonly writable: WritableStream<Uint8Array> | null;
  frames(): AsyncIterableIterator<Frame>;
  /** null at the end; rejects with a fatal FvvError. */
  next(): Promise<Frame | null>;
  seek(place: { frame: number } | { time: bigint } | { seconds: number }): Promise<void>;
  /** Tracks of video that frames come with; null: all. Holds from the next group on at the latest; frames say which
   * theirs are. What is left out is not decoded, and of hosts that keep to Range not fetched. */
  select(wanted: { tracks: number[] | null }): Promise<void>;
  /** Selects the tracks that a picture needs (camerasFor), and again when the configuration changes. Nothing is known
   * before the configuration is: then both lists are empty, and it is selected with that. */
  look(viewpoint: Viewpoint): Promise<{ cameras: { camera: number; share: number }[]; tracks: number[] }>;
  stats(): Promise<Stats>;
  /** Times (ticks) that play without the network, in order and apart from each other: what is kept of URLs and segments, all
   * of Blobs and bytes with an index. */
  held(): Promise<{ start: bigint; end: bigint }[]>;
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
