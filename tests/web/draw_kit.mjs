// SPDX-License-Identifier: Apache-2.0
// node draw_kit.mjs MODULE KIT PICTURES: draws the conformance kit with the module, as `tools/conformance draw` does with the library.
// The views of a case are drawn one by one.
import fs from 'node:fs';
import path from 'node:path';
import zlib from 'node:zlib';
import { Doppel } from '../../platform/web/doppel.js';

function png(rgba, width, height) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type, 'latin1'), data]), out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 6, 0, 0, 0], 8);
  const rows = Buffer.alloc(height * (1 + width * 4));
  for (let y = 0; y < height; ++y) rows.set(rgba.subarray(y * width * 4, (y + 1) * width * 4), y * (1 + width * 4) + 1);
  return Buffer.concat([Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]), chunk('IHDR', head), chunk('IDAT', zlib.deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}

const table = Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n >>> 0;
});
function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = table[(crc ^ byte) & 255] ^ (crc >>> 8);
  return ~crc >>> 0;
}

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
