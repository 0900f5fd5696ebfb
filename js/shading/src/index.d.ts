import { Camera, Configuration, Frame, Mesh, Rect, Video } from "@fvv/decoder";

export const MOST_VIEWS: number;
/** Texels of a row of the table of views, four floats each. */
export const VIEW_TEXELS: number;
/** Texels of a row of the texture of shares, four bytes each. */
export const SHARE_COLUMNS: number;
export const MOST_SHARE_TEXELS: number;

/** Where a camera's depth map stands in its layer. */
export interface DepthPlace {
  scale: [number, number];
  offset: [number, number];
  size: [number, number];
  breadth: [number, number];
}

/** A camera that gives colours: source is what its tile shows of its picture, place where the tile is in the texture. */
export interface View {
  camera: Camera;
  source: Rect;
  place: Rect;
  depth?: DepthPlace | null;
  hasShares?: boolean;
  off?: boolean;
}

export interface Planes {
  video: Video;
  planes: { data: Uint8Array; width: number; height: number }[];
}
export interface Image {
  video: Video;
  image: VideoFrame | ImageBitmap;
}
export type Picture = Planes | Image;
export interface LayerSizes {
  width: number;
  height: number;
  layers: number;
}

export function loadPicture(video: Video, image: VideoFrame | ImageBitmap | null): Promise<Picture>;
export function loadPictures(frame: Frame): Promise<Picture[]>;
export function layoutOf(pictures: Picture[]): {
  places: Map<number, { x: number; y: number }>;
  width: number;
  height: number;
};
export function conversionOf(colour: Video["colour"]): { kr: number; kb: number; range: [number, number, number] };
/** Uniforms of replicatedFragment and replicationFragment, beside those of conversionOf. */
export function replicationOf(picture: Image): { mixing: number[]; luma: number[] };
/** Whether browsers have converted pictures themselves, with the nearest sample of chroma; asked of each track until it is known. */
export class Replication {
  /** test: draws the picture with replicationFragment and answers its pixels, RGBA. */
  isSeenIn(picture: Image, test: () => Uint8Array): boolean;
}
export function viewsOf(frame: Frame, places: Map<number, { x: number; y: number }>): View[];
export function writeViews(views: View[], array: Float32Array): void;
export function shareTexels(frame: Frame, mesh: Mesh, views: View[], most: number): number;
export function packShares(views: View[], vertexCount: number, texels: number, bytes: Uint8Array): void;
export class DepthPlan {
  /** Of all maps together, four bytes each. Default 2^24. */
  constructor(mostTexels?: number);
  place(views: View[], needs: (view: View) => boolean): LayerSizes | null;
}
export function depthSizes(wanted: LayerSizes, had: LayerSizes | null): LayerSizes;

/** Most cameras for a place that the shaders mix. */
export const MOST_BEST: number;
export function checkTexturing(own: { threshold?: number; best?: number; unseen?: number | null }): void;
/** What the shaders' uniforms and BEST are: the stream's constants, but for those that are given. */
export function texturingOf(
  configuration: Configuration,
  own?: { threshold?: number; best?: number; unseen?: number | null },
): {
  threshold: number;
  best: number;
  /** Display values. */
  unseen: [number, number, number];
  /** Bias and slope of depth maps. */
  tolerance: [number, number];
};

/** GLSL ES 3.00 without a version line: what each wants defined and named stands in its source. */
export const projection: string;
export const depthVertex: string;
export const depthFragment: string;
export const sharesVertex: string;
export const blending: string;
export const planesFragment: string;
export const copyFragment: string;
export const replicatedFragment: string;
export const replicationFragment: string;
