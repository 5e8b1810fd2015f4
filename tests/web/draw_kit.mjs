// SPDX-License-Identifier: Apache-2.0
// node draw_kit.mjs MODULE KIT PICTURES: draws the conformance kit with the module, as `tools/conformance draw` does with the library.
// The views of a case are drawn one by one.
import fs from 'node:fs';
import path from 'node:path';
import { Doppel } from '../../platform/web/doppel.js';
import { cameraOf, poseAsIn } from './kit_case.mjs';
import { png } from './png.mjs';

const [module, kit, pictures] = process.argv.slice(2);
const wasm = await WebAssembly.compile(fs.readFileSync(module));
fs.mkdirSync(pictures, { recursive: true });
const { cases } = JSON.parse(fs.readFileSync(path.join(kit, 'kit.json'), 'utf8'));
for (const one of cases) {
  const person = await Doppel.load(fs.readFileSync(path.join(kit, one.avatar)), { module: wasm });
  poseAsIn(one, person, camera => person.draw(camera));
  for (const view of one.views) {
    const camera = cameraOf(view);
    fs.writeFileSync(path.join(pictures, view.picture), png(person.draw(camera), camera.width, camera.height));
  }
  person.dispose();
}
console.log(`${cases.length} cases drawn by the module`);
