// Asks the Khronos validator about the glTF files that are named; exits with 1 where it finds an error.
// npm install gltf-validator@2.0.0-dev.3.10; node validate.mjs FILE...

import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { createRequire } from "node:module";

// From where it is run, not from where it lies: the project has no package.json.
const validator = createRequire(join(process.cwd(), "validate.mjs"))("gltf-validator");
let failed = 0;
for (const path of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(path)), {
    uri: path,
    externalResourceFunction: async (uri) => new Uint8Array(readFileSync(join(dirname(path), uri))),
  });
  // Severity 0 is an error, 1 a warning; 2 and 3 are remarks.
  for (const { code, message, pointer, severity } of report.issues.messages) {
    if (severity < 2) console.error(`${path}: ${code} ${pointer}: ${message}`);
  }
  failed += report.issues.numErrors;
}
console.log(`${process.argv.length - 2} files, ${failed} errors`);
process.exit(failed > 0 ? 1 : 0);
