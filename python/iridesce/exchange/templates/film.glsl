// The colour of a film from its table of exact colours. GLSL ES 3.00 and later; made by iridesce @VERSION@.
//
// film: @STACK@
// light: @ILLUMINANT@; result: linear CIE 1931 XYZ, the perfect white has Y = 1; unpolarised
// error of the table, CIEDE2000: mean @MEAN@, p99 @P99@, max @MAX@ (above 20 nm)
//
// film_lut: @WIDTH@ x @HEIGHT@ texels, RGBA16F, uploaded as stored (@TABLE@, first row first, no flip). The four texels
// are fetched and mixed here, so that filter, wrap mode and mip-maps of the texture do not matter.
precision highp float;
precision highp int;
precision highp sampler2D;

uniform sampler2D film_lut;

const float FILM_THINNEST_NM = @LOW@;
const float FILM_THICKEST_NM = @HIGH@;
const vec2 FILM_LAST_TEXEL = vec2(@LAST_COLUMN@, @LAST_ROW@);

// thickness_nm is clamped to the range of the table, cos_theta (of the angle in the first medium) to 0..1.
vec3 film_xyz(float thickness_nm, float cos_theta) {
    float share = clamp((thickness_nm - FILM_THINNEST_NM) / (FILM_THICKEST_NM - FILM_THINNEST_NM), 0.0, 1.0);
    vec2 place = vec2(share, clamp(cos_theta, 0.0, 1.0)) * FILM_LAST_TEXEL;
    vec2 corner = min(floor(place), FILM_LAST_TEXEL - 1.0);
    vec2 between = place - corner;
    ivec2 texel = ivec2(corner);
    vec3 top = mix(texelFetch(film_lut, texel, 0).rgb, texelFetch(film_lut, texel + ivec2(1, 0), 0).rgb, between.x);
    vec3 below = mix(texelFetch(film_lut, texel + ivec2(0, 1), 0).rgb, texelFetch(film_lut, texel + ivec2(1, 1), 0).rgb, between.x);
    return mix(top, below, between.y);
}
