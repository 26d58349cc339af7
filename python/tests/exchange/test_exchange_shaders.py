"""The shader texts compile in real compilers, and answer what the table holds: right thickness, right angle, right way up."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest
import readers

import iridesce as ir
from iridesce.exchange import lut

RANGE_NM = (0.0, 1200.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("shader")
    ir.export("air / soap ? / air", "shader", path, vary=RANGE_NM)
    return path


@pytest.fixture(scope="module")
def table(folder: Path) -> lut.Lut:
    read = lut.read((folder / "film_reflectance.exr").read_bytes(), "x.exr")
    assert read is not None
    return read


def places() -> tuple[np.ndarray, np.ndarray]:
    """Thicknesses and cosines: the corners, points beyond the range, and some in between."""
    draws = np.random.default_rng(5).random((2, 120))
    corners = np.array([[0, 0, 1, 1, -0.5, 1.5, 0.3, 0.3], [0, 1, 0, 1, 0.5, 0.5, -0.2, 1.2]])
    both = np.concatenate([corners, draws], axis=1)
    return RANGE_NM[1] * both[0], both[1]


def glslang(text: str, ending: str, *options: str, tmp_path: Path) -> subprocess.CompletedProcess[str]:
    file = tmp_path / f"test.{ending}"
    file.write_text(text)
    command = [readers.program("glslangValidator"), *options, str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)


def test_glslang_compiles_the_glsl(folder: Path, tmp_path: Path) -> None:
    body = "in vec2 p; out vec4 c; void main() { c = vec4(film_xyz(p.x, p.y), 1.0); }\n"
    text = "#version 300 es\n" + (folder / "film.glsl").read_text() + body
    finished = glslang(text, "frag", tmp_path=tmp_path)
    assert finished.returncode == 0, finished.stdout
    assert glslang(text.replace("cos_theta,", "cosine,"), "frag", tmp_path=tmp_path).returncode != 0


def test_glslang_compiles_the_hlsl(folder: Path, tmp_path: Path) -> None:
    body = "float4 main(float2 p : TEXCOORD0) : SV_Target { return float4(film_xyz(p.x, p.y), 1.0); }\n"
    text = (folder / "film.hlsl").read_text() + body
    options = ("-D", "-V", "-S", "frag", "-e", "main", "-o", str(tmp_path / "out.spv"))
    finished = glslang(text, "hlsl", *options, tmp_path=tmp_path)
    assert finished.returncode == 0, finished.stdout
    assert glslang(text.replace("lerp(top", "lerb(top"), "hlsl", *options, tmp_path=tmp_path).returncode != 0


WEBGL = """
(question) => {
  const gl = document.createElement("canvas").getContext("webgl2");
  gl.getExtension("EXT_color_buffer_float");
  const bytes = Uint8Array.from(atob(question.texels), (c) => c.charCodeAt(0));
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, 512, 64, 0, gl.RGBA, gl.HALF_FLOAT, new Uint16Array(bytes.buffer));
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  const compile = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source); gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, `#version 300 es
    in vec3 place; flat out vec2 p;
    void main() {
      p = place.xy; gl_PointSize = 1.0;
      gl_Position = vec4((place.z + 0.5) / ${question.count}.0 * 2.0 - 1.0, 0.0, 0.0, 1.0);
    }`));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, "#version 300 es\\n" + question.source +
    "flat in vec2 p; out vec4 c; void main() { c = vec4(film_xyz(p.x, p.y), 1.0); }"));
  gl.linkProgram(program); gl.useProgram(program);
  const target = gl.createTexture();
  gl.activeTexture(gl.TEXTURE1); gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, question.count, 1, 0, gl.RGBA, gl.FLOAT, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.uniform1i(gl.getUniformLocation(program, "film_lut"), 0);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(question.places), gl.STATIC_DRAW);
  gl.enableVertexAttribArray(0); gl.vertexAttribPointer(gl.getAttribLocation(program, "place"), 3, gl.FLOAT, false, 0, 0);
  gl.viewport(0, 0, question.count, 1);
  gl.drawArrays(gl.POINTS, 0, question.count);
  const out = new Float32Array(question.count * 4);
  gl.readPixels(0, 0, question.count, 1, gl.RGBA, gl.FLOAT, out);
  if (gl.getError()) throw new Error("WebGL error");
  return Array.from(out);
}
"""

WEBGPU = """
async (question) => {
  const adapter = await navigator.gpu.requestAdapter();
  if (!adapter) return null;
  const device = await adapter.requestDevice();
  const bytes = Uint8Array.from(atob(question.texels), (c) => c.charCodeAt(0));
  const texture = device.createTexture({ size: [512, 64], format: "rgba16float", usage: 4 | 2 });
  device.queue.writeTexture({ texture }, bytes, { bytesPerRow: 512 * 8 }, [512, 64]);
  const code = question.source + `
    @group(0) @binding(1) var<storage, read> places: array<vec2<f32>>;
    @group(0) @binding(2) var<storage, read_write> answers: array<vec4<f32>>;
    @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
      answers[id.x] = vec4<f32>(film_xyz(places[id.x].x, places[id.x].y), 1.0);
    }`;
  const module = device.createShaderModule({ code });
  const messages = (await module.getCompilationInfo()).messages.filter((m) => m.type === "error").map((m) => m.message);
  if (messages.length) throw new Error(messages.join("; "));
  const pipeline = device.createComputePipeline({ layout: "auto", compute: { module, entryPoint: "main" } });
  const flat = new Float32Array(question.count * 2);
  for (let i = 0; i < question.count; i++) { flat[2 * i] = question.places[3 * i]; flat[2 * i + 1] = question.places[3 * i + 1]; }
  const input = device.createBuffer({ size: flat.byteLength, usage: 128 | 8 });
  device.queue.writeBuffer(input, 0, flat);
  const output = device.createBuffer({ size: question.count * 16, usage: 128 | 4 });
  const back = device.createBuffer({ size: question.count * 16, usage: 1 | 8 });
  const group = device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: [
    { binding: 0, resource: texture.createView() },
    { binding: 1, resource: { buffer: input } },
    { binding: 2, resource: { buffer: output } } ] });
  const encoder = device.createCommandEncoder();
  const pass = encoder.beginComputePass();
  pass.setPipeline(pipeline); pass.setBindGroup(0, group); pass.dispatchWorkgroups(question.count); pass.end();
  encoder.copyBufferToBuffer(output, 0, back, 0, question.count * 16);
  device.queue.submit([encoder.finish()]);
  await back.mapAsync(1);
  return Array.from(new Float32Array(back.getMappedRange()));
}
"""


def ask(call: str, source: str, texels: bytes, flags: list[str]) -> np.ndarray | None:
    import base64

    thickness, cosine = places()
    flat = np.stack([thickness, cosine, np.arange(len(cosine), dtype=float)], axis=1).reshape(-1)
    argument = {
        "source": source,
        "texels": base64.b64encode(texels).decode("ascii"),
        "places": flat.tolist(),
        "count": len(cosine),
    }
    question = {"chromium": readers.chromium(), "flags": flags, "call": call, "argument": argument}
    answer = readers.node("browser.mjs", question)["answer"]
    return None if answer is None else np.array(answer).reshape(-1, 4)[:, :3]


def marked(folder: Path) -> tuple[bytes, np.ndarray]:
    """The table with one corner marked: thin and grazing, the first texel stored."""
    texels = np.frombuffer((folder / "film_reflectance.rgba16f").read_bytes(), "<f2").reshape(64, 512, 4).copy()
    texels[0, 0] = (0.75, 0.5, 0.25, 1.0)
    return texels.tobytes(), texels[..., :3].astype(np.float64)


@pytest.mark.parametrize(
    ("name", "call", "flags"),
    [("film.glsl", WEBGL, []), ("film.wgsl", WEBGPU, ["--enable-unsafe-webgpu"])],
    ids=["GLSL in WebGL2", "WGSL in WebGPU"],
)
def test_a_browser_runs_it_the_right_way_up(
    folder: Path, table: lut.Lut, name: str, call: str, flags: list[str]
) -> None:
    texels, xyz = marked(folder)
    seen = ask(call, (folder / name).read_text(), texels, flags)
    if seen is None:
        readers.absent("a WebGPU adapter")
    assert seen is not None
    thickness, cosine = places()
    wanted = lut.Lut(xyz, table.range_nm, "", "", "").sample(thickness, cosine)
    assert np.abs(seen - wanted).max() < 2e-5  # single precision: 24 bits of 512 columns leave 2e-5 of a texel
    assert seen[0].tolist() == [0.75, 0.5, 0.25], "thin and grazing is the first texel stored"
    # Each of the three ways to hold it wrong would have been seen.
    for wrong in (xyz[::-1], xyz[:, ::-1], xyz[..., ::-1]):
        assert np.abs(seen - lut.Lut(wrong, table.range_nm, "", "", "").sample(thickness, cosine)).max() > 0.1


def test_the_raw_table_is_the_exr(folder: Path, table: lut.Lut) -> None:
    texels = np.frombuffer((folder / "film_reflectance.rgba16f").read_bytes(), "<f2").reshape(64, 512, 4)
    assert np.array_equal(texels[..., :3].astype(np.float64), table.xyz) and (texels[..., 3] == 1.0).all()


@pytest.mark.parametrize("language", ["glsl", "wgsl", "hlsl", "osl"])
def test_every_word_of_a_template_is_filled_in(folder: Path, language: str) -> None:
    text = (folder / f"film.{language}").read_text()
    assert "@STACK@" not in text and not [
        word for word in text.split() if word.strip("(),;").startswith("@") and "@" in word[1:]
    ]
    assert "air / soap ? / air" in text and "1200.0" in text
