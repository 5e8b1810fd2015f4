// SPDX-License-Identifier: Apache-2.0
// Runs the Khronos validator over .glb files: node validate_gltf.mjs NPM_FOLDER FILE...
// Passes with 0 errors and 0 warnings. NPM_FOLDER holds node_modules/gltf-validator (validate_files.sh installs it).
import fs from 'node:fs';
import path from 'node:path';
import { createRequire } from 'node:module';

const [npmFolder, ...files] = process.argv.slice(2);
const validator = createRequire(path.join(path.resolve(npmFolder), 'index.js'))('gltf-validator');
let failed = files.length === 0;
for (const file of files) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), { maxIssues: 0 });
    const { numErrors, numWarnings, messages } = report.issues;
    console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${report.info.totalVertexCount} vertices, ${report.info.animationCount} animations`);
    for (const m of messages) if (m.severity < 2) console.log(`  ${m.severity === 0 ? 'error' : 'warning'} ${m.code} at ${m.pointer}: ${m.message}`);
    failed ||= numErrors + numWarnings > 0;
}
process.exit(failed ? 1 : 0);
