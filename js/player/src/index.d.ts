import { Measurement, Pick as Picked, Ray } from "@fvv/analysis";
import { Camera, FvvError, Options, Outage, Rung, RungChange, Source } from "@fvv/decoder";
import { Counters, Mode } from "./renderer/index.js";

export { Renderer, cameraColour } from "./renderer/index.js";
export { View, viewFromCamera, viewFromPose } from "./view.js";

type Vector = [number, number, number];

/** Metres of the stream; fov: vertical, degrees. */
export interface Pose {
  eye: Vector;
  target: Vector;
  up: Vector;
  fov: number;
}

/** Like TimeRanges. */
export interface Ranges {
  readonly length: number;
  start(index: number): number;
  end(index: number): number;
}

export interface LiveCatchUp {
  /** Seconds behind the live edge that are intended; default 0.25. */
  delay: number;
  /** The rate of playback at most, until it has caught up; default 1.25. */
  maxRate: number;
  /** Seconds behind the live edge after which playback jumps to it; default 5. */
  jumpAfter: number;
}

/** Like MediaError: 2 network, 3 decoding, 4 the source cannot be played. */
export interface PlayerError {
  readonly code: 2 | 3 | 4;
  readonly message: string;
  readonly cause: FvvError | Error;
}

export interface Stats extends Partial<Counters> {
  framesShown: number;
  framesDropped: number;
  /** Over the last two seconds. */
  framesPerSecond: number;
  /** Open frames of the player and in the decoder's queue at the last update; without the clone that the renderer keeps. */
  openVideoFrames: number;
  /** Smoothed milliseconds per frame: decoding of meshes, visibility and calibration; and showing. */
  decodeMs: number;
  showMs: number;
  bufferedSeconds: number;
  /** Received bits per second over the last two seconds. */
  bitrate: number;
  /** Of the decoder's wasm instances. */
  memoryBytes: number;
  frame: number;
  frameCount: number;
  /** Of the canvas, in pixels. */
  width: number;
  height: number;
}

export interface Journey {
  /** Seconds. Default 0: at once. */
  duration?: number;
}

export type DecoderOptions = Pick<Options, "limits" | "signal" | "videoFallback" | "soundFallback">;

/** What replaces an address that has expired; null: nothing does. */
export type RenewedAddress = Awaited<ReturnType<NonNullable<Options["renewAddress"]>>>;

/** A measurement made with the tools. Lengths in metres, speeds in metres per second, or in units of a stream whose scale is unknown. */
export interface Measured {
  readonly kind: "distance" | "height" | "speed";
  /** Of objects, or "place". */
  readonly names: readonly string[];
  /** In the frame on screen; null: not known. */
  readonly value: Measurement | null;
  /** Over time, as far as known. */
  readonly samples: readonly { seconds: number; value: Measurement | null }[];
}

/** spec/marks.schema.json describes it. */
export interface MarksDocument {
  fvv_marks: 1;
  marks: readonly Mark[];
}
export interface Mark {
  kind: "arrow" | "line" | "ellipse" | "freehand" | "text" | "trail";
  /** Metres of the stream, or from the centre of the object. Of an ellipse its middle and the ends of two half axes. */
  points?: readonly (readonly [number, number, number])[];
  /** Ticks, both included. */
  from?: number;
  to?: number;
  object?: string | number;
  /** #rrggbb */
  colour?: string;
  /** Pixels. */
  width?: number;
  text?: string;
  /** How long a trail is. */
  seconds?: number;
}

/** Events in addition to those of media elements. */
export interface FvvPlayerEventMap extends Omit<HTMLElementEventMap, "error"> {
  /** Playback has ended. The element's `error` has the reason as well. */
  error: CustomEvent<FvvError | Error>;
  /** A new frame is on screen. */
  framechange: Event;
  /** The view has changed: by the user, or by the page's script. */
  "camera-change": CustomEvent<{ source: "user" | "script" }>;
  /** There are other marks. */
  markschange: Event;
  /** A property that controls show has changed. */
  optionschange: Event;
  /** Another rung of the ladder is played. */
  rungchange: CustomEvent<RungChange>;
  /** Playback continues: damage, gaps and restrictions, as the decoder reports them. */
  warning: CustomEvent<FvvError>;
  /** Requests fail and are tried again, while what is buffered is played; detail null: nothing has come for a while. */
  stalled: CustomEvent<Outage | null>;
  /** Bytes come again. */
  recovered: CustomEvent<null>;
  /** The address, or its credentials, have expired: respondWith takes what replaces it. */
  addressexpired: CustomEvent<{
    url: string;
    status: number;
    respondWith(address: RenewedAddress | Promise<RenewedAddress>): void;
  }>;
}

