// The one shader: thickness from the field, colour from the table (as look-up.ts, its twin), walls put together,
// exposure, hue-keeping gamut map, sRGB curve. It knows no film formula.
//
// It is compiled for what a picture asks of it. A processor that shades pixels side by side works out both ways of every branch
// and keeps one, so that a picture would pay for all that any picture may need.

/** What a picture may ask for; each is a name that the shader is compiled with or without. */
export const WAYS = [
  "FIELD", // walls hold places in a field of thickness, not thicknesses
  "REPEATS", // the field repeats downwards
  "PASSES", // the front wall lets light pass: there is one behind
  "DRAFT", // colours from the draft
  "ANSWER", // X, Y, Z instead of what a screen shows, the first row first
] as const;
export type Way = (typeof WAYS)[number];

export const VERTEX = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

export function fragment(ways: readonly Way[]): string {
  return `#version 300 es\n${ways.map((way) => `#define ${way}\n`).join("")}${FRAGMENT}`;
}

const FRAGMENT = `precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D front;    // place, angle in degrees (< 0: none), radiance
uniform sampler2D back;
uniform sampler2D behind;   // radiance, share covered by film
uniform sampler2D field;    // thickness in nm of a cell, the one after it, the one below, the one below and after
uniform sampler2D values;   // X, Y, Z at the nodes of the table
uniform sampler2D slopes;
uniform highp usampler2D draft; // for what moves: X, Y, Z of a node and of the next as six halves
uniform vec4 draft_axes;    // first reduced thickness, 1 / step; first angle, 1 / step
uniform ivec2 size;         // of the table: columns, rows
uniform vec4 axes;          // first reduced thickness, step; first angle, step
uniform vec4 limits;        // thickness from, to; angle from, to
uniform float inverse_square;
uniform vec3 white;
uniform vec3 over_white;    // 1 / white
uniform mat3 rgb_from_xyz;
uniform float exposure;
out vec4 color;

// One texel a place: fetches are most of what a picture costs where there is no graphics device.
float thickness_at(vec2 place) {
  ivec2 cells = textureSize(field, 0);
  place.x = fract(place.x);
#ifdef REPEATS
  place.y = fract(place.y);
#endif
  vec2 p = place * vec2(cells) - 0.5;
#ifndef REPEATS
  p.y = clamp(p.y, 0.0, float(cells.y - 1));
#endif
  vec2 low = floor(p);
  vec2 f = p - low;
  ivec2 cell = ivec2(low);
  if (cell.x < 0) cell.x += cells.x;
  if (cell.y < 0) cell.y += cells.y;
  vec4 corners = texelFetch(field, cell, 0);
  vec2 rows = mix(corners.xz, corners.yw, f.x);
  return mix(rows.x, rows.y, f.y);
}

// sin^2 of an angle in degrees from 0 to 90, by a polynomial: what a driver's own sine is worth is not said anywhere.
float sin_squared(float degrees) {
  float x = degrees * 0.017453292519943295;
  bool large = x > 0.7853981633974483;
  if (large) x = 1.5707963267948966 - x;
  float y = x * x;
  float s = x * (1.0 + y * (-0.16666666667 + y * (0.00833333333 + y * (-0.000198412698 + y * 2.7557319e-6))));
  return large ? 1.0 - s * s : s * s;
}

vec3 film(float nm, float degrees) {
  float angle = clamp(degrees, limits.z, limits.w);
  float v = clamp(nm, limits.x, limits.y) * sqrt(1.0 - sin_squared(angle) * inverse_square);
#ifdef DRAFT
  ivec2 last = textureSize(draft, 0) - 1;
  float p = clamp((v - draft_axes.x) * draft_axes.y, 0.0, float(last.x));
  float low = floor(p);
  uvec4 six = texelFetch(draft, ivec2(int(low), min(int((angle - draft_axes.z) * draft_axes.w + 0.5), last.y)), 0);
  vec2 middle = unpackHalf2x16(six.y);
  return mix(vec3(unpackHalf2x16(six.x), middle.x), vec3(middle.y, unpackHalf2x16(six.z)), p - low);
#else
  float p = max((v - axes.x) / axes.y, 0.0);
  int column = int(min(floor(p), float(size.x - 2)));
  float f = p - float(column);
  float g = 1.0 - f;
  vec4 along = vec4((f * 2.0 + 1.0) * g * g, f * g * g, f * f * (3.0 - 2.0 * f), -(f * f * g));
  int row = 0;
  vec4 across = vec4(1.0, 0.0, 0.0, 0.0);
  if (size.y > 1) {
    float y = (angle - axes.z) / axes.w;
    row = int(clamp(floor(y) - 1.0, 0.0, float(size.y - 4)));
    float a = y - float(row);
    float b = a - 1.0, c = a - 2.0, d = a - 3.0;
    across = vec4(b * c * d / -6.0, a * c * d / 2.0, a * b * d / -2.0, a * b * c / 6.0);
  }
  vec3 sum = vec3(0.0);
  int rows = size.y > 1 ? 4 : 1;
  for (int k = 0; k < rows; k++) {
    ivec2 here = ivec2(column, row + k);
    ivec2 next = here + ivec2(1, 0);
    sum += across[k] * (along.x * texelFetch(values, here, 0).xyz + along.y * texelFetch(slopes, here, 0).xyz
      + along.z * texelFetch(values, next, 0).xyz + along.w * texelFetch(slopes, next, 0).xyz);
  }
  return sum;
#endif
}

vec3 wall(vec4 w) {
#ifdef FIELD
  return film(thickness_at(w.xy), w.z);
#else
  return film(w.x, w.z);
#endif
}

// The sRGB curve of 0 to 1 to 0.01 of a step of eight bits, by roots: x^(1/2.4) itself takes a logarithm and a power.
// The numbers are a least-squares fit of 1.055 x^(1/2.4) - 0.055 over 0.0031308 to 1, its largest error weighed down.
vec3 curve(vec3 x) {
  vec3 s = sqrt(x);
  vec3 q = sqrt(s);
  vec3 high = 0.6539859249 * s + 0.6887108621 * q - 0.3184722845 * sqrt(q) - 0.0201880726 * x - 0.0040677372;
  return mix(high, 12.92 * x, vec3(lessThanEqual(x, vec3(0.0031308))));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
#ifndef ANSWER
  // The first row of the pixels is at the bottom of the screen.
  pixel.y = textureSize(front, 0).y - 1 - pixel.y;
#endif
  vec4 near = texelFetch(front, pixel, 0);
  vec2 rest = texelFetch(behind, pixel, 0).xy;
  vec3 xyz = white * rest.x;
  if (near.z >= 0.0) {
    vec3 mirrored = wall(near);
    vec3 seen = mirrored * near.w;
#ifdef PASSES
    vec3 through = 1.0 - mirrored * over_white;
    vec4 far = texelFetch(back, pixel, 0);
    vec3 beyond = white * rest.x;
    if (far.z >= 0.0) {
      vec3 inner = wall(far);
      beyond = beyond * (1.0 - inner * over_white) + inner * through * far.w;
    }
    seen += beyond * through;
#endif
    xyz = mix(xyz, seen, rest.y);
  }
#ifdef ANSWER
  color = vec4(xyz, 1.0);
#else
  vec3 rgb = rgb_from_xyz * xyz * exposure;
  float luminance = clamp(xyz.y * exposure, 0.0, 1.0);
  // Towards the grey of the same luminance until all fit: hue stays.
  float least = min(rgb.x, min(rgb.y, rgb.z));
  if (least < 0.0) rgb = luminance + (rgb - luminance) * luminance / max(luminance - least, 1e-9);
  float most = max(rgb.x, max(rgb.y, rgb.z));
  if (most > 1.0) rgb = luminance + (rgb - luminance) * (1.0 - luminance) / max(most - luminance, 1e-9);
  rgb = clamp(rgb, 0.0, 1.0);
  color = vec4(curve(rgb), 1.0);
#endif
}`;
