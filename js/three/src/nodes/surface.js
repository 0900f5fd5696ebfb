// The blending of the best cameras at a point in three's shading language, by the rules of docs/tools/fvvrender.md: the same as
// blending in glsl/surface.js of @fvv/shading, whose names it has, and which says why. What is chosen there by the preprocessor is
// chosen here when the nodes are made.

import { APART, BORDER, FADE, LEVELS, SHARP } from "@fvv/shading";
import {
  abs,
  attribute,
  bool,
  clamp,
  cross,
  dFdx,
  dFdy,
  distance,
  dot,
  float,
  floor,
  Fn,
  frontFacing,
  If,
  int,
  inverseSqrt,
  ivec2,
  length,
  log2,
  Loop,
  max,
  min,
  mix,
  normalGeometry,
  normalize,
  positionGeometry,
  select,
  sqrt,
  sRGBTransferEOTF,
  step,
  texture,
  textureLoad,
  uv,
  varying,
  vec2,
  vec3,
  vec4,
  vertexIndex,
} from "three/tsl";

import { texel, toCamera, toPicture } from "./projection.js";

const BY_WEIGHTS = 1;
const BY_DEPTH = 2;
const OFF = 4;
const WEIGHT_BITS = 11; // of WEIGHT_COLUMNS

const has = (flags, flag) => flags.bitAnd(flag).notEqual(0);
const times = (count, make) => Array.from({ length: count }, (_, i) => make(i));

/** The visibility weights of the vertex, four cameras in each varying. */
const passedWeights = ({ WEIGHT_TEXELS }, { visibilityWeights }) =>
  times(WEIGHT_TEXELS, (i) => {
    const at = int(vertexIndex).mul(WEIGHT_TEXELS).add(i);
    const place = ivec2(at.bitAnd(2 ** WEIGHT_BITS - 1), at.shiftRight(WEIGHT_BITS));
    return varying(textureLoad(visibilityWeights, place), `vVisibility${i}`);
  });

/** Nodes for one set of defines: those of @fvv/shading. u: parameters and textures as nodes, by their names there. */
class Blending {
  #d;
  #u;
  #passed;

  constructor(defines, u) {
    this.#d = defines;
    this.#u = u;
    this.#passed = passedWeights(defines, u);
  }

  #texel(view, i) {
    return texel(this.#u.views, view, i);
  }

