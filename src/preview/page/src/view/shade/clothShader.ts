// The shader of a mesh: cloth, colours of sets, checker and heat, with its wires. With PICK it writes face numbers.

import { ABOUT_IDEAL, HEAT } from "./heat";
import { BORDER } from "./classes";
import { CLOTH, IMAGE, ROUGHNESS } from "./fabric";
import { SHADOW_CODE, SHADOW_UNIFORMS } from "./shadowShader";

/** The terms of a polynomial from the highest, as code. */
const heatTerms = [...HEAT]
  .reverse()
  .map((term) => `sum = sum * t + vec3(${term.map((value) => value.toFixed(10)).join(", ")});`)
  .join("\n  ");

const [below, ideal, above] = ABOUT_IDEAL.map((colour) => `vec3(${colour.map((value) => value.toFixed(3)).join(", ")})`);

export const CLOTH_VERTEX = /* glsl */ `
uniform sampler2D uPoints;
uniform sampler2D uNormals;
uniform sampler2D uFaces;
uniform bool uFlat;
uniform float uBias;

in uint aPoint;
in uint aFace;
in vec2 aUv;
in uvec4 aEdges;
in float aValue;

out vec3 vView;
out vec3 vNormal;
out float vCurvature;
out vec3 vBary;
out vec2 vUv;
out float vValue;
flat out vec4 vFace;
flat out uvec3 vEdges;
flat out uint vNumber;

ivec2 cell(uint index) {
  return ivec2(int(index & 1023u), int(index >> 10));
}

#ifdef DEPTH
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(texelFetch(uPoints, cell(aPoint), 0).xyz, 1.0);
}
#else
void main() {
  vec3 place = uFlat ? vec3(aUv, 0.0) : texelFetch(uPoints, cell(aPoint), 0).xyz;
  vec4 bent = texelFetch(uNormals, cell(aPoint), 0);
  vec4 view = modelViewMatrix * vec4(place, 1.0);
  vView = view.xyz;
  vNormal = normalMatrix * bent.xyz;
  vCurvature = bent.w;
  int corner = gl_VertexID % 3;
  vBary = vec3(corner == 0, corner == 1, corner == 2);
  vUv = aUv;
  vValue = aValue;
  vFace = texelFetch(uFaces, cell(aFace), 0);
  vEdges = aEdges.xyz;
  vNumber = aFace;
  if (!uFlat) view.xyz *= 1.0 - uBias / max(length(view.xyz), 2.0 * uBias);
  gl_Position = projectionMatrix * view;
}
#endif
`;

