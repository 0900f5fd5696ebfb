import type { Camera, Configuration, Frame, Mesh, Rect, Video } from "@fvv/decoder";

export const MAX_VIEWS: number;
/** Texels of a row of the table of views, four floats each. */
export const VIEW_TEXELS: number;
/** Texels of a row of the texture of visibility weights, four bytes each. */
export const WEIGHT_COLUMNS: number;
export const MAX_WEIGHT_TEXELS: number;

/** Where a camera's depth map is in its layer. */
export interface DepthPlace {
  scale: [number, number];
  offset: [number, number];
  size: [number, number];
  breadth: [number, number];
}

/** A camera that gives colours. source: the part of its picture that its tile shows; place: where the tile is in the texture. */
export interface View {
  camera: Camera;
  /** The camera's translation and centre, relative to originOf(frame). */
  translation: number[];
  centre: number[];
  source: Rect;
  place: Rect;
  depth?: DepthPlace | null;
  hasVisibilityWeights?: boolean;
  off?: boolean;
}

export interface Planes {
  video: Video;
  planes: { data: Uint8Array; width: number; height: number }[];
}
export interface WholePicture {
  video: Video;
  picture: VideoFrame | ImageBitmap;
}
export type Picture = Planes | WholePicture;
export interface LayerSizes {
  width: number;
  height: number;
  layers: number;
}

export function loadPicture(video: Video, picture: VideoFrame | ImageBitmap | null): Promise<Picture>;
export function loadPictures(frame: Frame): Promise<Picture[]>;
/** A picture that outlives its frame: planes, a clone, or the file of a JPEG picture. */
export type KeptPicture = Picture | { video: Video; file: Uint8Array | null };
/** Of pictures of loadPictures, before the frame is closed; closePictures frees them. */
export function keepPictures(pictures: Picture[], frame: Frame): KeptPicture[];
/** The same as loadPictures has returned; JPEG files are decoded again. */
export function loadKept(kept: KeptPicture[]): Promise<Picture[]>;
export function closePictures(kept: KeptPicture[]): void;
export function layoutOf(pictures: Picture[]): {
  places: Map<number, { x: number; y: number }>;
  width: number;
  height: number;
};
export function conversionOf(colour: Video["colour"]): { kr: number; kb: number; range: [number, number, number] };
/** Uniforms of replicatedFragment and replicationFragment, in addition to those of conversionOf. */
export function replicationOf(picture: WholePicture): { mixing: number[]; luma: number[] };
/** Detects pictures that the browser has converted to RGB with the nearest chroma sample, for each track. */
export class Replication {
  /** test: draws the picture with replicationFragment and returns its RGBA pixels. */
  isSeenIn(picture: WholePicture, test: () => Uint8Array): boolean;
}
/** Of the rule by which cameras are mixed; see src/camera_rule.js. */
export const APART: number;
export const FADE: number;
export const BORDER: number;
/** Texels per pixel from which on levels above the first are used. */
export const SHARP: number;
/** Levels of the texture of pictures; level 0 is the pictures as they are. */
export const LEVELS: number;
/** Whether shaders need the define LEVELS, and pictures more levels than the first. See src/views.js. */
export function usesLevels(
  frame: { views: readonly View[]; atlas: readonly number[] | null },
  sphere: { centre: readonly number[]; radius: number },
  eye: readonly number[],
  pixelAngle: number,
): boolean;
/** Shaders have 32 bits, which hold coordinates of maps to decimetres only: everything that is drawn counts from here. */
export function originOf(frame: Pick<Frame, "mesh" | "configuration">): [number, number, number];
/** The depth from which on cameras and viewers see a mesh of these bounds: 1 cm, or a hundredth of its longest side if that is less. */
export function nearPlaneOf(bounds: { min: readonly number[]; max: readonly number[] }): number;
/** Positions relative to the origin of the mesh. */
export function pointsOf(mesh: Pick<Mesh, "localPositions" | "positions">): Float32Array;
/** The same camera or viewer in coordinates that count from origin. */
export function viewFrom<T extends { rotation: readonly number[]; translation: readonly number[] }>(
  origin: readonly number[],
  view: T,
): T;
/** Vectors of three numbers. */
export type Vector3 = [number, number, number];
export function add(a: readonly number[], b: readonly number[]): Vector3;
export function subtract(a: readonly number[], b: readonly number[]): Vector3;
export function scale(a: readonly number[], s: number): Vector3;
export function dot(a: readonly number[], b: readonly number[]): number;
export function cross(a: readonly number[], b: readonly number[]): Vector3;
export function length(a: readonly number[]): number;
export function mix(a: readonly number[], b: readonly number[], s: number): number[];
/** otherwise: the result for vectors too short to have a direction. */
export function normalise(a: readonly number[], otherwise?: readonly number[]): readonly number[];
/** null: the vector is 0. */
export function unit(a: readonly number[]): Vector3 | null;
/**
 * The parts of the colour of a point that cameras give, by the rule of the shaders, the largest first; together 1, or none.
 * camera: index in centres, of cameras that show the point; factorOf(index): how much of its weight is left by its visibility
 * weight and the border of its tile, 0 to 1; 1 if it is not given.
 */
