import type { ThreeElements } from "@react-three/fiber";
import type { ReactElement, ReactNode, Ref } from "react";
import type { WebGLRenderer } from "three";
import type { WebGPURenderer } from "three/webgpu";
import type { Source } from "@fvv/decoder";

import type { ClipObject, ClipSettings, FvvClipEventMap } from "../clip.js";

/** Other names: FvvClip of the renderer that is in use. */
export type Clip = ClipObject;

type Listener<Name extends keyof FvvClipEventMap> = (event: FvvClipEventMap[Name] & { readonly target: Clip }) => void;

interface Own extends Omit<ClipSettings, "src" | "autoplay"> {
  src: Source;
  /** Components with the same src and id show the same clip, which is decoded once: the first one plays its sound. Default "". */
  id?: string;
  autoPlay?: boolean;
  /** Whether it is paused; undefined: it is not set. */
  paused?: boolean;
  playbackRate?: number;
  /** Default true. */
  castShadow?: boolean;
  /** Default true. */
  receiveShadow?: boolean;
  ref?: Ref<Clip>;
  children?: ReactNode;
}

interface Listeners {
  /** A frame is on screen. */
  onFrame?: (event: { number: number; seconds: number; readonly target: Clip }) => void;
  onEnded?: Listener<"ended">;
  onError?: Listener<"error">;
  onPause?: Listener<"pause">;
  onPlay?: Listener<"play">;
  onPlaying?: Listener<"playing">;
  onRungChange?: Listener<"rungchange">;
  onSeeked?: Listener<"seeked">;
  onTimeUpdate?: Listener<"timeupdate">;
  onWaiting?: Listener<"waiting">;
  onWarning?: Listener<"warning">;
}

type Placed = Omit<ThreeElements["group"], keyof Own | keyof Listeners | "args">;

export type FvvProps = Placed & Own & Listeners;

/** A clip. It suspends until its first frame is there, and throws for the next error boundary if there is none. */
export function Fvv(properties: FvvProps): ReactElement | null;

/** Begins to load a clip before a component needs it. */
export function preload(
  renderer: WebGLRenderer | WebGPURenderer,
  src: Source,
  options?: Omit<ClipSettings, "src"> & { id?: string },
): Promise<Clip>;
