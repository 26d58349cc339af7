// Runs the Khronos glTF validator on a file. Question: {file}; answer: its report.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";

const validator = createRequire(join(process.argv[2], "x.js"))("gltf-validator");
const question = JSON.parse(readFileSync(0, "utf8"));
const report = await validator.validateBytes(new Uint8Array(readFileSync(question.file)), {
  externalResourceFunction: async (uri) => new Uint8Array(readFileSync(join(dirname(question.file), decodeURIComponent(uri)))),
});
process.stdout.write(JSON.stringify(report));
