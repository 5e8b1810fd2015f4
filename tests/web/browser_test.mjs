// SPDX-License-Identifier: Apache-2.0
// node browser_test.mjs: page.mjs in headless Chromium, served with a strict script-src. WEB_REFEREE: folder with the referee's pictures of
// SHOTS. The rest: browser.mjs.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { visit } from './browser.mjs';
import { png } from './png.mjs';
import { SHOTS, compare } from './shots.mjs';

const { WEB_REFEREE, WEB_WORK } = process.env;
const { result, pictures, moduleRequests } = await visit('page.html');
fs.writeFileSync(path.join(WEB_WORK, 'element.png'), png(pictures.get('element'), ...result.size));
for (const shot of SHOTS) {
  const { db, levels, covered } = compare(pictures.get(shot.name), fs.readFileSync(path.join(WEB_REFEREE, `${shot.name}.rgba`)));
  console.log(`${shot.name}: ${db === Infinity ? 'equal bytes' : `${db.toFixed(1)} dB, at most ${levels} levels`}`);
  assert.ok(covered > 500 && db >= 80 && levels <= 1, shot.name);
}
assert.deepEqual(result.events, ['progress', 'load', 'first-picture']);
assert.ok(result.opaque > 2000, `${result.opaque} opaque pixels`);
assert.equal(result.label, 'a person');
assert.ok(result.disposed && result.poster && result.silentAfterRemoval && result.several, JSON.stringify(result));
assert.equal(result.atBorder, 0, 'raised arms are in the picture');
assert.ok(result.highest < 0.15, `and fill it: the highest pixel is at ${result.highest} of the height`);
assert.match(result.missing.message, /none\.glb: the server answers 404/);
assert.equal(result.missing.code, 'NETWORK');
assert.equal(result.cors.code, 'NETWORK');
assert.match(result.cors.message, /^http:\/\/localhost:\d+\/work\/person\.glb: cannot be fetched .* \(CORS\)\?$/);
assert.ok(result.calm, 'who asks for less motion gets a still picture');
assert.deepEqual(result.slot, { before: true, after: false }, 'contents of the page show until the first picture');
assert.equal(result.foreign.code, 'DPL_ERROR_UNSUPPORTED', result.foreign.message);
assert.match(result.clip.message, /there is no clip '<img/);
assert.equal(result.drawnBy, 'WebGL2 RGBA16F');
for (const name of ['wanted', 'absent', 'shadersRefused'])
  assert.ok(result[name].renderer === 'CPU' && result[name].seen > 500, `${name}: ${JSON.stringify(result[name])}`);
assert.match(result.nothing.message, /neither by WebGL2 nor on a canvas/);
assert.ok(result.posterThen && result.hidden && result.back, JSON.stringify(result));
assert.equal(result.instead.renderer, 'CPU', 'a device that does not come back is given up');
assert.deepEqual(result.tags, ['canvas', 'img', 'slot', 'style']);
assert.equal(moduleRequests.length, 1, 'all people of a page share one module');

const dense = await visit('page.html?dense', {}, undefined, ['--force-device-scale-factor=3']);
assert.equal(dense.result.density, 3);
for (const [renderer, { width, height, clientWidth, clientHeight, shownWidth, shownHeight, opaque }] of Object.entries(dense.result.dense)) {
  assert.ok(Math.abs(width - 2 * clientWidth) <= 1 && Math.abs(height - 2 * clientHeight) <= 1, `${renderer}: ${width} × ${height} pixels for ${clientWidth} × ${clientHeight}`);
  assert.ok(Math.abs(shownWidth - clientWidth) < 1 && Math.abs(shownHeight - clientHeight) < 1, `${renderer}: shown at ${shownWidth} × ${shownHeight}`);
  assert.ok(opaque > 3 * result.opaque, `${renderer}: ${opaque} opaque pixels; ${result.opaque} of a plain screen`);
}
const { width, height } = dense.result.dense.webgl;
fs.writeFileSync(path.join(WEB_WORK, 'element-dense.png'), png(dense.pictures.get('dense'), width, height));
console.log(`the element's first picture: ${path.join(WEB_WORK, 'element.png')}`);
console.log(`load ${result.loadMs.toFixed(0)} ms, 480 × 640 by the CPU ${result.frameMs.toFixed(1)} ms a frame`);
