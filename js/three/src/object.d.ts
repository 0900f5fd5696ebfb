import { CoordinateSystem, Mesh, Object3D, Object3DEventMap, PerspectiveCamera, Ray } from "three";
import { Pick } from "@fvv/analysis";
import { Camera, Frame } from "@fvv/decoder";

export { Pick, pick, rayThrough } from "@fvv/analysis";

export interface Texturing {
  /** What weights cameras: the viewer's direction, or the normal alone as in WHP 235. Default: the stream's value. */
  blend?: "viewer" | "paper";
  /** Minimum cosine between the surface normal and the ray to a camera that gives colour. Default: the stream's value. */
  threshold?: number;
  /** Maximum number of cameras that are mixed at a point, 1 to 8. Default: the stream's value. */
  best?: number;
  /** sRGB colour of surface that no camera shows. Default: the stream's value. */
  unseen?: number;
}

/**
 * A frame of free-viewpoint video. Its local coordinates are those of the stream, right-handed and in metres; it can be
 * moved, rotated and scaled like any object. Nothing is visible before the first frame. three's Raycaster meets its mesh: the
 * nearest point on the ray.
 */
export abstract class FrameObject<Events extends Object3DEventMap = Object3DEventMap> extends Object3D<Events> {
  /**
   * Shows the first mesh of a frame with its pictures, cameras, tiles and visibility. Decode with normals and
   * visibility, as by default. The frame has to stay open until the promise is resolved. Clones of pictures that are not planes in
   * memory stay open until the next frame, to be drawn again after a loss of the context. Of several concurrent calls the
   * last one shows its frame, and the others return false.
   */
  show(frame: Frame): Promise<boolean>;
  /**
   * What a ray in the coordinates of the scene's world, such as that of a Raycaster, meets first of the frame that is shown; null:
   * nothing. Positions, normals and the distance of the result are in the coordinates of the stream: localToWorld leads back.
   */
  pick(ray: Ray): Pick | null;
  /** The frame that is shown; null: none yet. */
  readonly frame: { number: number; seconds: number } | null;
  /** Number of cameras that give colours in this frame, 64 at most. */
  readonly viewCount: number;
  /**
   * The drawn mesh. Its geometry has position, normal, uv and index, written in place; drawRange is the part in use. Its
   * positions count from the mesh's own, which is the origin of the stream's localPositions: (0, 0, 0) near 0.
   */
  readonly mesh: Mesh;
  /**
   * Another object that shows what this one shows, for another place: nothing is decoded or uploaded for it again. It has the
   * coordinates of the stream, and one child, a mesh. dispose() takes it away.
   */
  instance(): Object3D & { dispose(): void };
  /** Shows nothing until the next frame. */
  vacate(): void;
  dispose(): void;
}

/**
 * Sets viewer to the view of a camera of the stream, without the distortion of its lens. viewer is in the coordinates of the
 * stream, i.e. a child of the FvvObject3D or of an object with the same transform. near and far are kept; the projection is
 * valid until viewer.updateProjectionMatrix() is called. A renderer with a reversed depth buffer, or with WebGPU, has to be given.
 */
export function lookThrough(
  viewer: PerspectiveCamera,
  camera: Camera,
  renderer?: { readonly coordinateSystem: CoordinateSystem },
): void;
