import { Background, Camera, Frame } from "@fvv/decoder";
import { View } from "../view.js";

export { View };

export type Mode = "textured" | "weights" | "visibility" | "wireframe" | "normals" | "depth";

export interface DrawOptions {
  /** visibility: from blue to yellow by how many cameras show a place; dark red, without any green, where none does. */
  mode?: Mode;
  /** auto, bits: the stream's bits where it has some, depth maps for other cameras; depth: maps alone; both have to agree. */
  visibleBy?: "auto" | "bits" | "depth" | "both";
  /** Identifiers of those that may give colour; null: all. */
  cameras?: Iterable<number> | null;
  /** Least cosine, 0 to 1. Default: the stream's. */
  threshold?: number;
  /** Most cameras for a place, 1 to limits.best. Default: the stream's. */
  best?: number;
  /** Colour of surface that no camera shows, 0xRRGGBB as displayed. Default, and null: the stream's. */
  unseen?: number | null;
  /** 0 to 1: how gently one camera takes another's place. 0 is what fvvrender draws. Default 0. */
  soft?: number;
  /** Shadows of the mesh on the environment. */
  shadows?: boolean;
  environment?: boolean;
  /** Display values, RGBA. */
  clearColour?: [number, number, number, number];
  /** Cameras as outlines; length in metres. They are compared by the array: hand in the frame's own. */
  frusta?: { cameras: readonly Camera[]; selected?: number | null; picturePlanes?: boolean; length?: number } | null;
  /** Lines on the plane through centre; extent: from there to its border, in metres. */
  grid?: {
    centre: [number, number, number];
    up?: [number, number, number];
    extent?: number;
    step?: number;
    colour?: [number, number, number, number];
  } | null;
}

export interface Counters {
  /** Of the last picture. */
  drawCalls: number;
  /** Of the surface's shader, whatever the number of cameras. */
  samplers: number;
  bytesUploadedPerContentFrame: number;
  /** Of the last picture. */
  bytesUploadedPerDrawnFrame: number;
  /** Layers that were drawn, of all frames. */
  depthPasses: number;
  shadowPasses: number;
  contentFrames: number;
  drawnFrames: number;
}

/** Events: "lost" and "restored", when the context is. What was shown is shown again by the renderer itself. */
export class Renderer extends EventTarget {
  static readonly limits: Readonly<{ views: number; best: number; lights: number; shadows: number }>;
  /** depthTexels: of all depth maps together, four bytes each; with less room they are coarser. Default 2^26. */
  constructor(
    canvas: HTMLCanvasElement | OffscreenCanvas,
    options?: { contextAttributes?: WebGLContextAttributes; depthTexels?: number },
  );
  readonly lost: boolean;
  readonly counters: Counters;
  readonly frame: { number: number; seconds: number; viewCount: number } | null;
  /** Of the mesh that is shown, in metres. */
  readonly bounds: { least: [number, number, number]; most: [number, number, number] } | null;
  /**
   * Takes what it needs of a frame of a decoder with normals and shares, which may be closed when the promise is resolved.
   * Where browsers hand out pictures that are not planes in memory, one clone of it stays open until the next frame. Of
   * several calls the last wins, the others answer false.
   */
  show(frame: Frame): Promise<boolean>;
  setBackgrounds(backgrounds: readonly Background[]): Promise<boolean>;
  needsDraw(view: View, options?: DrawOptions): boolean;
  /** Gives the canvas the view's size. false: the picture would be the same as the last one, or the context is lost. */
  draw(view: View, options?: DrawOptions): boolean;
  readPixels(): { width: number; height: number; data: Uint8ClampedArray };
  close(): void;
}

/** Of a camera in the mode "weights": display values. */
export function cameraColour(id: number): [number, number, number];
