"""MaterialX's own film GLSL, put together to run in WebGL2, from the library that the installed package carries."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

# What MaterialX's generator defines before its library. The arc tangent takes -0 as 0: SwiftShader and others disagree
# on which side of the cut -0 lies, and p then goes into anti-phase.
_PRELUDE = """
precision highp float;
#define M_PI 3.1415926535897932
#define M_FLOAT_EPS 1e-6
#define AIRY_FRESNEL_ITERATIONS 2
float mx_square(float x) { return x * x; }
vec2 mx_square(vec2 x) { return x * x; }
vec3 mx_square(vec3 x) { return x * x; }
float mx_pow6(float x) { float y = x * x; return y * y * y; }
#define mx_cos cos
#define mx_sin sin
float mx_atan(float x) { return atan(x); }
float side(float y) { return abs(y) < 1e-12 ? 1e-12 : y; }
vec3 mx_atan(vec3 y, vec3 x) { return vec3(atan(side(y.x), x.x), atan(side(y.y), x.y), atan(side(y.z), x.z)); }
vec3 mx_matrix_mul(mat3 m, vec3 v) { return m * v; }
"""


def source(materialx: Any) -> str:
    """The functions under `mx_fresnel_airy`, and the makers of its argument."""
    library = (
        Path(materialx.__file__).parent / "libraries" / "pbrlib" / "genglsl" / "lib" / "mx_microfacet_specular.glsl"
    )
    text = library.read_text()
    constants = re.findall(r"^const int FRESNEL_MODEL_\w+ = \d+;", text, flags=re.M)
    struct = re.search(r"^struct FresnelData\n\{.*?^\};", text, flags=re.S | re.M)
    wanted = (
        "mx_ior_to_f0", "mx_f0_to_ior", "mx_fresnel_hoffman_schlick", "mx_fresnel_dielectric_polarized",
        "mx_fresnel_conductor_polarized", "mx_fresnel_conductor_phase_polarized", "mx_eval_sensitivity", "mx_fresnel_airy",
        "mx_init_fresnel_dielectric", "mx_init_fresnel_conductor", "mx_init_fresnel_schlick",
    )  # fmt: skip
    functions = [
        found
        for name in wanted
        for found in re.findall(
            rf"^(?:float|vec2|vec3|void|FresnelData) {name}\([^)]*\)\n\{{.*?^\}}", text, flags=re.S | re.M
        )
    ]
    assert struct is not None and len(functions) >= len(wanted), "the library has changed"
    return "\n".join([_PRELUDE, *constants, struct[0], *functions])


RUN = """
(question) => {
  const gl = document.createElement("canvas").getContext("webgl2");
  gl.getExtension("EXT_color_buffer_float");
  const compile = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source); gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  };
  const answers = [];
  for (const call of question.calls) {
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, `#version 300 es
      in vec3 place; flat out vec2 p;
      void main() {
        p = place.xy; gl_PointSize = 1.0;
        gl_Position = vec4((place.z + 0.5) / ${question.count}.0 * 2.0 - 1.0, 0.0, 0.0, 1.0);
      }`));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, "#version 300 es\\n" + question.source +
      `\nflat in vec2 p; out vec4 c; void main() { c = vec4(${call}, 1.0); }`));
    gl.linkProgram(program); gl.useProgram(program);
    const target = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, target);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, question.count, 1, 0, gl.RGBA, gl.FLOAT, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(question.places), gl.STATIC_DRAW);
    const at = gl.getAttribLocation(program, "place");
    gl.enableVertexAttribArray(at); gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
    gl.viewport(0, 0, question.count, 1);
    gl.drawArrays(gl.POINTS, 0, question.count);
    const out = new Float32Array(question.count * 4);
    gl.readPixels(0, 0, question.count, 1, gl.RGBA, gl.FLOAT, out);
    answers.push(Array.from(out));
  }
  return answers;
}
"""