export const CLOTH_FRAGMENT = /* glsl */ `
uniform bool uFlat;
uniform bool uHasUv;
uniform bool uHasValues;
uniform bool uWires;
uniform bool uEdgeSets;
uniform bool uOverlay;
uniform int uShading;
uniform float uPixel;
uniform float uSize;
uniform float uHanded;
uniform float uSquares;
uniform bool uAboutIdeal;
uniform vec3 uUp;
uniform vec3 uAccent;
uniform vec3 uWireColour;
uniform sampler2D uLooks;
uniform bool uOwnColour;
#ifdef IMAGES
uniform mediump sampler2DArray uImages;
#endif
uniform vec3 uColour;
uniform float uRoughness;
uniform float uUvLength;
#ifdef FABRIC
uniform sampler2D uFabric;
uniform float uFabricSize;
#endif
#ifdef RELIEF
uniform sampler2D uRelief;
uniform float uReliefSize;
uniform bool uHasHeights;
#endif
#ifdef SHADOWS
${SHADOW_UNIFORMS}#endif
in vec3 vView;
in vec3 vNormal;
in float vCurvature;
in vec3 vBary;
in vec2 vUv;
in float vValue;
flat in vec4 vFace;
flat in uvec3 vEdges;
flat in uint vNumber;

out vec4 colour;

const int FACE_SETS = 1;
const int CHECKER = 2;
const int VALUES = 3;

vec3 heat(float t) {
  if (uAboutIdeal) return mix(${ideal}, t < 0.5 ? ${below} : ${above}, abs(2.0 * t - 1.0));
  vec3 sum = vec3(0.0);
  ${heatTerms}
  return clamp(sum, 0.0, 1.0);
}

// 1 and -1 by turns, filtered over the pixel.
float checks(vec2 p) {
  vec2 w = max(fwidth(p), vec2(1e-5));
  vec2 i = 2.0 * (abs(fract((p - 0.5 * w) * 0.5) - 0.5) - abs(fract((p + 0.5 * w) * 0.5) - 0.5)) / w;
  return clamp(i.x, -1.0, 1.0) * clamp(i.y, -1.0, 1.0);
}

float hatch() {
  float stripe = abs(fract((gl_FragCoord.x + gl_FragCoord.y) / (11.0 * uPixel)) - 0.5) * 11.0;
  return clamp(stripe - 4.2, 0.0, 1.0);
}

vec3 checker() {
  if (!uHasUv) return mix(vec3(0.60, 0.61, 0.63), vec3(0.47, 0.48, 0.50), hatch());
  float fine = checks(vUv * uSquares);
  float coarse = checks(vUv * uSquares / 8.0);
  vec3 light = mix(vec3(0.88, 0.87, 0.84), vec3(0.80, 0.85, 0.90), 0.5 + 0.5 * coarse);
  vec3 dark = mix(vec3(0.46, 0.47, 0.49), vec3(0.36, 0.44, 0.54), 0.5 + 0.5 * coarse);
  return mix(dark, light, 0.5 + 0.5 * fine);
}

// The face's own material: a colour or the layer of an image, and in the fourth number the roughness and which of both it is.
vec4 look() {
  return texelFetch(uLooks, ivec2(int(vNumber & 1023u), int(vNumber >> 10)), 0);
}

float ownRoughness() {
  float value = floor(look().a * 255.0 + 0.5);
  return (value < ${IMAGE}.0 ? value : value - ${IMAGE}.0) / ${IMAGE - 1}.0;
}

vec3 ownColour() {
  vec4 own = look();
#ifdef IMAGES
  // Before the branch, as the size of a pixel on the image comes from the pixels beside it.
  vec3 image = texture(uImages, vec3(vUv, floor(own.r * 255.0 + 0.5))).rgb;
  if (own.a > 0.5) return uHasUv ? image : vec3(${CLOTH.join(", ")});
#endif
  return own.rgb;
}

// The colour of the face in sRGB, without light.
vec3 surface() {
  int flags = int(vFace.a * 255.0 + 0.5);
  vec3 base = uOwnColour && uShading == 0 ? ownColour() : uColour;
#ifdef FABRIC
  vec3 image = texture(uFabric, vUv * uUvLength / uFabricSize).rgb;
  if (uHasUv && uShading == 0) base = image;
#endif
  vec3 inSet = mix(vFace.rgb, vec3(0.64), 0.26);
  if (uShading == FACE_SETS) base = flags >= 128 ? inSet : vec3(0.70, 0.70, 0.71);
  if (uShading == CHECKER) base = checker();
  if (uShading == VALUES && uHasValues) base = heat(clamp(vValue, 0.0, 1.0));
  if ((flags & 64) != 0) base = mix(base, uAccent, 0.55);
  return base;
}

#ifdef SHADOWS
${SHADOW_CODE}#endif
// Near a fold the smooth normal belongs to neither side, so the face's own takes over.
vec3 facing(vec3 own, bool front) {
  vec3 smoothed = normalize(vNormal) * uHanded * (front ? 1.0 : -1.0);
  float agree = dot(own, smoothed);
  return agree != agree ? own : normalize(mix(own, smoothed, smoothstep(0.25, 0.65, agree)));
}

#ifdef RELIEF
// The normal with the relief, and in the fourth number its height from 0 to 1.
vec4 embossed(vec3 n, vec3 dx, vec3 dy) {
  vec4 map = texture(uRelief, vUv * uUvLength / uReliefSize);
  vec2 ux = dFdx(vUv);
  vec2 uy = dFdy(vUv);
  float way = sign(ux.x * uy.y - ux.y * uy.x);
  if (!uHasUv || uShading != 0 || way == 0.0) return vec4(n, 0.5);
  vec3 u = normalize(dx * uy.y - dy * ux.y) * way;
  vec3 v = normalize(dy * ux.x - dx * uy.x) * way;
  vec3 bent = map.xyz * 2.0 - 1.0;
  return vec4(normalize(bent.x * u + bent.y * v + bent.z * n), uHasHeights ? map.a : 0.5);
}
#endif

vec3 lit(vec3 base, bool front) {
  vec3 dx = dFdx(vView);
  vec3 dy = dFdy(vView);
  vec3 own = normalize(cross(dx, dy));
  vec3 smoothed = facing(own, front);
#ifdef RELIEF
  vec4 bent = embossed(smoothed, dx, dy);
#else
  vec4 bent = vec4(smoothed, 0.5);
#endif
  vec3 n = bent.xyz;
  float rough = uShading > 0 ? ${ROUGHNESS} : (uRoughness < 0.0 ? ownRoughness() : uRoughness);
  vec3 v = normalize(-vView);
  vec3 albedo = sRGBTransferEOTF(vec4(base, 1.0)).rgb;
  vec3 key = normalize(vec3(-0.52, 0.60, 0.60));
  vec3 fill = normalize(vec3(0.85, 0.1, 0.45));
  float hollow = vCurvature * uHanded * (front ? 1.0 : -1.0) * uSize;
  // The peaks of curvature at the loops of a coarse cage would be bands on flat cloth.
  hollow *= smoothstep(0.25, 1.4, abs(hollow));
  float cavity = hollow > 0.0 ? 1.0 - 0.62 * (1.0 - exp(-0.55 * hollow)) : 1.0 + 0.10 * (1.0 - exp(0.5 * hollow));
  float sky = 0.5 + 0.5 * dot(n, uUp);
  vec3 ambient = mix(vec3(0.150, 0.140, 0.135), vec3(0.40, 0.43, 0.48), sky * sky);
  float wrap = max(0.0, (dot(n, key) + 0.28) / 1.28);
  vec3 light = ambient + vec3(1.02, 0.98, 0.92) * wrap * wrap * 1.12;
  light += vec3(0.60, 0.68, 0.80) * max(0.0, dot(n, fill)) * 0.13;
  float grazing = pow(1.0 - clamp(dot(n, v), 0.0, 1.0), 3.0);
  vec3 sheen = (0.35 + 0.65 * albedo) * grazing * (0.10 + 0.34 * sky) * vec3(0.92, 0.97, 1.06);
  sheen *= 0.4 + 0.6 * smoothstep(0.0, 0.8, rough);
  vec3 shine = vec3(0.035 * exp2(4.5 * (0.8 - rough))) * pow(max(0.0, dot(n, normalize(key + v))), exp2(7.65 - 4.35 * rough));
  // The back is a darker shade of the same cloth.
  float inside = front ? 1.0 : 0.66;
  vec3 c = (albedo * light + (front ? sheen : sheen * 0.3) + shine) * cavity * inside * (0.7 + 0.6 * bent.w);
  c *= 1.0 - 0.30 * pow(grazing, 3.0);
  vec3 shown = sRGBTransferOETF(vec4(c / (1.0 + 0.16 * c * c), 1.0)).rgb;
#ifdef SHADOWS
  // Inside a sleeve all light is held off, and hems there would be black.
  shown *= 1.0 - (front ? 1.0 : 0.6) * shadow(smoothed, own);
#endif
  return shown;
}

// Distance to the three edges, in pixels of the screen.
vec3 distances() {
  vec3 b = vBary.zxy;
  vec3 dx = dFdx(b);
  vec3 dy = dFdy(b);
  return b / max(sqrt(dx * dx + dy * dy), vec3(1e-9));
}

float cover(float distance, float width) {
  return clamp(width * 0.5 - distance / uPixel + 0.5, 0.0, 1.0);
}

float over(float distance, uint edge, float width) {
  return cover(distance, (edge & ${BORDER}u) != 0u ? width * 1.6 : width);
}

struct Lines {
  float wire;
  float halo;
};

void addLine(inout Lines lines, float distance, uint edge) {
  uint kind = edge & ${BORDER - 1}u;
  if (kind == 0u) return;
  lines.wire = max(lines.wire, over(distance, edge, 0.9));
  if (kind > 1u && (uEdgeSets || kind == 2u)) lines.halo = max(lines.halo, cover(distance, 4.6));
}

Lines linesHere(vec3 d) {
  Lines lines = Lines(0.0, 0.0);
  addLine(lines, d.x, vEdges.x);
  addLine(lines, d.y, vEdges.y);
  addLine(lines, d.z, vEdges.z);
  return lines;
}

vec4 blend(vec4 below, vec3 line, float alpha) {
  float sum = alpha + below.a * (1.0 - alpha);
  return vec4(mix(below.rgb, line, alpha / max(sum, 1e-4)), sum);
}

// Triangles of a few pixels would be all wire.
float room() {
  vec3 dx = dFdx(vBary);
  vec3 dy = dFdy(vBary);
  vec3 heights = inversesqrt(max(dx * dx + dy * dy, vec3(1e-12)));
  float least = min(heights.x, min(heights.y, heights.z)) / uPixel;
  return smoothstep(2.0, 9.0, least);
}

vec4 withLines(vec4 c, bool front) {
  Lines lines = linesHere(distances());
  vec3 wire = uOverlay ? uWireColour : c.rgb * 0.42;
  float strength = uOverlay ? (front ? 0.85 : 0.3) * mix(0.2, 1.0, room()) : 0.62 * room();
  if (uWires || uOverlay) c = blend(c, wire, lines.wire * strength);
  if (!uOverlay) c.rgb *= 1.0 - 0.24 * lines.halo * room();
  return c;
}

#ifdef DEPTH
void main() {
  colour = vec4(1.0);
}
#elif defined(PICK)
void main() {
  uint number = vNumber + 1u;
  colour = vec4(number & 255u, (number >> 8) & 255u, (number >> 16) & 255u, 255u) / 255.0;
}
#else
void main() {
  bool front = uFlat || (gl_FrontFacing == (uHanded > 0.0));
  if (uOverlay) {
    colour = withLines(vec4(uWireColour, 0.0), front);
    return;
  }
  vec3 base = surface();
  colour = withLines(vec4(uFlat ? base : lit(base, front), 1.0), front);
}
#endif
`;
