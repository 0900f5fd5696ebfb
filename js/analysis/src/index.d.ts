import { Configuration, Frame } from "@fvv/decoder";

type Vector = [number, number, number];

/** In the coordinates of the stream. */
export interface Ray {
  origin: readonly number[];
  /** Of any length. */
  direction: readonly number[];
}

/** A point of the surface. Lengths are in metres, or units of a stream whose scale is unknown. */
export interface Pick {
  /** Ticks. */
  time: bigint;
  /** Number of the frame. */
  frame: number;
  /** The mesh track. */
  track: number;
  /** In the coordinates of the stream, in doubles: also where they are those of a map. */
  position: Vector;
  /** Of the face, by its winding: outwards, also where the ray comes from inside. */
  normal: Vector;
  /** Index of the face in the mesh of the track. */
  face: number;
  /** Weights of its corners; together 1. */
  barycentric: Vector;
  /** From the origin of the ray. */
  distance: number;
  /** Identifier of the object; null: the stream names none, or the piece of the mesh is none or several of them. */
  object: number | null;
  /** Identifiers of the objects that the piece is, where they are several that touch. */
  touching: number[];
  /** Identifier of the camera that gives most of the colour there, for a viewer at the origin of the ray (clause 17.5); null:
   * none shows it. Whether something hides the point is found on the meshes. */
  camera: number | null;
}

/** What a ray meets first of the meshes of a frame; null: nothing. The first pick of a mesh builds its hierarchy. */
export function pick(frame: Frame, ray: Ray): Pick | null;

/** The ray through a place of a picture, in pixels with centres at +0.5. view: as viewFromPose of @fvv/player makes it, or a camera, whose lens is ignored. */
export function rayThrough(
  view: {
    rotation: readonly number[];
    translation: readonly number[];
    fx: number;
    fy: number;
    cx: number;
    cy: number;
  },
  x: number,
  y: number,
): { origin: Vector; direction: Vector };

/** The triangles of a mesh, for rays. */
export class SurfaceTree {
  /** points: x y z of each vertex; faces: three vertices each. Both are borrowed. */
  constructor(points: Float32Array, faces: Uint32Array);
  /**
   * The nearest triangle on a ray, from either side. Coordinates count as points do, and distances in lengths of direction.
   * Triangles nearer than least, further than most, and the face except are passed through.
   */
  cast(
    origin: readonly number[],
    direction: readonly number[],
    options?: { least?: number; most?: number; except?: number },
  ): { face: number; barycentric: Vector; distance: number } | null;
}

/** A piece of a mesh. */
export interface Piece {
  /** Identifiers of the objects that it is: one, several that touch, or none. */
  objects: number[];
  /** Of its surface, by area, in the coordinates of the stream. */
  centre: Vector;
  /** Square metres. */
  area: number;
  /** From the centre to the furthest corner. */
  radius: number;
  /** How many faces it has. */
  faces: number;
  track: number;
  /** Number of the piece in the mesh of the track. */
  piece: number;
}

/** The pieces of the meshes of a frame, in the order of their first faces. */
export function piecesOfFrame(frame: Frame): Piece[];

/** The objects that a stream names; null: none, or not as spec/registry.md describes them. */
export function objectsOf(configuration: { readonly metadata: Configuration["metadata"] }): ObjectPaths | null;

/** The key `objects` of META: what was followed over time (docs/encoding/objects.md). */
export class ObjectPaths {
  private constructor();
  /** Without parts of objects; name is "" where it has none. */
  readonly list: { id: number; name: string; radius: number }[];
  /** Objects that are one piece for a time, in ticks, both included; sure: whether it is known which was which afterwards. */
  readonly touching: { objects: number[]; from: bigint; to: bigint; sure: boolean }[];
  /** The piece of object came off that of the object from. */
  readonly splits: { from: number; object: number; time: bigint }[];
  /** The identifier; null: no object has the name. */
  find(name: string): number | null;
  /** The centre at a time, in ticks, as the stream gives its path; null: it is not in the scene. */
  centreOf(id: number, time: bigint | number): Vector | null;
  /** The objects that are one piece with an object at a time, with itself. */
  together(id: number, time: bigint | number): number[];
  /** The objects that a piece with a centre is. */
  at(centre: readonly number[], time: bigint | number): number[];
}
