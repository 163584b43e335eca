// Light that does not reach a place, in the shader of cloth.

import { LIGHTS } from "../rest/samples";

export const SHADOW_UNIFORMS = /* glsl */ `
uniform float uShade;
uniform float uNoise;
// Width of a pixel, of the map, of its depth, and the widest blur, in units of the mesh.
uniform vec4 uLightSpan;
uniform vec3 uLightAxis;
uniform vec3 uLights[${LIGHTS}];
uniform mat4 uLightMatrices[${LIGHTS}];
uniform sampler2D uLightMaps[${LIGHTS}];
`;

const HELD = [...Array(LIGHTS).keys()]
  .map((at) => `sum += held(uLightMaps[${at}], uLightMatrices[${at}], uLights[${at}], n, own, ${at}.0);`)
  .join("\n  ");

// Each light stands for a cone of directions, so that the edge of a shadow is blurred by the distance to what casts it: a
// random place in the cone is tried. The half sphere of light gives (1 + cos) / 4 of the light all around the normal.
export const SHADOW_CODE = /* glsl */ `
const float CONE = 0.22;

// How far what casts a shadow is above the plane of the surface, beside the place.
float above(sampler2D map, vec3 place, vec2 slope, vec2 beside) {
  float depth = textureLod(map, place.xy + beside / uLightSpan.y, 0.0).r;
  return (place.z - depth) * uLightSpan.z + dot(slope, beside);
}

uint scramble(uint v) {
  v = v * 747796405u + 2891336453u;
  v = ((v >> ((v >> 28) + 4u)) ^ v) * 277803737u;
  return (v >> 22) ^ v;
}

vec2 polar(float turn, float radius) {
  return radius * vec2(cos(6.2831853 * turn), sin(6.2831853 * turn));
}

float held(sampler2D map, mat4 toMap, vec3 light, vec3 n, vec3 own, float number) {
  float rise = dot(own, light);
  float weight = max(0.0, dot(n, light)) * smoothstep(0.03, 0.2, rise);
  vec3 place = (toMap * vec4(vView + own * 1.8 * uLightSpan.x, 1.0)).xyz * 0.5 + 0.5;
  bool isInside = all(greaterThan(place, vec3(0.0))) && all(lessThan(place, vec3(1.0)));
  if (weight <= 0.0 || !isInside) return 0.0;
  vec3 side = normalize(vec3(toMap[0][0], toMap[1][0], toMap[2][0]));
  vec3 upward = normalize(vec3(toMap[0][1], toMap[1][1], toMap[2][1]));
  vec2 slope = vec2(dot(own, side), dot(own, upward)) / max(rise, 0.1);
  uint seed = scramble(uint(gl_FragCoord.x) + 4096u * uint(gl_FragCoord.y) + uint(uNoise * 16.0 + number) * 2654435761u);
  float noise = float(seed & 0xffffu) / 65536.0;
  float other = float(seed >> 16) / 65536.0;
  float height = above(map, place, slope, polar(other, 0.5 * uLightSpan.x));
  if (height <= 0.0) height = above(map, place, slope, polar(noise, other * uLightSpan.w));
  if (height <= 0.0) return 0.0;
  float blur = min(height * CONE, uLightSpan.w);
  vec2 beside = polar(other, sqrt(noise) * blur + 0.5 * uLightSpan.x);
  return above(map, place, slope, beside) > 0.0 ? weight : 0.0;
}

float shadow(vec3 n, vec3 own) {
  float sum = 0.0;
  ${HELD}
  return uShade * sum / (${LIGHTS}.0 * 0.25 * max(0.2, 1.0 + dot(n, uLightAxis)));
}
`;
