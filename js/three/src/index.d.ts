import { Mesh, Object3D, PerspectiveCamera, WebGLRenderer } from "three";
import { Camera, Frame } from "@fvv/decoder";

export interface Options {
  /** That draws the scene, with WebGL 2: pictures are uploaded and depth maps drawn when a frame is shown. */
  renderer: WebGLRenderer;
  /** Least cosine between the surface's normal and the ray to a camera that gives colour. Default: the stream's. */
  threshold?: number;
  /** Most cameras that are mixed at a place, 1 to 8. Default: the stream's. */
  best?: number;
  /** sRGB colour of surface that no camera shows. Default: the stream's. */
  unseen?: number;
}

/**
 * A frame of free-viewpoint video. Its own coordinates are those of the stream, right-handed and in metres; place, turn
 * and scale it like any object. Nothing is visible before the first frame.
 */
export class FvvObject3D extends Object3D {
  constructor(options: Options);
  /**
   * Takes the first mesh of a frame, the pictures, cameras, tiles and visibility that belong to it. frame has to stay open until the
   * promise is resolved and may be closed then; nothing of it is kept. Decode with normals and shares. When several are under
   * way the last one is shown, and the others answer false.
   */
  show(frame: Frame): Promise<boolean>;
  /** Which frame is shown; null: none yet. */
  readonly frame: { number: number; seconds: number } | null;
  /** How many cameras the frame has colours of, 64 at most. */
  readonly viewCount: number;
  /** What is drawn. Its geometry has position, normal, uv and index, written in place: drawRange tells how much is in use. */
  readonly mesh: Mesh;
  dispose(): void;
}

/**
 * Puts viewer where a camera of the stream stands, with its intrinsics but without the distortion of its lens. viewer
 * is in the coordinates of the stream: a child of the FvvObject3D, or of what stands as it does. near and far are kept;
 * the projection holds until viewer.updateProjectionMatrix() is called.
 */
export function lookThrough(viewer: PerspectiveCamera, camera: Camera): void;
