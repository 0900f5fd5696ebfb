import { Camera, Environment, Frame } from "@fvv/decoder";
import { View } from "../view.js";

export { View };

export type Mode = "textured" | "weights" | "visibility" | "wireframe" | "normals" | "depth";

export interface DrawOptions {
  /** visibility: from blue to yellow by the number of cameras that show a point; dark red, without green, for none. */
  mode?: Mode;
  /** auto, bits: the stream's visibility, and depth maps for cameras without it; depth: depth maps only; both: a point has to
   * be visible by both. */
  visibleBy?: "auto" | "bits" | "depth" | "both";
  /** Identifiers of the cameras that may give colour; null: all. */
  cameras?: Iterable<number> | null;
  /** What weights cameras (clause 17.5). Default, and null: the stream's value. */
  blend?: "viewer" | "paper" | null;
  /** Minimum cosine, 0 to 1. Default: the stream's value, or that of the blend if it is another than the stream's. */
  threshold?: number;
  /** Maximum number of cameras at a point, 1 to limits.best. Default: the stream's value. */
  best?: number;
  /** Colour of surface that no camera shows, 0xRRGGBB as displayed. Default, and null: the stream's value. */
  unseen?: number | null;
  /** Shadows of the mesh on the environment. */
  shadows?: boolean;
  environment?: boolean;
  /** Whether what of the environment is between the viewer and the surface fades, and floors are seen from below. Default true. */
  fade?: boolean;
  /**
   * Pixels of the surface per pixel of the picture along a side, up to 1: it is coloured in a picture of that resolution, which is
   * put into the full one; its outline and all around it have full resolution. null: it is coloured directly. Default: null, and
   * 1 where the processor draws, because that is faster there.
   */
  surfaceScale?: number | null;
  /** Display values, RGBA. */
  clearColour?: [number, number, number, number];
  /** The colour above: the background changes from clearColour at the horizon to it. null: clearColour everywhere. */
  sky?: [number, number, number, number] | null;
  /** The vertical, for the sky. Default [0, 1, 0]. */
  up?: [number, number, number];
  /** The pictures of all cameras in cells instead of the scene. x y width height are fractions of the canvas, y down. */
  sheet?: readonly { camera: number; x: number; y: number; width: number; height: number }[] | null;
  /**
   * Cameras as frusta; length in metres, by default 0.14 radii of the scene. The array of cameras is compared by identity: pass the frame's own array.
   * picturePlanes: with their pictures; only: identifier of a camera, of which the picture is drawn and nothing of others.
   */
  frusta?: {
    cameras: readonly Camera[];
    selected?: number | null;
    picturePlanes?: boolean;
    only?: number | null;
    length?: number;
  } | null;
  /** Lines on the plane through centre; extent: from centre to the border, in metres. Lengths follow the scene's by default. */
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
  /** Of the surface's shader; independent of the number of cameras. */
  samplers: number;
  bytesUploadedPerContentFrame: number;
  /** Of the last picture. */
  bytesUploadedPerDrawnFrame: number;
  /** Drawn layers of all frames. */
  depthPasses: number;
  shadowPasses: number;
  contentFrames: number;
  drawnFrames: number;
}

/**
 * Events: "lost" and "restored", of the context. The renderer restores its content itself. "lost" is not dispatched after
 * release().
 */
export class Renderer extends EventTarget {
  static readonly limits: Readonly<{ views: number; best: number; lights: number; shadows: number }>;
  /** depthTexels: limit of all depth maps together; a texel has four bytes. Smaller limits make maps coarser. Default 2^26. */
  constructor(
    canvas: HTMLCanvasElement | OffscreenCanvas,
    options?: { contextAttributes?: WebGLContextAttributes; depthTexels?: number },
  );
  readonly lost: boolean;
  readonly released: boolean;
  /** Gives the context back to the browser, which allows few, until reclaim(). The content is kept, the canvas is not. */
  release(): void;
  reclaim(): void;
  readonly counters: Counters;
  readonly frame: { number: number; seconds: number; viewCount: number } | null;
  /** The pictures that cells of a sheet can show, also of cameras without calibration. */
  readonly tiles: readonly { camera: Camera }[];
  /** Bounds of the current mesh in metres. */
  readonly bounds: { min: [number, number, number]; max: [number, number, number] } | null;
  /**
   * Shows a frame of a decoder with normals and visibility. The frame may be closed when the promise is resolved. If
   * its pictures are not planes in memory, clones of them stay open until the next frame. Of several concurrent calls the last
   * one shows its frame, and the others return false.
   */
  show(frame: Frame): Promise<boolean>;
  /** Shows no frame, only the environment, until the next call of show. */
  clear(): void;
  setEnvironments(environments: readonly Environment[]): Promise<boolean>;
  needsDraw(view: View, options?: DrawOptions): boolean;
  /** Sets the canvas to the view's size. Returns false if the picture would be the same as the last one, or the context is
   * lost. */
  draw(view: View, options?: DrawOptions): boolean;
  /**
   * Draws the views of one picture, such as those of two eyes, each into its viewport {x, y, width, height} of a framebuffer;
   * null: that of the canvas. Returns false if the context is lost.
   */
  drawViews(
    views: readonly (View & { x: number; y: number })[],
    options?: DrawOptions,
    framebuffer?: WebGLFramebuffer | null,
  ): boolean;
  close(): void;
}

/** The colour of a camera in the mode "weights", in display values. */
export function cameraColour(id: number): [number, number, number];