export class FvvPlayer extends HTMLElement {
  static readonly NETWORK_EMPTY: 0;
  static readonly NETWORK_IDLE: 1;
  static readonly NETWORK_LOADING: 2;
  static readonly NETWORK_NO_SOURCE: 3;
  static readonly HAVE_NOTHING: 0;
  static readonly HAVE_METADATA: 1;
  static readonly HAVE_CURRENT_DATA: 2;
  static readonly HAVE_FUTURE_DATA: 3;
  static readonly HAVE_ENOUGH_DATA: 4;

  src: string;
  /** Takes precedence over src. */
  srcObject: Source | null;
  readonly currentSrc: string;
  poster: string;
  autoplay: boolean;
  loop: boolean;
  controls: boolean;
  muted: boolean;
  /** 0 to 1. */
  volume: number;
  /** Whether the stream has sound. */
  readonly hasSound: boolean;
  /** The AudioContext that plays it; null: none yet. */
  readonly audioContext: AudioContext | null;
  defaultMuted: boolean;
  load(): void;
  /** Rejects with AbortError if pause() is called first, with NotSupportedError if the source cannot be played. */
  play(): Promise<void>;
  pause(): void;
  /** Pauses, and shows the frame count frames further on. Returns false if that is impossible. */
  step(count?: number): boolean;
  canPlayType(type: string): "" | "maybe";
  /** Seconds of the stream. */
  currentTime: number;
  fastSeek(seconds: number): void;
  /** Number of the frame on screen; setting it seeks. */
  currentFrame: number;
  /** 0: not known. */
  readonly frameCount: number;
  /** As far as known; start and end in seconds, and the number of the first frame. */
  readonly groups: readonly { start: number; end: number; firstFrame: number }[];
  /** The number of the frame at a time; null: not known. */
  frameAt(seconds: number): number | null;
  /** Seconds; NaN before metadata, Infinity live. */
  readonly duration: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  readonly readyState: 0 | 1 | 2 | 3 | 4;
  readonly networkState: 0 | 1 | 2 | 3;
  readonly error: PlayerError | null;
  /** Why requests fail and are tried again; null: they do not. What is buffered is played meanwhile. */
  readonly outage: Outage | null;
  readonly seekable: Ranges;
  readonly buffered: Ranges;
  /** 0 to 16. */
  playbackRate: number;
  defaultPlaybackRate: number;
  /** The range in seconds that is played in a loop. */
  loopRange: { from: number; to: number } | null;
  readonly live: boolean;
  goLive(): void;
  /** How a live stream is followed. What is not given has its default. */
  get liveCatchUp(): Readonly<LiveCatchUp>;
  set liveCatchUp(given: Partial<LiveCatchUp>);
  /** Seconds behind the live edge, as far as known. */
  readonly liveLatency: number;

  /** Reflect the attributes camera-orbit, camera-target and field-of-view. */
  cameraOrbit: string;
  cameraTarget: string;
  fieldOfView: string;
  /** Their values for the current view. */
  getCameraAttributes(): { cameraOrbit: string; cameraTarget: string; fieldOfView: string };
  getPose(): Pose;
  /** What is at a place of the picture on screen; null: nothing of the scene's meshes, or the contact sheet is shown. x, y: CSS pixels
   * from the top left corner of the element. The first call loads @fvv/analysis. */
  pick(x: number, y: number): Promise<Picked | null>;
  /** What a ray meets first, in the coordinates of the stream. */
  pick(ray: Ray): Promise<Picked | null>;
  /** Which tools are offered over the picture, with spaces: "measure", "mark", "follow". What they need is loaded when there is one. */
  tools: string;
  /** URL of a document of marks that is shown, with or without tools; "": none. */
  marks: string;
  /** The document of the marks that are shown. */
  getMarks(): MarksDocument;
  /** Shows a document of marks in place of the former. Rejects with TypeError if it is not one. */
  setMarks(document: MarksDocument): Promise<void>;
  /** The view keeps an object in its place: its name or its identifier; null: none. RangeError if the stream names no such object. */
  follow(object: string | number | null): Promise<void>;
  /** What was measured with the tools. */
  readonly measurements: readonly Measured[];
  /** Omitted fields are kept. Before the first frame it waits for that. Resolves to false if the user interrupts the movement,
   * and if another source is set before there is a frame. */
  setPose(pose: Partial<Pose>, journey?: Journey): Promise<boolean>;
  resetView(journey?: Journey): Promise<boolean>;
  /** As setPose. RangeError if the frame has no such calibrated camera: thrown, or before the first frame the rejection. */
  snapToCamera(id: number, journey?: Journey): Promise<boolean>;
  /** Identifier of the camera of the view. */
  readonly camera: number | null;
  /** As they are in the frame on screen. */
  readonly cameras: readonly Camera[];
  navigation: "orbit" | "fly";

