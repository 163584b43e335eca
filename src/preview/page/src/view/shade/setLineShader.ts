// The shader of edge sets.

import { LINE_QUAD, LINE_REACH } from "./lineShader";
import { HIGHLIGHTED } from "./classes";

// A line lies in the surface, so it comes nearer to the eye by a few of its pixels: the more, the more the surface beside it
// rises towards the eye, as along curves, and over another mesh.
export const SET_LINE_VERTEX = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;
uniform mat4 modelViewMatrix;
uniform mat3 normalMatrix;
uniform sampler2D uPoints;
uniform sampler2D uNormals;
uniform sampler2D uPalette;
uniform bool uFlat;
uniform bool uEdgeSets;
uniform bool uOver;
uniform int uHot;
uniform float uPixel;
uniform float uBias;
uniform vec3 uAccent;
in uvec2 aEnds;
in vec4 aUvs;
in uint aClass;
flat out vec3 vColour;
flat out float vRadius;
${LINE_QUAD}

ivec2 cell(uint index) {
  return ivec2(int(index & 1023u), int(index >> 10));
}

// Rise of the surface for one step across the view, seen from the eye.
float slope(uint point, vec3 view) {
  vec3 normal = normalMatrix * texelFetch(uNormals, cell(point), 0).xyz;
  float facing = abs(dot(normal, view)) / max(length(normal) * length(view), 1e-20);
  return clamp(sqrt(max(0.0, 1.0 - facing * facing)) / max(facing, 1e-3), 1.0, 6.0);
}

vec4 place(uint point, vec2 uv, float nearer) {
  vec3 p = uFlat ? vec3(uv, 0.0) : texelFetch(uPoints, cell(point), 0).xyz;
  vec4 view = modelViewMatrix * vec4(p, 1.0);
  if (uFlat) return view + vec4(0.0, 0.0, nearer, 0.0);
  float pixel = 2.0 * -view.z / (projectionMatrix[1][1] * uView.y);
  float bias = (uOver ? uBias : 0.0) + (nearer + 2.0 * slope(point, view.xyz)) * pixel * uPixel;
  view.xyz *= 1.0 - bias / max(length(view.xyz), 2.0 * bias);
  return view;
}

void main() {
  bool hot = aClass == ${HIGHLIGHTED}u || int(aClass) == uHot;
  if (!hot && !uEdgeSets) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  vColour = hot ? uAccent : texelFetch(uPalette, ivec2(int(aClass), 0), 0).rgb;
  vRadius = (hot ? 2.0 : 1.25) * uPixel;
  float nearer = hot ? 1.0 : 0.5;
  lineQuad(place(aEnds.x, aUvs.xy, nearer), place(aEnds.y, aUvs.zw, nearer), vRadius + 1.0);
}
`;

export const SET_LINE_FRAGMENT = /* glsl */ `
precision highp float;
flat in vec3 vColour;
flat in float vRadius;
uniform bool uHard;
out vec4 colour;
${LINE_REACH}
void main() {
  float alpha = clamp(vRadius - lineReach() + 0.5, 0.0, 1.0);
  // Samples that are moved by parts of a pixel have edges of their own.
  if (uHard) alpha = step(0.5, alpha);
  if (alpha <= 0.0) discard;
  colour = vec4(vColour, alpha);
}
`;
