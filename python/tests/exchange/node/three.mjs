// Loads glTF files with three.js and runs three.js's own film shader on a chart of each. Question:
// {chromium, folder, files: [name, ...], thickness_nm: [...], cosine: [...]}; answer: per file material values and RGB.
import { createRequire } from "node:module";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { join, extname } from "node:path";

const modules = process.argv[2];
const { chromium } = createRequire(join(modules, "x.js"))("playwright-core");
const question = JSON.parse(readFileSync(0, "utf8"));
const html = `<!doctype html><script type="importmap">{"imports": {
  "three": "/node_modules/three/build/three.module.js", "three/addons/": "/node_modules/three/examples/jsm/"}}</script>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
window.run = async (question) => {
  const answers = [];
  for (const file of question.files) {
    const gltf = await new GLTFLoader().loadAsync("/" + file);
    let material = null;
    gltf.scene.traverse((node) => { if (node.isMesh && node.material.iridescence > 0) material ??= node.material; });
    const range = [material.iridescenceThicknessMinimum ?? material.iridescenceThicknessRange[0],
                   material.iridescenceThicknessMaximum ?? material.iridescenceThicknessRange[1]];
    // What three.js takes as reflectance of the base at normal incidence (its lights_physical_fragment).
    const dielectric = Math.min(Math.pow((material.ior - 1) / (material.ior + 1), 2), 1);
    const f0 = material.color.toArray().map((c) => dielectric + (c - dielectric) * material.metalness);
    const count = question.thickness_nm.length;
    const renderer = new THREE.WebGLRenderer();
    const target = new THREE.WebGLRenderTarget(count, 1, { type: THREE.FloatType });
    const data = new Float32Array(count * 4);
    for (let i = 0; i < count; i++) { data[4 * i] = question.thickness_nm[i]; data[4 * i + 1] = question.cosine[i]; }
    const places = new THREE.DataTexture(data, count, 1, THREE.RGBAFormat, THREE.FloatType);
    places.needsUpdate = true;
    const shader = new THREE.ShaderMaterial({
      defines: { USE_IRIDESCENCE: "" },
      uniforms: { places: { value: places }, ior: { value: material.iridescenceIOR }, f0: { value: new THREE.Vector3(...f0) } },
      vertexShader: "void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }",
      fragmentShader: "#include <common>\\n" + THREE.ShaderChunk.iridescence_fragment + \`
        uniform sampler2D places; uniform float ior; uniform vec3 f0;
        void main() {
          vec4 place = texelFetch(places, ivec2(gl_FragCoord.xy), 0);
          gl_FragColor = vec4(evalIridescence(1.0, ior, place.y, place.x, f0), 1.0);
        }\`,
    });
    const scene = new THREE.Scene();
    scene.add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), shader));
    renderer.setRenderTarget(target);
    renderer.render(scene, new THREE.Camera());
    const out = new Float32Array(count * 4);
    renderer.readRenderTargetPixels(target, 0, 0, count, 1, out);
    const map = material.iridescenceThicknessMap;
    answers.push({ range, ior: material.iridescenceIOR, f0, transmission: material.transmission, metalness: material.metalness,
      flipY: map ? map.flipY : null, colorSpace: map ? map.colorSpace : null, rgb: Array.from(out) });
    renderer.dispose();
  }
  return { revision: THREE.REVISION, answers };
};
window.ready = true;
</script>`;
const types = { ".js": "text/javascript", ".json": "application/json", ".png": "image/png", ".gltf": "model/gltf+json" };
const server = createServer((request, response) => {
  const path = decodeURIComponent(request.url.split("?")[0]);
  try {
    const file = path.startsWith("/node_modules/") ? join(modules, path.slice(14)) : join(question.folder, path);
    const body = path === "/" ? html : readFileSync(file);
    response.writeHead(200, { "content-type": path === "/" ? "text/html" : types[extname(path)] ?? "application/octet-stream" });
    response.end(body);
  } catch { response.writeHead(404).end(); }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const profile = mkdtempSync(join(tmpdir(), "iridesce-"));
const browser = await chromium.launchPersistentContext(profile, {
  executablePath: question.chromium, headless: true, args: ["--no-sandbox", "--disable-quic", "--no-first-run"],
});
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(300000);
  const said = [];
  page.on("console", (message) => said.push(message.text()));
  page.on("pageerror", (error) => said.push(String(error)));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await page.waitForFunction("window.ready", null, { timeout: 300000 }).catch(() => { throw new Error(said.join("\n")); });
  const answer = await page.evaluate((q) => window.run(q), question).catch((error) => { throw new Error(error + said.join("\n")); });
  process.stdout.write(JSON.stringify(answer));
} finally {
  await browser.close();
  server.close();
  rmSync(profile, { recursive: true, force: true });
}
