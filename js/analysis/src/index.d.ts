import { Configuration, Frame, Mesh } from "@fvv/decoder";

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
  /** Cosine of the angle between the ray and the normal, either way. */
  facing: number;
  /** Identifier of the object; null: the stream names none, or the piece of the mesh is none or several of them. */
  object: number | null;
  /** Identifiers of the objects that the piece is, where they are several that touch. */
  touching: number[];
  /** Identifier of the camera that gives most of the colour there, for a viewer at the origin of the ray: the first of
   * weightsAt; null: none shows it. */
  camera: number | null;
}

/** What pointOf needs of a pick. */
export type PickedPlace = Omit<Pick, "time" | "frame" | "barycentric" | "distance" | "object" | "touching" | "camera">;

/** What a ray meets first of the meshes of a frame; null: nothing. The first pick of a mesh builds its hierarchy. */
export function pick(frame: Frame, ray: Ray): Pick | null;

/**
 * The cameras that colour a place of the surface for a viewer, the largest weight first; together 1, or none: no camera shows
 * it. By the rule of clause 17.5 with the texturing of the stream. Whether something hides the place is what the visibility
 * weights of the stream say, or, for a camera without, is found on the meshes. normal: of unit length; players interpolate those
 * of the vertices. eye: in the coordinates of the stream.
 */
export function weightsAt(
  frame: Frame,
  place: { track: number; face: number; barycentric: readonly number[]; normal: readonly number[] },
  eye: readonly number[],
): { camera: number; weight: number }[];

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

/** The hierarchy of a mesh, built by the first call. Coordinates count from the mesh's origin. */
export function treeOf(mesh: Mesh): SurfaceTree;

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
  /** The places that the stream gives of it. */
  pathOf(id: number): { time: bigint; centre: Vector }[];
  /** Metres by which the coordinates of places are rounded at most. */
  readonly rounding: number;
  /** The objects that are one piece with an object at a time, with itself. */
  together(id: number, time: bigint | number): number[];
  /** The objects that a piece with a centre is. */
  at(centre: readonly number[], time: bigint | number): number[];
}

/** A value with half the width of the interval that holds the true one in 95 of 100 cases. */
export interface Measurement {
  value: number;
  uncertainty: number;
}

/** A place with its uncertainty in metres. */
export interface Point {
  position: readonly number[];
  uncertainty: number;
}

/** The key `mesh_error` of META (spec/registry.md); null: the stream does not say how exact its meshes are. */
export function meshErrorOf(configuration: { readonly metadata: Configuration["metadata"] }): {
  vertex: number;
  pixels: number | null;
  metres: number | null;
} | null;

/**
 * The uncertainty of a place of the surface, in metres, from what the stream says of its meshes; null: it says nothing, or no camera sees
 * the place. hull: the meshes are visual hulls; by how much they bulge is estimated from the directions of the cameras. How exactly
 * somebody points is not contained.
 */
export function pointUncertainty(frame: Frame, picked: PickedPlace, options?: { hull?: boolean }): number | null;
/** A pick as a point; null as pointUncertainty. */
export function pointOf(frame: Frame, picked: PickedPlace, options?: { hull?: boolean }): Point | null;
/** The centre of an object in a frame; null: it is not there, touches others, is in several pieces, or its uncertainty is unknown. */
export function centreOf(frame: Frame, id: number): Point | null;

/** The centre of an object over the whole stream, by the path that the stream gives, without decoding. frame: any, for what its cameras see. null in place of a
 * point where the object touches others; an empty list: there are no objects, or nothing is known of their uncertainty. */
export function pathOf(frame: Frame, id: number): ((Point & { time: bigint; seconds: number }) | null)[];

/** A place of the surface that is followed while the meshes keep their faces, as within a group, and over several if they are tracked. */
export class SurfacePoint {
  /** picked: found in the frame by a ray from origin. */
  constructor(frame: Frame, picked: Pick, origin: readonly number[]);
  /** The same place in another frame, as pointOf takes it; null: the faces are others. */
  in(frame: Frame): PickedPlace | null;
}

/** Metres. */
export function distance(a: Point, b: Point): Measurement;
/** Degrees between a and b as seen from `at`; null: one of them is as near to it as they are uncertain. */
export function angle(at: Point, a: Point, b: Point): Measurement | null;

export interface Floor {
  up: readonly number[];
  /** Along up, from the origin of the stream's coordinates. */
  level: number;
  uncertainty: number;
}
/** The plane through the lowest place of the meshes; null: up or the uncertainty is unknown, or there is no mesh. */
export function floorOf(frame: Frame): Floor | null;
/** Metres over a floor. */
export function height(point: Point, floor: Floor): Measurement;

export interface Motion {
  seconds: number;
  /** Metres a second. */
  velocity: Vector;
  speed: Measurement;
  /** Metres a second squared. */
  acceleration: Measurement;
}
/**
 * Speed and acceleration of a point over time, by the parabola that fits best around each sample; null where one of the samples
 * around it is missing. around: how many before and after it are used, 2 or more, by default 2.
 */
export function motion(
  samples: readonly ((Point & { seconds: number }) | null)[],
  options?: { around?: number },
): (Motion | null)[];

/** Comma-separated values (RFC 4180) of rows with the same keys; a Measurement takes two columns. */
export function csv(rows: readonly Record<string, Measurement | number | bigint | string | null>[]): string;