  /** What the browser offers by WebXR. */
  readonly immersiveModes: readonly ("vr" | "ar")[];
  /** The current mode, or null; also an attribute. "optionschange" reports changes. */
  readonly immersive: "vr" | "ar" | null;
  /** Begins a WebXR session. Has to be called by a listener of a click or a key. */
  enterImmersive(mode: "vr" | "ar"): Promise<void>;
  exitImmersive(): Promise<void>;
  /** Where the scene is in the viewer's room: radians, metres of the room per metre of the stream, the middle of its floor. */
  readonly placement: {
    turn: number;
    scale: number;
    anchor: Vector;
    turnBy(radians: number): void;
    scaleBy(factor: number): void;
    moveBy(metres: Vector): void;
  } | null;

  /** The direction in which a finger on the picture scrolls the page. */
  touchAction: "pan-y" | "pan-x" | "none";

  viewMode: Mode;
  /** The most pixels that are drawn for a pixel of the page; "auto": 2, and fewer while drawing is too slow. */
  pixelRatio: "auto" | number;
  /** Which rung of the stream's ladder is played: 0 is the best. Set by the attribute `rung`. */
  rung: "auto" | number;
  /** Rungs of the stream, best first; one or none without a ladder. */
  readonly rungs: readonly Rung[];
  /** The rung that is played; null: there is no ladder. Changes are reported by `rungchange`. */
  readonly playedRung: number | null;
  visibleBy: "auto" | "bits" | "depth" | "both";
  /** What weights cameras: the viewer's direction, or the normal alone as in WHP 235; null: the stream's value. */
  blend: "viewer" | "paper" | null;
  /** Colour of surface that no camera shows, 0xRRGGBB as displayed; null: the stream's value. */
  unseen: number | null;
  shadows: boolean;
  environment: boolean;
  readonly hasEnvironment: boolean;
  grid: boolean;
  /** Identifiers of the cameras that may give colours; null: all. */
  colourCameras: readonly number[] | null;
  /** null: the contact sheet for streams of pictures only, and the pictures once a camera was chosen; otherwise none. */
  get showCameras(): "none" | "frusta" | "pictures" | "sheet";
  set showCameras(how: "none" | "frusta" | "pictures" | "sheet" | null);
  /** The cells of the contact sheet, in fractions of the picture, y down; empty if it is not shown. */
  readonly contactSheet: readonly { camera: number; x: number; y: number; width: number; height: number }[];
  /** Whether the stream on screen has pictures of cameras and no meshes. */
  readonly onlyPictures: boolean;
  /** Codecs of the frame on screen that this browser does not decode: "avc1", "hvc1", "vp09", "av01". */
  readonly unsupportedCodecs: readonly string[];
  selectedCamera: number | null;

  /** The current time and view, as a part of a URL's fragment. */
  readonly bookmark: string;
  readonly bookmarks: boolean;
  /** Puts the bookmark into the page's address, and copies the address to the clipboard. */
  copyBookmark(): Promise<string>;

  worker: string | null;
  /** Further options for createDecoder, applied by the next load(). */
  decoderOptions: DecoderOptions;
  /** The same of all players. */
  static decoderOptions: DecoderOptions;
  /** Which controls are left out, as in `<video>`: "nodownload", "nofullscreen", or both with a space. */
  controlsList: string;
  /** Whether the source is a file: not live, nor segments, nor bytes of the page. */
  readonly canDownload: boolean;
  /** Offers the source to the user as a download. InvalidStateError if it is not a file. */
  download(): void;
  /** Whether the browser has taken the WebGL context away, and has not given it back for five seconds. */
  readonly contextLost: boolean;
  /** Draws with another context; place, view and pause stay. */
  renewContext(): void;
  readonly isFullscreen: boolean;
  toggleFullscreen(): void;
  readonly stats: Stats;

  addEventListener<T extends keyof FvvPlayerEventMap>(
    type: T,
    listener: (this: FvvPlayer, event: FvvPlayerEventMap[T]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | AddEventListenerOptions,
  ): void;
  removeEventListener<T extends keyof FvvPlayerEventMap>(
    type: T,
    listener: (this: FvvPlayer, event: FvvPlayerEventMap[T]) => unknown,
    options?: boolean | EventListenerOptions,
  ): void;
  removeEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | EventListenerOptions,
  ): void;
}

declare global {
  interface HTMLElementTagNameMap {
    "fvv-player": FvvPlayer;
  }
}
