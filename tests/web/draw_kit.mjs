// SPDX-License-Identifier: Apache-2.0
// node draw_kit.mjs MODULE KIT PICTURES: draws the conformance kit with the module, as `tools/conformance draw` does with the library.
// The views of a case are drawn one by one.
import fs from 'node:fs';
import path from 'node:path';
import { Doppel } from '../../platform/web/doppel.js';
import { png } from './png.mjs';

const [module, kit, pictures] = process.argv.slice(2);
const wasm = await WebAssembly.compile(fs.readFileSync(module));
fs.mkdirSync(pictures, { recursive: true });
const { cases } = JSON.parse(fs.readFileSync(path.join(kit, 'kit.json'), 'utf8'));
for (const one of cases) {
  const person = await Doppel.load(fs.readFileSync(path.join(kit, one.avatar)), { module: wasm });
  person.setPose(one.rotations.flat(), one.root_translation);
  for (const view of one.views) {
    const c = view, camera = { width: c.width_px, height: c.height_px, fx: c.fx, fy: c.fy, cx: c.cx, cy: c.cy, viewFromWorld: c.view_from_world };
    fs.writeFileSync(path.join(pictures, view.picture), png(person.draw(camera), camera.width, camera.height));
  }
  person.dispose();
}
console.log(`${cases.length} cases drawn by the module`);
