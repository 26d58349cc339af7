// The colour of a film from its table of exact colours. HLSL, shader model 5 and later; made by iridesce @VERSION@.
//
// film: @STACK@
// light: @ILLUMINANT@; result: linear CIE 1931 XYZ, the perfect white has Y = 1; unpolarised
// error of the table, CIEDE2000: mean @MEAN@, p99 @P99@, max @MAX@ (above 20 nm)
//
// film_lut: @WIDTH@ x @HEIGHT@ texels, DXGI_FORMAT_R16G16B16A16_FLOAT, uploaded as stored (@TABLE@, first row first, no
// flip). The four texels are loaded and mixed here: no sampler is needed. Move the register to where it suits.
Texture2D<float4> film_lut : register(t0);

static const float FILM_THINNEST_NM = @LOW@;
static const float FILM_THICKEST_NM = @HIGH@;
static const float2 FILM_LAST_TEXEL = float2(@LAST_COLUMN@, @LAST_ROW@);

// thickness_nm is clamped to the range of the table, cos_theta (of the angle in the first medium) to 0..1.
float3 film_xyz(float thickness_nm, float cos_theta)
{
    float share = saturate((thickness_nm - FILM_THINNEST_NM) / (FILM_THICKEST_NM - FILM_THINNEST_NM));
    float2 place = float2(share, saturate(cos_theta)) * FILM_LAST_TEXEL;
    float2 corner = min(floor(place), FILM_LAST_TEXEL - 1.0);
    float2 between = place - corner;
    int3 texel = int3(int2(corner), 0);
    float3 top = lerp(film_lut.Load(texel).rgb, film_lut.Load(texel + int3(1, 0, 0)).rgb, between.x);
    float3 below = lerp(film_lut.Load(texel + int3(0, 1, 0)).rgb, film_lut.Load(texel + int3(1, 1, 0)).rgb, between.x);
    return lerp(top, below, between.y);
}
