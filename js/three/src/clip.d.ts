import { Group, Object3DEventMap, AudioListener, PositionalAudio } from "three";
import { FvvError, Options as DecoderOptions, Rung, RungChange, RungChoice, Source } from "@fvv/decoder";

import { FrameObject, Texturing } from "./object.js";

/** All values are optional. */
export interface ClipSettings extends Texturing {
  /** Where the stream comes from, as createDecoder takes it; a ws: or wss: URL is live. */
  src?: Source | null;
  /** Default false. */
  loop?: boolean;
  /** Whether it plays as soon as it can. Default false. */
  autoplay?: boolean;
  /** 0 to 1; default 1. */
  volume?: number;
  muted?: boolean;
  /** Which rung of a ladder is played; default "auto". */
  rung?: RungChoice;
  /** Who hears the sound; default: one that follows the camera that draws the clip. */
  listener?: AudioListener | null;
  /** Whether the static environment of the stream is shown. Default true. */
  environment?: boolean;
  /** Further options for createDecoder. */
  decoderOptions?: Partial<DecoderOptions>;
}

/** Those of media elements, and some more. */
export interface FvvClipEventMap extends Object3DEventMap {
  abort: object;
  canplay: object;
  canplaythrough: object;
  durationchange: object;
  emptied: object;
  ended: object;
  loadeddata: object;
  loadedmetadata: object;
  loadstart: object;
  pause: object;
  play: object;
  playing: object;
  progress: object;
  ratechange: object;
  seeked: object;
  seeking: object;
  stalled: object;
  suspend: object;
  timeupdate: object;
  waiting: object;
  volumechange: object;
  /** There is sound, or there is none any more. */
  soundchange: object;
  /** Another frame is shown. */
  framechange: object;
  /** The surface is drawn again after a loss of the context. */
  restored: object;
  /** Playback has ended. */
  error: { error: FvvError | Error };
  /** Playback goes on. */
  warning: { error: FvvError };
  rungchange: { rung: RungChange };
}

/** A stream that plays by itself in a scene, with the properties and events of media elements. */
export abstract class ClipObject extends FrameObject<FvvClipEventMap> {
  src: Source | null;
  /** Resolves when the first frame of src is shown; rejected when it cannot be. */
  readonly ready: Promise<this>;
  /** Sound is heard after a gesture of the user: browsers allow none before. */
  play(): Promise<void>;
  pause(): void;
  /** Resolves when the frame of that time is shown; rejected when an error, another source or dispose() comes first. */
  seek(seconds: number): Promise<unknown>;
  /** Pauses, and shows the frame count frames further on. Returns false if that is impossible. */
  step(count?: number): boolean;
  /** Seconds; setting it seeks. */
  currentTime: number;
  /** Number of the frame that is shown; setting it seeks. */
  currentFrame: number;
  readonly frameCount: number;
  readonly duration: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  /** As that of media elements, 0 to 4. */
  readonly readyState: number;
  readonly error: { readonly code: 2 | 3 | 4; readonly message: string; readonly cause: Error } | null;
  loop: boolean;
  autoplay: boolean;
  playbackRate: number;
  /** 0 to 1. */
  volume: number;
  muted: boolean;
  readonly hasSound: boolean;
  /** A PositionalAudio for each track that is heard, at its place, or in the middle of the surface. */
  readonly audio: readonly PositionalAudio[];
  /** Of the stream's ladder, best first. */
  readonly rungs: readonly Rung[];
  /** null: there is no ladder. */
  readonly playedRung: number | null;
  rung: RungChoice;
  /** The static environment: its pictures include the light, and shadows of the scene's lamps fall on it. */
  readonly environment: Group;
}