export function partsAt(
  point: readonly number[],
  normal: readonly number[],
  centres: readonly (readonly number[])[],
  eye: readonly number[],
  rule: { blend: "viewer" | "paper"; threshold: number; best: number },
  factorOf?: (camera: number) => number,
): { camera: number; part: number }[];
/** What an interpolated visibility weight, 0 to 255, leaves of a camera's weight, 0 to 1. */
export function visibilityFactor(blend: "viewer" | "paper", seen: number): number;
/** What this many pixels of a tile inside its usable border leave of its camera's weight, 0 to 1. */
export function borderFactor(blend: "viewer" | "paper", inside: number): number;
/** Defines of projection and blending for a frame's views, after their depth maps have been placed. */
export function definesOf(views: readonly View[]): { LENSES: 0 | 1 | 2; VIEW_BLOCKS: number; DEPTHS?: 1 };
export function viewsOf(frame: Frame, places: Map<number, { x: number; y: number }>): View[];
export function writeViews(views: View[], array: Float32Array): void;
export function visibilityWeightTexels(frame: Frame, mesh: Mesh, views: View[], maxTexels: number): number;
export function packVisibilityWeights(views: View[], vertexCount: number, texels: number, bytes: Uint8Array): void;
export class DepthPlan {
  /** Limit of all maps together; a texel has four bytes. Default 2^24. */
  constructor(maxTexels?: number);
  place(views: View[], needs: (view: View) => boolean): LayerSizes | null;
}
export function depthSizes(wanted: LayerSizes, former: LayerSizes | null): LayerSizes;

/** Maximum number of cameras that the shaders mix at a point. */
export const MAX_BEST: number;
/** What replaces the stream's constants; undefined and null do not. */
export interface TexturingOverrides {
  blend?: "viewer" | "paper" | null;
  threshold?: number;
  best?: number;
  unseen?: number | null;
}
export function checkTexturing(overrides: TexturingOverrides): void;
/** The values of the shaders' uniforms, of BEST and PAPER: the stream's constants, unless overridden. */
export function texturingOf(
  configuration: Configuration,
  overrides?: TexturingOverrides,
): {
  blend: "viewer" | "paper";
  threshold: number;
  best: number;
  /** Display values. */
  unseen: [number, number, number];
  /** Bias and slope of depth maps. */
  tolerance: [number, number];
  inset: number;
};

/** GLSL ES 3.00 without a version line; the sources document the names that each needs. */
export const projection: string;
export const depthVertex: string;
export const depthFragment: string;
export const visibilityWeightsVertex: string;
export const blending: string;
export const planesFragment: string;
export const copyFragment: string;
export const replicatedFragment: string;
export const replicationFragment: string;
