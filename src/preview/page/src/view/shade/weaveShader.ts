// The relief of woven and knitted cloth, in the shader of cloth.

import { WEAVES } from "./fabric";

// One thread or stitch is one unit of `p`. Relief that is finer than a pixel is left out.
export const WEAVE_CODE = /* glsl */ `
float thread(vec2 p) {
  return sin(3.14159 * fract(p.x)) * (0.45 + 0.55 * sin(3.14159 * fract(p.y)));
}

float relief(vec2 p) {
  vec2 cell = floor(p);
  if (uWeave == ${WEAVES.plain}) return mod(cell.x + cell.y, 2.0) < 1.0 ? thread(p) : thread(p.yx);
  if (uWeave == ${WEAVES.twill}) return mod(cell.x + cell.y, 4.0) < 2.0 ? thread(p) : 0.75 * thread(p.yx);
  float legs = abs(fract(p.x) - 0.5);
  return sqrt(sin(3.14159 * fract(p.y + 1.1 * legs))) * sin(6.28318 * legs);
}

// The normal with the relief, and in the fourth number its height from 0 to 1.
vec4 woven(vec3 n, vec3 dx, vec3 dy, vec2 ux, vec2 uy) {
  float wide = max(max(abs(ux.x) + abs(uy.x), abs(ux.y) + abs(uy.y)), 1e-9);
  float strength = 1.0 - smoothstep(0.2, 0.75, wide);
  float area = ux.x * uy.y - ux.y * uy.x;
  if (strength <= 0.0 || abs(area) < 1e-12) return vec4(n, 0.5);
  vec2 p = vUv * uThreads / uPitch;
  float height = relief(p);
  vec2 slope = vec2(relief(p + vec2(0.04, 0.0)), relief(p + vec2(0.0, 0.04))) - height;
  vec3 u = (dx * uy.y - dy * ux.y) / area;
  vec3 v = (dy * ux.x - dx * uy.x) / area;
  vec3 bent = n - strength * 0.35 * (slope.x * normalize(u) + slope.y * normalize(v)) / 0.04;
  return vec4(normalize(bent), mix(0.5, height, strength));
}
`;
