// Projection through the cameras of the table of views, as glsl/surface.js of @fvv/shading has it, which describes the table's rows.

import { atan, dot, float, If, int, ivec2, length, textureLoad, vec2, vec3, vec4 } from "three/tsl";

/** A texel of a view's row. */
export const texel = (views, view, i) => textureLoad(views, ivec2(int(i), int(view)));

export function toCamera(views, view, point) {
  const p = vec4(point, 1);
  return vec3(dot(texel(views, view, 0), p), dot(texel(views, view, 1), p), dot(texel(views, view, 2), p));
}

/**
 * Pixel of the camera's picture, and whether the camera can show it: not behind it nor beyond the range of its lens. lenses: what
 * lenses there are, LENSES of definesOf.
 */
export function toPicture(views, view, at, lenses) {
  const intrinsics = texel(views, view, 4).toVar();
  const more = texel(views, view, 5).toVar();
  const q = at.xy.div(at.z).toVar();
  const r = length(q).toVar();
  if (lenses > 1)
    If(more.z.greaterThan(1.5), () => {
      const angle = atan(r).toVar();
      If(r.greaterThan(0), () => {
        q.mulAssign(angle.div(r));
      });
      r.assign(angle);
    });
  const d = q.toVar();
  if (lenses > 0) {
    const k = texel(views, view, 6).toVar();
    const l = texel(views, view, 7).toVar();
    const s = r.mul(r).toVar();
    const series = (...factors) => factors.reduceRight((rest, factor) => s.mul(rest).add(factor));
    If(more.z.greaterThan(1.5), () => {
      d.assign(q.mul(series(float(1), k.x, k.y, k.z, k.w)));
    }).ElseIf(more.z.greaterThan(0.5), () => {
      const h = series(float(1), k.x, k.y, l.x).div(series(float(1), l.y, l.z, l.w));
      const wz = vec2(k.w, k.z).toVar();
      d.assign(
        q
          .mul(h)
          .add(s.mul(wz))
          .add(q.mul(dot(q, wz).mul(2))),
      );
    });
  }
  const pixel = vec2(
    intrinsics.x.mul(d.x).add(more.x.mul(d.y)).add(intrinsics.z),
    intrinsics.y.mul(d.y).add(intrinsics.w),
  ).toVar();
  return { pixel, isThere: at.z.greaterThan(0).and(r.lessThanEqual(more.y)) };
}

/**
 * Clip coordinates of a point in a view's frame in its layer of depth maps, whose first row is at the top. depthRange: x and y of
 * depths x + y * z / w, for z / w from -1 at nearPlane to 1.
 */
export function toDepthMap(views, view, at, layerSize, nearPlane, depthRange) {
  const plan = texel(views, view, 10).toVar();
  const place = at.xy.mul(plan.xy).add(plan.zw.mul(at.z)).mul(2).div(layerSize).sub(at.z).toVar();
  const z = at.z.sub(nearPlane.mul(2));
  return vec4(place.x, place.y.negate(), depthRange.x.mul(at.z).add(depthRange.y.mul(z)), at.z);
}
