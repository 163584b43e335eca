// Lines of a constant width on the screen, as quads from end to end with round ends.

/** `corner` is along (0 or 1) and across (-1 or 1). Sets the position, and what `lineReach` needs. */
export const LINE_QUAD = /* glsl */ `
uniform mat4 projectionMatrix;
uniform vec2 uView;
in vec2 corner;
out vec2 vAt;
out float vLength;

// Moves an end that is behind the eye to the near plane.
vec4 clipped(vec4 end, vec4 other) {
  if (projectionMatrix[3][3] != 0.0) return end;
  float near = -projectionMatrix[3][2] / (projectionMatrix[2][2] - 1.0);
  return end.z > near && other.z < near ? mix(end, other, (end.z - near) / (end.z - other.z)) : end;
}

void lineQuad(vec4 a, vec4 b, float radius) {
  vec4 p = projectionMatrix * clipped(a, b);
  vec4 q = projectionMatrix * clipped(b, a);
  vec2 s = p.xy / p.w * uView * 0.5;
  vec2 e = q.xy / q.w * uView * 0.5;
  float distance = length(e - s);
  vec2 along = distance > 1e-4 ? (e - s) / distance : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  bool first = corner.x < 0.5;
  vec4 end = first ? p : q;
  vec2 offset = along * (first ? -radius : radius) + across * corner.y * radius;
  vAt = vec2(first ? -radius : distance + radius, corner.y * radius);
  vLength = distance;
  gl_Position = vec4(end.xy + offset / (uView * 0.5) * end.w, end.z, end.w);
}
`;

/** Distance to the line in device pixels. */
export const LINE_REACH = /* glsl */ `
in vec2 vAt;
in float vLength;

float lineReach() {
  return length(vec2(vAt.x - clamp(vAt.x, 0.0, vLength), vAt.y));
}
`;
