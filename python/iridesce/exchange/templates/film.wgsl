// The colour of a film from its table of exact colours. WGSL; made by iridesce @VERSION@.
//
// film: @STACK@
// light: @ILLUMINANT@; result: linear CIE 1931 XYZ, the perfect white has Y = 1; unpolarised
// error of the table, CIEDE2000: mean @MEAN@, p99 @P99@, max @MAX@ (above 20 nm)
//
// film_lut: @WIDTH@ x @HEIGHT@ texels, rgba16float, uploaded as stored (@TABLE@, first row first, no flip). The four texels
// are loaded and mixed here: no sampler is needed. Move group and binding to where they suit.
@group(0) @binding(0) var film_lut: texture_2d<f32>;

const FILM_THINNEST_NM: f32 = @LOW@;
const FILM_THICKEST_NM: f32 = @HIGH@;
const FILM_LAST_TEXEL: vec2<f32> = vec2<f32>(@LAST_COLUMN@, @LAST_ROW@);

// thickness_nm is clamped to the range of the table, cos_theta (of the angle in the first medium) to 0..1.
fn film_xyz(thickness_nm: f32, cos_theta: f32) -> vec3<f32> {
    let share = clamp((thickness_nm - FILM_THINNEST_NM) / (FILM_THICKEST_NM - FILM_THINNEST_NM), 0.0, 1.0);
    let place = vec2<f32>(share, clamp(cos_theta, 0.0, 1.0)) * FILM_LAST_TEXEL;
    let corner = min(floor(place), FILM_LAST_TEXEL - vec2<f32>(1.0, 1.0));
    let between = place - corner;
    let texel = vec2<i32>(corner);
    let top = mix(textureLoad(film_lut, texel, 0).rgb, textureLoad(film_lut, texel + vec2<i32>(1, 0), 0).rgb, between.x);
    let below = mix(textureLoad(film_lut, texel + vec2<i32>(0, 1), 0).rgb, textureLoad(film_lut, texel + vec2<i32>(1, 1), 0).rgb, between.x);
    return mix(top, below, between.y);
}
