"use strict";
// What the graphics card does: each Gaussian as a quad, and then the ground beneath them all.

const WIDTH = 4096;

const VERTEX = `#version 300 es
precision highp float; precision highp int; precision highp usampler2D;
uniform usampler2D means, colors, quats, log_scales, opacity_logits;
// Of each value in the first window, then in the second one.
uniform int start[10], first[10], moments[10]; uniform bool exact[10]; uniform vec4 weights[10], low[10], span[10];
uniform int split; uniform float fades[2];
uniform mat3 turn; uniform vec3 shift;
uniform vec4 lens; uniform vec4 limits; uniform vec2 size; uniform float near; uniform bool antialiased;
// Planes beyond which nothing is drawn, in the camera's coordinates.
uniform bool bounded; uniform vec4 sides[4];
// More of them, of which those two count that are nearest to a Gaussian.
uniform int corners; uniform vec4 field[96];
in uint splat;
out vec2 place, inside_field; out vec4 color, inside;
int later, own;
vec4 at(usampler2D values, int name) {
  vec4 sum = vec4(0.0);
  int which = 5 * later + name;
  for (int tap = 0; tap < 4; tap++) {
    if (weights[which][tap] == 0.0) continue;
    int index = start[which] + own * moments[which] + min(first[which] + tap, moments[which] - 1);
    uvec4 held = texelFetch(values, ivec2(index % ${WIDTH}, index / ${WIDTH}), 0);
    sum += weights[which][tap] * (exact[which] ? uintBitsToFloat(held) : vec4(held));
  }
  return low[which] + sum * span[which];
}
void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0); place = vec2(0.0); color = vec4(0.0); inside = vec4(1e6); inside_field = vec2(1e6);
  later = int(splat) < split ? 0 : 1;
  own = int(splat) - later * split;
  vec3 local = turn * at(means, 0).xyz + shift;
  if (local.z <= near) return;
  vec4 q = normalize(at(quats, 2));
  vec3 scale = exp(at(log_scales, 3).xyz);
  float opacity = fades[later] / (1.0 + exp(-at(opacity_logits, 4).x));
  mat3 rotation = mat3(
    1.0 - 2.0 * (q.z * q.z + q.w * q.w), 2.0 * (q.y * q.z + q.x * q.w), 2.0 * (q.y * q.w - q.x * q.z),
    2.0 * (q.y * q.z - q.x * q.w), 1.0 - 2.0 * (q.y * q.y + q.w * q.w), 2.0 * (q.z * q.w + q.x * q.y),
    2.0 * (q.y * q.w + q.x * q.z), 2.0 * (q.z * q.w - q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
  mat3 axes = turn * rotation * mat3(scale.x, 0, 0, 0, scale.y, 0, 0, 0, scale.z);
  vec2 slope = clamp(local.xy / local.z, limits.xz, limits.yw);
  vec3 across = lens.x / local.z * (vec3(axes[0].x, axes[1].x, axes[2].x) - slope.x * vec3(axes[0].z, axes[1].z, axes[2].z));
  vec3 down = lens.y / local.z * (vec3(axes[0].y, axes[1].y, axes[2].y) - slope.y * vec3(axes[0].z, axes[1].z, axes[2].z));
  float xx = dot(across, across) + 0.3, yy = dot(down, down) + 0.3, xy = dot(across, down);
  vec3 minors = cross(across, down);
  float sharp = dot(minors, minors), determinant = sharp + 0.3 * (xx + yy - 0.3);
  if (antialiased) opacity *= sqrt(sharp / determinant);
  if (opacity < 1.0 / 255.0) return;
  float middle = 0.5 * (xx + yy), apart = length(vec2(0.5 * (xx - yy), xy));
  float longer = middle + apart, shorter = max(middle - apart, 0.3);
  vec2 axis = apart < 1e-6 ? vec2(1.0, 0.0) : normalize(xx >= yy ? vec2(longer - yy, xy) : vec2(xy, longer - xx));
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  place = corner * sqrt(2.0 * log(255.0 * opacity));
  vec2 centre = lens.xy * local.xy / local.z + lens.zw;
  vec2 pixel = centre + place.x * sqrt(longer) * axis + place.y * sqrt(shorter) * vec2(-axis.y, axis.x);
  ivec2 nearest = ivec2(0); vec2 least = vec2(3e38);
  for (int side = 0; side < corners; side++) {
    float distance = dot(field[side].xyz, local) + field[side].w;
    if (distance < least.x) { least = vec2(distance, least.x); nearest = ivec2(side, nearest.x); }
    else if (distance < least.y) { least.y = distance; nearest.y = side; }
  }
  // Pixels to the line where each plane cuts it: of the likeliest point behind a pixel.
  for (int side = 0; bounded && side < (corners > 1 ? 6 : 4); side++) {
    vec4 plane = side < 4 ? sides[side] : field[nearest[side - 4]];
    vec3 normal = plane.xyz * axes;
    vec2 along = vec2(dot(across, normal), dot(down, normal));
    vec2 slope = vec2(yy * along.x - xy * along.y, xx * along.y - xy * along.x) / determinant;
    float distance = dot(plane.xyz, local) + plane.w + dot(slope, pixel - centre);
    float apart = clamp(distance / max(length(slope), 1e-20), -1e6, 1e6);
    if (side < 4) inside[side] = apart; else inside_field[side - 4] = apart;
  }
  gl_Position = vec4(pixel.x / size.x * 2.0 - 1.0, 1.0 - pixel.y / size.y * 2.0, 0.0, 1.0);
  color = vec4(at(colors, 1).xyz, opacity);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec2 place, inside_field; in vec4 color, inside; out vec4 seen;
void main() {
  float image = min(min(inside.x, inside.y), min(inside.z, inside.w)), view = min(inside_field.x, inside_field.y);
  float within = min(image, view) + 0.5;
  float alpha = min(color.a * exp(-0.5 * dot(place, place)), 0.99) * clamp(within, 0.0, 1.0);
  if (alpha < 1.0 / 255.0) discard;
  seen = vec4(color.rgb * alpha, alpha);
}`;

