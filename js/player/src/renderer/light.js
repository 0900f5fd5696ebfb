// Light on a surface that has no pictures, so that its shape can be seen: a lamp at the viewer's left shoulder, and the sky
// above a darker ground.

export const lighting = /* glsl */ `
uniform vec3 up;
// right: of the viewer.
vec3 lit(vec3 colour, vec3 normal, vec3 towardsEye, vec3 right) {
  // Surfaces that are seen from the back are lit as well.
  vec3 n = dot(normal, towardsEye) < 0.0 ? -normal : normal;
  float lamp = max(0.0, dot(n, normalize(towardsEye + 0.6 * up - 0.5 * right)));
  float sky = 0.5 + 0.5 * dot(n, up);
  return colour * (0.38 + 0.3 * sky + 0.62 * lamp);
}
`;
