import { Camera, FvvError, Options, Source } from "@fvv/decoder";
import { Counters, Mode } from "./renderer/index.js";

export { Renderer, cameraColour } from "./renderer/index.js";
export { View, viewFromCamera, viewFromPose } from "./view.js";

type Vector = [number, number, number];

/** Metres of the stream; fov: vertical, radians. */
export interface Pose {
  eye: Vector;
  target: Vector;
  up: Vector;
  fov: number;
}

/** Shaped like TimeRanges. */
export interface Ranges {
  readonly length: number;
  start(index: number): number;
  end(index: number): number;
}

/** Shaped like MediaError: 2 network, 3 decoding, 4 the source can't be played. */
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
  /** In the player's hands and in the decoder's queue, when it was asked last; without the clone that the renderer keeps. */
  openVideoFrames: number;
  /** Milliseconds a frame, smoothed: meshes, visibility and calibration; and on the way to the screen. */
  decodeMs: number;
  showMs: number;
  bufferedSeconds: number;
  /** Bits a second that came over the last two. */
  bitrate: number;
  /** Of the decoder's wasm. */
  memoryBytes: number;
  frame: number;
  frameCount: number;
  /** Of the canvas, pixels. */
  width: number;
  height: number;
}

export interface Journey {
  /** Seconds. Default 0: at once. */
  duration?: number;
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
  /** Goes before src. */
  srcObject: Source | null;
  readonly currentSrc: string;
  poster: string;
  autoplay: boolean;
  loop: boolean;
  controls: boolean;
  muted: boolean;
  defaultMuted: boolean;
  load(): void;
  /** Rejects with AbortError when pause() comes first, with NotSupportedError when it can't be played. */
  play(): Promise<void>;
  pause(): void;
  /** Pauses, and shows the frame so many further on. false: that can't be had. */
  step(count?: number): boolean;
  canPlayType(type: string): "" | "maybe";
  /** Seconds of the stream. */
  currentTime: number;
  fastSeek(seconds: number): void;
  /** Number of the frame on screen; setting it seeks. */
  currentFrame: number;
  /** 0: not known. */
  readonly frameCount: number;
  /** Seconds; NaN before metadata, Infinity live. */
  readonly duration: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  readonly readyState: 0 | 1 | 2 | 3 | 4;
  readonly networkState: 0 | 1 | 2 | 3;
  readonly error: PlayerError | null;
  readonly seekable: Ranges;
  readonly buffered: Ranges;
  /** 0 to 16. */
  playbackRate: number;
  defaultPlaybackRate: number;
  /** Seconds between which it plays again and again. */
  loopRange: { from: number; to: number } | null;
  readonly live: boolean;
  goLive(): void;
  /** Seconds behind the live edge, as far as is known. */
  readonly liveLatency: number;

  /** As the attributes of these names. */
  cameraOrbit: string;
  cameraTarget: string;
  fieldOfView: string;
  /** What they would say for the view as it is. */
  getCameraAttributes(): { cameraOrbit: string; cameraTarget: string; fieldOfView: string };
  getPose(): Pose;
  /** What is left out stays. Promises whether it arrived: a hand may take over. */
  setPose(pose: Partial<Pose>, journey?: Journey): Promise<boolean>;
  resetView(journey?: Journey): Promise<boolean>;
  /** Throws RangeError where the frame on screen has no such calibrated camera. */
  snapToCamera(id: number, journey?: Journey): Promise<boolean>;
  /** Identifier of the camera that is looked through. */
  readonly camera: number | null;
  /** As they are in the frame on screen. */
  readonly cameras: readonly Camera[];
  navigation: "orbit" | "fly";

  viewMode: Mode;
  quality: "auto" | "high" | "medium" | "low";
  visibleBy: "auto" | "bits" | "depth" | "both";
  /** 0 to 1: how gently one camera takes another's place. */
  soft: number;
  /** Colour of surface that no camera shows, 0xRRGGBB as displayed; null: the stream's. */
  unseen: number | null;
  shadows: boolean;
  environment: boolean;
  readonly hasEnvironment: boolean;
  grid: boolean;
  /** Identifiers of those that may give colours; null: all. */
  colourCameras: readonly number[] | null;
  showCameras: "none" | "frusta" | "pictures";
  selectedCamera: number | null;

  /** This moment and this view, as a part of a URL's fragment. */
  readonly bookmark: string;
  readonly bookmarks: boolean;
  /** Puts it into the page's address, and that into the clipboard. */
  copyBookmark(): Promise<string>;

  worker: string | null;
  /** For createDecoder besides; they hold from the next load() on. */
  decoderOptions: Pick<Options, "limits" | "signal">;
  readonly isFullscreen: boolean;
  toggleFullscreen(): void;
  readonly stats: Stats;
  /** A picture is about to be drawn. */
  readonly isMoving: boolean;
  /** What is on the canvas, RGBA from its top row on. */
  readPixels(): { width: number; height: number; data: Uint8ClampedArray };
}

declare global {
  interface HTMLElementTagNameMap {
    "fvv-player": FvvPlayer;
  }
}