const WHOLE = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;

// Of each pixel, the mean over those of its row that are at most `closing` away.
const ROWS = `#version 300 es
precision highp float; uniform sampler2D drawn; uniform int closing; out vec4 mean;
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  int first = max(place.x - closing, 0), last = min(place.x + closing, textureSize(drawn, 0).x - 1);
  mean = vec4(0.0);
  for (int x = first; x <= last; x++) mean += texelFetch(drawn, ivec2(x, place.y), 0);
  mean /= float(last - first + 1);
}`;

const RESOLVE = `#version 300 es
precision highp float; uniform sampler2D drawn, rows; uniform int closing; uniform float ground; out vec4 shown;
// With small gaps closed: tissue is opaque, and what shows through it has the colour of the tissue around.
vec4 closed(vec4 seen, ivec2 place) {
  int first = max(place.y - closing, 0), last = min(place.y + closing, textureSize(rows, 0).y - 1);
  vec4 mean = vec4(0.0);
  for (int y = first; y <= last; y++) mean += texelFetch(rows, ivec2(place.x, y), 0);
  mean /= float(last - first + 1);
  if (mean.a <= 0.3) return vec4(0.0);
  return smoothstep(0.3, 0.7, mean.a) * vec4(seen.rgb + (1.0 - seen.a) * mean.rgb / mean.a, 1.0);
}
void main() {
  ivec2 place = ivec2(gl_FragCoord.xy);
  vec4 seen = texelFetch(drawn, place, 0);
  if (closing > 0) seen = closed(seen, place);
  shown = vec4(clamp(seen.rgb + (1.0 - seen.a) * ground, 0.0, 1.0), 1.0);
}`;
