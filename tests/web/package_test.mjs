// SPDX-License-Identifier: Apache-2.0
// node --test: the npm package, found by its name. WEB_PERSON: a sample person.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { pathToFileURL } from 'node:url';
import { test } from 'node:test';
import { Doppel, DoppelError } from 'doppel-web';

const folder = new URL('node_modules/doppel-web/', pathToFileURL(process.cwd() + '/'));
const manifest = JSON.parse(fs.readFileSync(new URL('package.json', folder)));

test('every file that the manifest names is there', () => {
  assert.match(manifest.version, /^\d+\.\d+\.\d+/);
  assert.deepEqual(manifest.dependencies, {});
  const named = [manifest.main, manifest.types, ...manifest.sideEffects,
    ...Object.values(manifest.exports).flatMap(e => typeof e === 'string' ? [e] : Object.values(e))];
  for (const file of [...named, 'README.md', 'LICENSE', 'NOTICE', 'licences.txt', 'demo/index.html'])
    assert.ok(fs.statSync(new URL(file, folder)).size > 50, file);
});

test('the module is found beside the script, and draws', async () => {
  const person = await Doppel.load(pathToFileURL(process.env.WEB_PERSON));
  const picture = person.draw(person.lookAt({ eye: [0, 1, 3.2], target: [0, 0.9, 0], fovY: 0.7, width: 120, height: 200 }));
  assert.ok(picture.filter((value, i) => i % 4 === 3 && value > 200).length > 1000, 'somebody is seen');
  assert.throws(() => person.setClip('dance', 0), DoppelError);
  person.dispose();
});

test('the element can be imported where there is no DOM', async () => {
  const { DoppelAvatarElement } = await import('doppel-web/element');
  assert.equal(typeof DoppelAvatarElement, 'function');
});

test('WebGL2 and WebXR can be imported where there is neither', async () => {
  const { SplatRenderer, SplatBlender } = await import('doppel-web/webgl'), { XREyes, cameraOfXRView } = await import('doppel-web/webxr');
  for (const thing of [SplatRenderer, SplatBlender, XREyes, cameraOfXRView]) assert.equal(typeof thing, 'function');
});

test('three.js is a peer that is missed by its name, and its group needs nothing else', async () => {
  assert.deepEqual(Object.keys(manifest.peerDependencies), ['playcanvas', 'three']);
  for (const file of ['three-group.js', 'three-pass.js'])
    for (const [, from] of fs.readFileSync(new URL(file, folder), 'utf8').matchAll(/ from '([^']*)'/g)) assert.match(from, /^(three|\.\/[\w-]+\.js)$/);
  await assert.rejects(import('doppel-web/three'), /Cannot find package 'three'/);
});

test('splats of other engines miss them by their names', async () => {
  await assert.rejects(import('doppel-web/three-splats'), /Cannot find package 'three'/);
  await assert.rejects(import('doppel-web/playcanvas-splats'), /Cannot find package 'playcanvas'/);
  assert.equal(typeof (await import('doppel-web/babylon-splats')).BabylonSplats, 'function');
});

test('types name every public function', () => {
  const types = fs.readFileSync(new URL('doppel.d.ts', folder), 'utf8');
  for (const name of Object.getOwnPropertyNames(Doppel.prototype)) assert.match(types, new RegExp(`\\b${name}\\(`), name);
  assert.doesNotMatch(types, /@c dpl/);
});
