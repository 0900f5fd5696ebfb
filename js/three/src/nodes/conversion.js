// The colours of a picture's pixels as display values. at: the pixel, from the top left corner; range, kr and kb: see conversionOf of
// @fvv/shading.

import { clamp, float, Fn, ivec2, textureLoad, textureSize, vec2, vec3, vec4 } from "three/tsl";

/** Converts 4:2:0 samples, 0 to 1, to display values. */
function display({ range, kr, kb }, luma, chroma) {
  const y = luma.sub(range.x).mul(range.y).toVar();
  const p = vec2(kb, kr)
    .oneMinus()
    .mul(2)
    .mul(range.z)
    .mul(chroma.sub(128 / 255))
    .toVar();
  const green = y.sub(kb.mul(p.x).add(kr.mul(p.y)).div(float(1).sub(kr).sub(kb)));
  return vec4(clamp(vec3(y.add(p.y), green, y.add(p.x)), 0, 1), 1);
}

/** 4:2:0 to RGB. Chroma is interpolated. */
export const fromPlanes = (at, values, [Y, U, V]) =>
  Fn(() => {
    const place = at
      .div(2)
      .div(vec2(textureSize(U, 0)))
      .toVar();
    const chroma = vec2(U.sample(place).level(0).r, V.sample(place).level(0).r);
    return display(values, textureLoad(Y, ivec2(at)).r, chroma);
  })();

export const copied = (at, values, [picture]) => Fn(() => vec4(textureLoad(picture, ivec2(at)).rgb, 1))();
