// The core in wasm against what the native core answered (tests/vectors.json, made by tools/vectors.py).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { openCore } from "../../tools/core.mjs";
import { foretold, pack } from "../../tools/tables.mjs";

const wasm = readFileSync(new URL("../../dist/iridesce.wasm", import.meta.url));
const vectors = JSON.parse(readFileSync(new URL("../vectors.json", import.meta.url), "utf8"));
const core = await openCore(wasm);

function thickest(stack) {
  return Math.max(0, ...stack.split(" / ").slice(1, -1).map((item) => Number(item.split(" ")[1])));
}

/** The rule: |dR| <= 4e-15 + 10 conditionings; for stacks up to 3 um 4e-15 R + 10 conditionings. `relative` is told, not asked. */
export function judge(rows, answer) {
  let [worst, worstThin, relative] = [0, 0, 0];
  for (const [stack, nm, deg, polarization, expected, conditioning] of rows) {
    const r = answer(stack, nm, deg, polarization);
    const miss = Math.abs(r - expected);
    if (miss === 0) continue;
    const layers = stack.split(" / ").length - 2;
    if (layers === 1 && thickest(stack) <= 3000 && expected > 1e-3) relative = Math.max(relative, miss / expected);
    worst = Math.max(worst, miss / (4e-15 + 10 * conditioning));
    if (thickest(stack) <= 3000) worstThin = Math.max(worstThin, miss / (4e-15 * expected + 10 * conditioning));
  }
  return { worst, worstThin, relative };
}

const reflectance = (stack, nm, deg, polarization) =>
  core.call("stack_spectrum", [stack, "reflectance", polarization, ""].join("\n"), [deg, nm]).result[0];

test("reflectances are those of the native core", (t) => {
  assert.equal(vectors.powers.length, 2000);
  const { worst, worstThin, relative } = judge(vectors.powers, reflectance);
  t.diagnostic(`worst of 2000: ${worst.toFixed(3)} of what is allowed; stacks to 3 um: ${worstThin.toFixed(3)}; single films to 3 um: ${relative.toExponential(1)} of R`);
  assert.ok(worst <= 1 && worstThin <= 1, `${worst} ${worstThin}`);
  // A wrong digit is seen.
  const wrong = judge(vectors.powers, (...a) => reflectance(...a) * (1 + 1e-12));
  assert.ok(wrong.worst > 1);
});

test("colours are those of the native core", (t) => {
  let worst = 0;
  for (const [stack, layer, nm, deg, lamp, model, ...xyz] of vectors.colors) {
    const { result } = core.call("stack_color", [stack, lamp, "", model, ""].join("\n"), [layer, nm, deg]);
    for (let k = 0; k < 3; k++) worst = Math.max(worst, Math.abs(result[k] - xyz[k]));
  }
  t.diagnostic(`worst of ${vectors.colors.length}: ${worst.toExponential(1)}`);
  assert.ok(vectors.colors.length >= 200 && worst <= 1e-9, `${worst}`);
});

test("films flow as they do natively", (t) => {
  for (const [preset, seed, time_s, fps, mean, deviation, first, last] of vectors.flows) {
    core.call("flow_start", preset, [0, seed]);
    let result;
    for (let i = 1; i <= Math.round(time_s * fps); i++) ({ result } = core.call("flow_advance", "", [i / fps]));
    const nm = result.subarray(9);
    assert.equal(result[0], time_s);
    const own = nm.reduce((a, b) => a + b, 0) / nm.length;
    const spread = Math.sqrt(nm.reduce((a, b) => a + (b - own) ** 2, 0) / nm.length);
    t.diagnostic(`${preset}: mean ${own} against ${mean}`);
    assert.ok(Math.abs(own / mean - 1) < 1e-6 && Math.abs(spread / deviation - 1) < 1e-5, `${preset}: ${own} ${mean}`);
    assert.ok(Math.abs(nm[0] - first) < 0.01 && Math.abs(nm[nm.length - 1] - last) < 0.01, preset);
    // Nothing is lost: shares of the first volume.
    const shares = result.subarray(3, 8).reduce((a, b) => a + b, 0);
    assert.ok(Math.abs(shares - 1) < 1e-10, `${shares}`);
  }
});

test("what cannot be is refused in words", () => {
  const refused = [
    ["stack_color", "air / sope 3 / air\nD65", [-1, 0, 0], /soap/],
    ["stack_color", "air / soap 3 / air\nnowhere", [-1, 0, 0], /illuminant/],
    ["stack_color", "air / soap 3 / air", [-1, 0, 90], /angle_deg/],
    ["stack_color", "air / soap 3 / air", [7, 0, 0], /layer/],
    ["stack_color", "air / soap ? / air", [0, NaN, 0], /thickness_nm/],
    ["stack_spectrum", "air / soap 3 / air", [0, -5], /wavelength_nm/],
    ["color_convert", "xyz\nnowhere", [1, 2, 3], /space/],
    ["color_convert", "xyz\nlab", [1, 2], /triples/],
    ["color_table", "air / soap ? / air", [0, 0, 1e9, 0, 89, 0.5], /fringes/],
    ["flow_start", "soup", [0, 1], /must be one of/],
    ["flow_start", "late-preview\nwind_m_s=fast", [0, 1], /number/],
    ["flow_advance", "", [NaN], /finite|no film/],
    ["thickness_swirls", "", [-1, 5, 1], /min_nm/],
    ["thickness_lens_gap", "", [0, 0], /radius_mm/],
    ["medium_index", "nowhere", [550], /medium|nowhere/],
    // Left out of the page for its size.
    ["medium_index", "TiO2-siefke", [550], /TiO2/],
  ];
  for (const [name, text, numbers, words] of refused) {
    assert.throws(() => core.call(name, text, numbers), (error) => words.test(error.message) && !/trap/.test(error.message), `${name} ${text}`);
  }
  // And the core is as it was.
  assert.ok(reflectance("air / soap 320 / air", 550, 0, "s") > 0);
});

test("a table keeps to its tolerance between its nodes", () => {
  const text = "air / TiO2 ? / Ti\nD65";
  const { result } = core.call("color_table", text, [0, 0, 300, 0, 89, 0.5]);
  const [rows, columns] = result;
  assert.equal(result.length, 12 + rows * columns * 6);
  assert.ok(result[10] <= 0.5 && result[10] > 0);
});

test("packed tables come back number for number", () => {
  const [rows, columns] = [5, 7];
  const count = rows * columns;
  const numbers = Int16Array.from({ length: count * 6 }, (_, i) => 32767 * Math.sin(i * i));
  const packed = pack(numbers, columns);
  for (let k = 0; k < 6; k++) {
    const own = [];
    for (let i = 0; i < count; i++) {
      const z = (packed[2 * count * k + i] << 8) | packed[2 * count * k + count + i];
      own[i] = ((foretold(own, i, columns) + ((z >> 1) ^ -(z & 1))) << 16) >> 16;
      assert.equal(own[i], numbers[6 * i + k]);
    }
  }
});
