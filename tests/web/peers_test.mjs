// SPDX-License-Identifier: Apache-2.0
// node peers_test.mjs [--json FILE]: peers_page.mjs in headless Chromium. WEB_THREE, WEB_SPARK, WEB_PLAYCANVAS: folders of their packages;
// WEB_WORK: has person.glb and person.ply. Writes the pictures to WEB_WORK/peers, and its figures to FILE, a JSON object a line. The rest:
// browser.mjs.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { visit } from './browser.mjs';
import { png } from './png.mjs';
import { compare } from './shots.mjs';

const LEAST_ALIKE_DB = 20;  // the same person from the same camera; upside down or of one half of its splats they are 13 dB apart
const { WEB_WORK, WEB_THREE, WEB_SPARK, WEB_PLAYCANVAS } = process.env;
const { values: options } = parseArgs({ options: { json: { type: 'string' } } });
const version = folder => JSON.parse(fs.readFileSync(path.join(folder, 'package.json'))).version;
const three = `with three.js ${version(WEB_THREE)}`;
const versions = { doppel: three, spark: `${version(WEB_SPARK)} ${three}`, playcanvas: version(WEB_PLAYCANVAS) };
// Spark makes its worker of a blob, and both of text.
const { result, pictures } = await visit('peers.html', {
  three: WEB_THREE, spark: path.join(WEB_SPARK, 'dist'), playcanvas: path.join(WEB_PLAYCANVAS, 'build'),
}, "script-src * 'unsafe-inline' 'unsafe-eval' data: blob:; worker-src * data: blob:");
fs.mkdirSync(path.join(WEB_WORK, 'peers'), { recursive: true });
const rows = [];
for (const { name, ms, least } of result.peers) {
  const picture = pictures.get(name), { db } = compare(picture, pictures.get('doppel'));
  fs.writeFileSync(path.join(WEB_WORK, 'peers', `${name}.png`), png(picture, 480, 640));
  console.log(`${name} ${versions[name]}: ${ms.toFixed(0)} ms a frame, at least ${least.toFixed(0)}; ${db.toFixed(1)} dB to Doppel`);
  assert.ok(db >= LEAST_ALIKE_DB, `${name} draws something else`);
  const { size, splats, frames } = result;
  rows.push({ row: 'peer', peer: name, version: versions[name], size, splats, frames, ms_p50: ms, ms_least: least, bars: {} });
}
assert.equal(rows.length, 3);
if (options.json) fs.writeFileSync(options.json, rows.map(row => `${JSON.stringify(row)}\n`).join(''));