  #hidden(view, at, normal) {
    const { nearPlane, depths, tolerance } = this.#u;
    const plan = this.#texel(view, 10).toVar();
    const sizes = this.#texel(view, 11).toVar();
    const place = floor(at.xy.div(at.z).mul(plan.xy).add(plan.zw)).toVar();
    const isIn = at.z
      .greaterThanEqual(nearPlane)
      .and(
        place.x.greaterThanEqual(0),
        place.y.greaterThanEqual(0),
        place.x.lessThan(sizes.x),
        place.y.lessThan(sizes.y),
      );
    const hidden = bool(true).toVar();
    If(isIn, () => {
      const nearest = textureLoad(depths, ivec2(place)).depth(int(view)).r.toVar();
      const facing = abs(dot(normal, at)).div(at.z).toVar();
      const slope = select(
        facing.greaterThan(0),
        at.z.mul(length(normal.xy.mul(sizes.zw))).div(max(facing, 1e-20)),
        float(0),
      ).toVar();
      const spare = tolerance.x.mul(at.z).mul(max(sizes.z, sizes.w)).add(tolerance.y.mul(slope));
      hidden.assign(nearest.notEqual(0).and(at.z.greaterThan(nearest.add(spare))));
    });
    return hidden;
  }

  #shownPlace(point, normal) {
    const { eye, inset } = this.#u;
    if (!this.#d.INSET) return point;
    const towardsEye = normalize(eye.sub(point)).toVar();
    return point.sub(towardsEye.mul(inset.div(max(dot(normal, towardsEye), 0.5)))).toVar();
  }

  /** {showing, at}: how well a view shows the point, and where, in texels of pictures. */
  #shows(view, point, shown, faceNormal) {
    const { views } = this.#u;
    const source = this.#texel(view, 8).toVar();
    const place = this.#texel(view, 9).toVar();
    const { pixel, isThere } = toPicture(views, view, toCamera(views, view, shown).toVar(), this.#d.LENSES ?? 2);
    const seen = isThere.toVar();
    const inTile = pixel.sub(source.xy).mul(place.zw).div(source.zw).toVar();
    const nearest = min(inTile, place.zw.sub(inTile)).sub(0.5).toVar();
    const inside = min(nearest.x, nearest.y).toVar();
    if (this.#d.DEPTHS) {
      const centre = this.#texel(view, 3).toVar();
      If(has(int(centre.w), BY_DEPTH), () => {
        const row = (i) => dot(this.#texel(view, i).xyz, faceNormal);
        const normalInCamera = vec3(row(0), row(1), row(2)).toVar();
        const faces = dot(faceNormal, centre.xyz.sub(point)).greaterThan(0);
        const hidden = this.#hidden(view, toCamera(views, view, point).toVar(), normalInCamera);
        seen.assign(seen.and(faces, hidden.not()));
      });
    }
    const showing = this.#d.PAPER
      ? select(seen.and(inside.greaterThanEqual(0)), float(1), float(0))
      : select(seen, clamp(inside.div(BORDER), 0, 1), float(0));
    // A place beyond the lens may be no number, and is not used.
    return { showing: showing.toVar(), at: select(seen, place.xy.add(inTile), vec2(0)).toVar() };
  }

  /** {limit, facing} of a view: the most that it can weigh, and the same without the angle to the viewer. */
  #limitOf(centre, point, normal, towardsEye, visibility) {
    const { threshold } = this.#u;
    const away = centre.xyz.sub(point).toVar();
    const ray = away.mul(inverseSqrt(dot(away, away))).toVar();
    const flags = int(centre.w).toVar();
    const cosine = dot(normal, ray).toVar();
    let facing = this.#d.PAPER
      ? select(cosine.greaterThanEqual(threshold), max(0, cosine), float(0))
      : max(0, cosine.sub(threshold).div(threshold.oneMinus()));
    if (visibility) {
      const sees = this.#d.PAPER ? step(0.5, visibility) : max(0, visibility.mul(2).sub(1));
      facing = facing.mul(select(has(flags, BY_WEIGHTS), sees, float(1)));
    }
    facing = facing.mul(select(has(flags, OFF), float(0), float(1))).toVar();
    if (this.#d.PAPER) return { limit: facing, facing };
    const apart = float(APART).sub(dot(ray, towardsEye)).toVar();
    return { limit: facing.div(apart.mul(apart)), facing };
  }

  /** A variable with the limit, and one with the facing, of every view that may exist. */
  #limitsAt(point, normal, towardsEye) {
    return times(4 * this.#d.VIEW_BLOCKS, (i) => {
      const visibility = this.#passed[i >> 2] && ["x", "y", "z", "w"].map((k) => this.#passed[i >> 2][k])[i & 3];
      const zero = this.#d.WEIGHT_TEXELS ? float(0) : null;
      const found = this.#limitOf(this.#texel(i, 3).toVar(), point, normal, towardsEye, visibility ?? zero);
      const exists = int(i).lessThan(this.#u.viewCount);
      return { limit: select(exists, found.limit, float(0)).toVar(), facing: found.facing };
    });
  }

  /** The best views by descending weight, [{view, weight, at}], and share: the part of their colour beside the surface's own. */
  #chooseViews(point, faceNormal, normal) {
    const { PAPER, BEST, COLOURS } = this.#d;
    const kept = times(PAPER ? BEST : BEST + 1, () => ({
      view: float(-1).toVar(),
      weight: float(0).toVar(),
      certain: float(0).toVar(),
      at: vec2(0).toVar(),
    }));
    const shown = this.#shownPlace(point, normal);
    const all = this.#limitsAt(point, normal, normalize(this.#u.eye.sub(point)).toVar());
    const next = { limit: float(0).toVar(), facing: float(0).toVar(), view: float(-1).toVar() };
    const takeNext = () => {
      next.limit.assign(kept.at(-1).weight);
      next.facing.assign(0);
      next.view.assign(-1);
      all.forEach(({ limit, facing }, i) => {
        If(limit.greaterThan(next.limit), () => {
          next.limit.assign(limit);
          next.facing.assign(facing);
          next.view.assign(i);
        });
      });
      all.forEach(({ limit }, i) => {
        If(next.view.equal(i), () => {
          limit.assign(0);
        });
      });
    };
    takeNext();
    Loop(next.view.greaterThanEqual(0), () => {
      const { showing, at } = this.#shows(int(next.view), point, shown, faceNormal);
      const found = { view: next.view, at };
      found.weight = next.limit.mul(showing).toVar();
      found.certain = next.facing.mul(showing).toVar();
      for (let i = kept.length - 1; i >= 0; i--)
        If(found.weight.greaterThan(kept[i].weight), () => {
          for (const name of ["view", "certain", "at", "weight"]) {
            if (i + 1 < kept.length) kept[i + 1][name].assign(kept[i][name]);
            kept[i][name].assign(found[name]);
          }
        });
      takeNext();
    });
    if (PAPER) return { kept, share: float(1) };
    const last = kept[BEST].weight.mul(FADE).toVar();
    const best = kept.slice(0, BEST);
    for (const { weight } of best) weight.assign(max(0, weight.sub(last)));
    if (!COLOURS) return { kept: best, share: float(1) };
    const sum = best
      .map(({ weight }) => weight)
      .reduce((a, b) => a.add(b))
      .toVar();
    const certainty = best.map(({ weight, certain }) => weight.mul(certain)).reduce((a, b) => a.add(b));
    const share = select(sum.greaterThan(0), min(1, certainty.mul(10).div(max(sum, 1e-20))), float(1)).toVar();
    return { kept: best, share };
  }

  #lightAt(point, normal) {
    const { eye, viewerUp, viewerRight } = this.#u;
    const towardsEye = normalize(eye.sub(point)).toVar();
    const n = select(dot(normal, towardsEye).lessThan(0), normal.negate(), normal).toVar();
    const lamp = max(0, dot(n, normalize(towardsEye.add(viewerUp.mul(0.6)).sub(viewerRight.mul(0.5)))));
    return float(0.38).add(dot(n, viewerUp).mul(0.5).add(0.5).mul(0.3)).add(lamp.mul(0.62));
  }

  #levelFor(texels) {
    return clamp(log2(texels.div(SHARP)), 0, LEVELS - 1);
  }
  #pictureColour(at, level) {
    const { pictures, pictureSize } = this.#u;
    return texture(pictures, at.div(pictureSize)).level(level).rgb;
  }

  #viewColour(view, point, at) {
    const { eye, pixelAngle } = this.#u;
    if (!this.#d.LEVELS) return this.#pictureColour(at, float(0));
    const row = (i) => this.#texel(int(view), i);
    const width = distance(row(3).xyz, point)
      .mul(row(8).z)
      .div(row(9).z.mul(row(4).x));
    return this.#pictureColour(at, this.#levelFor(distance(eye, point).mul(pixelAngle).div(width)));
  }

  /** The colour of an atlas as display values. */
  atlasColour(place) {
    const { atlas } = this.#u;
    const at = atlas.xy.add(clamp(place.mul(atlas.zw), vec2(0.5), atlas.zw.sub(0.5)));
    if (!this.#d.LEVELS) return this.#pictureColour(at, float(0));
    const [dx, dy] = [dFdx(place).mul(atlas.zw).toVar(), dFdy(place).mul(atlas.zw).toVar()];
    return this.#pictureColour(at, this.#levelFor(sqrt(max(dot(dx, dx), dot(dy, dy)))));
  }

  /** The colour of a point as display values. own: the colour of the vertices, interpolated, or that of unseen surface. */
  surfaceColour(point, faceNormal, normal, own) {
    const colour = vec3(own).toVar();
    If(this.#u.viewCount.equal(0), () => {
      colour.mulAssign(this.#lightAt(point, normal));
    }).Else(() => {
      const { kept, share } = this.#chooseViews(point, faceNormal, normal);
      const sum = float(0).toVar();
      const mixed = vec3(0).toVar();
      for (const { view, weight, at } of kept.slice(0, this.#d.BEST)) {
        sum.addAssign(weight);
        mixed.addAssign(this.#viewColour(view, point, at).mul(weight));
      }
      If(sum.greaterThan(0), () => {
        colour.assign(mix(colour, mixed.div(sum), share));
      });
    });
    return colour;
  }
}

/** Node of the surface's colour in linear light, for a material's colorNode. */
export function surfaceNode(defines, u) {
  const rule = new Blending(defines, u);
  return Fn(() => {
    if (defines.ATLAS) return vec4(sRGBTransferEOTF(rule.atlasColour(uv())), 1);
    const point = varying(positionGeometry, "vPoint");
    const own = defines.COLOURS ? attribute("vertexColour", "vec4").rgb : u.unseen;
    const across = normalize(cross(dFdx(point), dFdy(point))).toVar();
    const faceNormal = across.mul(select(frontFacing, u.handedness, u.handedness.negate())).toVar();
    const normal = normalize(varying(normalGeometry, "vNormal")).toVar();
    return vec4(sRGBTransferEOTF(rule.surfaceColour(point, faceNormal, normal, own)), 1);
  })();
}
