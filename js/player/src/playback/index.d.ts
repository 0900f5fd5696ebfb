import { Decoder, Frame, SoundTrack } from "@fvv/decoder";

/** How playback proceeds at now(). */
export interface Motion {
  running: boolean;
  /** Seconds. */
  position: number;
  rate: number;
}

/** Like MediaError: 2 network, 3 decoding, 4 the source cannot be played. */
export interface MediaFailure {
  readonly code: 2 | 3 | 4;
  readonly message: string;
  readonly cause: Error;
}

/** Types of the events of Media, beside "frame". */
export const MEDIA_EVENTS: readonly string[];

/** HTMLMediaElement without a document: attributes, states, promises and events, and "frame" when a frame has been shown. */
export class Media extends EventTarget {
  /**
   * open(source): resolves to a decoder. show(frame): resolves when the frame may be closed. vacate(): nothing is to be shown. wake():
   * a call of tick is requested. now(): milliseconds; default: those of performance.
   */
  constructor(parts: {
    open(source: unknown, isKnown: boolean): Promise<Decoder>;
    show(frame: Frame): Promise<unknown>;
    vacate?(): void;
    wake?(): void;
    now?(): number;
    screen?(): { delay: number; refresh: number };
  });
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  readonly duration: number;
  readonly readyState: number;
  readonly error: MediaFailure | null;
  readonly frame: { number: number; seconds: number; duration: number } | null;
  readonly motion: Motion;
  readonly decoder: Decoder | null;
  currentTime: number;
  currentFrame: number;
  playbackRate: number;
  loop: boolean;
  autoplay: boolean;
  suspended: boolean;
  load(source: unknown, options?: { live?: boolean }): void;
  reset(): void;
  play(): Promise<void>;
  pause(): void;
  step(count: number): boolean;
  /** A frame that stays on screen is shown in another rung at once. */
  improve(): void;
  /** For each picture of the screen. Returns whether another one is needed. */
  tick(): boolean;
}

/** Where the sound of a track goes to. place: moves it at a time of the context, to a place of the stream. */
export interface Way {
  input: AudioNode;
  place(position: readonly number[], at: number): void;
}

/** Sound by Web Audio, whose clock is that of playback. */
export class Sound {
  constructor(parts: {
    motion(): Motion;
    listener?(): { eye: readonly number[]; target: readonly number[]; up: readonly number[] } | null;
    scale?(): number;
    changed(): void;
    /** What sound is given to in place of a context of its own; called when there is sound to be heard. */
    device?(): { readonly context: AudioContext; volume: number; wayOf(about: SoundTrack): Way };
  });
  readonly present: boolean;
  readonly context: AudioContext | null;
  volume: number;
  muted: boolean;
  now(): number;
  follow(decoder: Decoder): void;
  update(): void;
  reset(): void;
  close(): void;
}
