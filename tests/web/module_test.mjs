// SPDX-License-Identifier: Apache-2.0
// node --test: the module and doppel.js in Node, without a DOM. WEB_MODULE: doppel.wasm. WEB_PERSON: a sample person. WEB_REFEREE: folder with
// the referee's pictures of SHOTS. WEB_REFEREE_PROGRAM: web_referee.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { test } from 'node:test';
import { Doppel, DoppelError } from '../../platform/web/doppel.js';
import { SplatPacer } from '../../platform/web/splat-pacer.js';
import { SHOTS, compare, line, poseAs } from './shots.mjs';

const wasm = await WebAssembly.compile(fs.readFileSync(process.env.WEB_MODULE));
const glb = fs.readFileSync(process.env.WEB_PERSON);
const load = (bytes = glb, options = {}) => Doppel.load(bytes, { module: wasm, ...options });
const fails = (what, code, pattern) => assert.rejects(async () => what(), error => {
  assert.ok(error instanceof DoppelError, String(error));
  assert.equal(error.code, code, error.message);
  assert.match(error.message, pattern);
  return true;
});

test('draws what the referee draws', async t => {
  const person = await load();
  for (const shot of SHOTS) {
    poseAs(person, shot);
    const picture = person.draw(person.lookAt(shot));
    const { db, levels, covered } = compare(picture, fs.readFileSync(path.join(process.env.WEB_REFEREE, `${shot.name}.rgba`)));
    t.diagnostic(`${shot.name}: ${db === Infinity ? 'equal bytes' : `${db.toFixed(1)} dB, at most ${levels} levels`}`);
    assert.ok(covered > 500, `${shot.name} shows the person`);
    assert.ok(db >= 80 && levels <= 1, `${shot.name}: ${db} dB, ${levels} levels`);
  }
});

const FLOATS = 13;  // a splat, as web_referee --splats writes them
const LAYOUT = [['position', 0], ['covariance', 3], ['colour', 9], ['opacity', 12]].map(([property, at]) =>
  ({ property, offset: 4 * at, stride: 4 * FLOATS }));

test('writes the splats that the referee writes', async t => {
  const person = await load(), file = shot => path.join(process.env.WEB_REFEREE, `${shot.name}.splats`);
  execFileSync(process.env.WEB_REFEREE_PROGRAM, [process.env.WEB_PERSON, '--splats'], { input: SHOTS.map(shot => line(shot, file(shot))).join('\n') });
  for (const shot of SHOTS) {
    poseAs(person, shot);
    const { bytes, count, saturated } = person.writeSplats(LAYOUT, { eye: shot.eye }), expected = fs.readFileSync(file(shot));
    assert.equal(count, person.splatCount);
    assert.equal(saturated, 0);
    assert.equal(bytes.length, expected.length);
    const floats = new Float32Array(bytes.slice().buffer), wanted = new Float32Array(Uint8Array.from(expected).buffer);
    let place = 0, look = 0, shown = 0;
    for (let i = 0; i < floats.length; ++i) {
      const off = Math.abs(floats[i] - wanted[i]), kind = i % FLOATS;
      if (kind < 9) place = Math.max(place, off);
      else look = Math.max(look, off);
      shown += kind === 12 && floats[i] > 0.1;
    }
    t.diagnostic(`${shot.name}: ${count} splats, ${shown} shown, positions at most ${place} off, colours and opacities ${look}`);
    assert.ok(shown > count / 10 && shown < count, `${shown} of ${count} are shown`);
    assert.ok(place < 1e-6 && look < 2e-4, `${place}, ${look}`);  // poses of clips differ in the last bits; the gate is steep
  }
  person.dispose();
});

test('splats in a layout of the caller, or a sentence', async () => {
  const person = await load();
  const opacities = options => {
    const { bytes, count } = person.writeSplats([{ property: 'opacity' }], options);
    return new Float32Array(bytes.buffer, bytes.byteOffset, count).slice();
  };
  const without = opacities(), front = opacities({ eye: [0, 1, 3] }), few = opacities({ splatBudget: 5000 });
  assert.ok(without.every((opacity, i) => opacity >= front[i]) && without.some((opacity, i) => opacity > front[i] + 0.5), 'the gate takes away');
  assert.ok(few.length < without.length / 2 && few.length > 1000, `${few.length}`);
  const twice = person.writeSplats([{ property: 'position' }, { property: 'position', number: 'half', offset: 12 * without.length }]);
  assert.equal(twice.bytes.length, 18 * without.length);
  assert.equal(person.writeSplats([{ property: 'sh', number: 'half' }], { shDegree: 1 }).bytes.length, 24 * without.length);
  const wrongs = [
    [[], {}, /0 elements/], [[{ property: 'sheen' }], {}, /no property 'sheen'/], [[{ property: 'opacity', number: 'double' }], {}, /no number 'double'/],
    [[{ property: 'opacity', offset: -4 }], {}, /offset -4/], [[{ property: 'position', stride: 8 }], {}, /stride/],
    [[{ property: 'opacity', offset: 2 ** 40 }], {}, /offset 1099511627776/], [[{ property: 'opacity' }], { eye: [0, 1] }, /2 numbers/],
    [[{ property: 'opacity' }], { eye: [0, NaN, 1] }, /eye/], [[{ property: 'opacity' }], { shDegree: 4 }, /degree/i],
    [[{ property: 'position' }, { property: 'scale', offset: 4 }], {}, /overlap/],
  ];
  for (const [layout, options, pattern] of wrongs) await fails(() => person.writeSplats(layout, options), 'DPL_ERROR_INVALID_ARGUMENT', pattern);
  assert.deepEqual(opacities(), without, 'after errors it goes on');
  person.dispose();
});

test('tells of the person', async () => {
  const person = await load();
  assert.ok(person.splatCount > 1000 && person.joints.length > 10);
  assert.deepEqual(person.clips.map(c => c.name), ['walk', 'moves']);
  assert.ok(person.clips.every(c => c.duration > 0.5));
  assert.ok(person.joints.some(j => j.bone === 'head') && person.joints[0].parent === -1);
  assert.ok(person.restMax[1] > 1.2 && person.restMin[1] < 0.1);
  assert.equal(person.jointPositions().length, 3 * person.joints.length);
});

test('a clip is found by name, and a pose and a transform move the person', async () => {
  const person = await load();
  const camera = person.lookAt(SHOTS[0]);
  const rest = person.draw(camera);
  person.setClip('walk', 0.4);
  const walking = person.draw(camera);
  assert.ok(compare(rest, walking).levels > 50);
  person.setPose(person.joints.flatMap(() => [0, 0, 0, 1]));
  assert.equal(compare(rest, person.draw(camera)).db, Infinity);
  person.setClothStiffness(3);
  person.setClothStiffness(1);
  person.setTransform([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0]);
  assert.ok(compare(rest, person.draw(camera)).levels > 50);
  person.setTransform(null);
  assert.equal(compare(rest, person.draw(camera)).db, Infinity);
});

test('the face shows what it is given, whatever the pose, and streams go by their names', async () => {
  const person = await load(), camera = person.lookAt(SHOTS.find(({ name }) => name === 'face')), names = person.expressions.map(({ name }) => name);
  assert.equal(names.length, 52);
  assert.deepEqual([names[0], names.at(-1)], ['eyeBlinkLeft', 'tongueOut']);
  assert.deepEqual(person.expressions.filter(({ drawn }) => !drawn), [{ name: 'tongueOut', drawn: false }]);
  const neutral = person.draw(camera), weightOf = name => person.expression()[names.indexOf(name)];
  person.setExpression(names.map(name => name === 'jawOpen' ? 0.75 : 0));
  assert.equal(weightOf('jawOpen'), 0.75);
  assert.ok(compare(neutral, person.draw(camera)).levels > 50, 'the mouth opens');
  person.setClip('walk', 0.4);
  person.setPose(person.joints.flatMap(() => [0, 0, 0, 1]));
  assert.equal(weightOf('jawOpen'), 0.75, 'a pose leaves the face as it is');
  person.setExpression(new Float32Array(52));
  assert.equal(compare(neutral, person.draw(camera)).db, Infinity, 'weights of zero are the neutral face');
  const categories = [{ categoryName: '_neutral', score: 1 }, { categoryName: 'browInnerUp', score: 0.5 }, { categoryName: 'mouthSmileLeft', score: 1.02 }];
  person.setExpressionNamed(categories.map(c => c.categoryName), categories.map(c => c.score));
  assert.deepEqual([weightOf('browInnerUp'), weightOf('mouthSmileLeft'), weightOf('jawOpen')], [0.5, 1, 0]);
  person.setExpression({ JawOpen: 0.25, aa: 0 });
  assert.deepEqual([weightOf('browInnerUp'), weightOf('jawOpen')], [0, 0.25]);
  const given = person.expression();
  const wrongs = [[() => person.setExpression([0, 1]), /2 weights; there are 52/], [() => person.setExpression({ jawOpen: NaN }), /'jawOpen' is not a number/],
    [() => person.setExpression(new Array(52)), /'eyeBlinkLeft' is not a number/], [() => person.setExpression({ jawOpne: 1 }), /did you mean 'jawOpen'/],
    [() => person.setExpressionNamed(['jawOpen'], []), /1 names and 0 weights/],
    [() => person.setExpressionNamed(new Array(2000).fill('jawOpen'), new Float32Array(2000)), /at most 1024/]];
  for (const [what, pattern] of wrongs) await fails(what, 'DPL_ERROR_INVALID_ARGUMENT', pattern);
  assert.deepEqual(person.expression(), given, 'after errors the face stays');
  person.setExpression({});
  assert.ok(person.expression().every(weight => weight === 0));
  const lids = Array.from({ length: 600 }, (_, i) => (person.setFaceMotion(50 * i, { seed: 3, glances: 0 }), weightOf('eyeBlinkLeft')));
  assert.ok(Math.max(...lids) > 0.9 && lids.filter(closed => closed === 0).length > 300, 'it blinks now and then');
  person.setExpression({ jawOpen: 1 });
  const shown = timeMs => (person.setFaceMotion(timeMs, { blinks: 0, glances: 0, holdS: 0.3, heardMs: 1000 }), weightOf('jawOpen'));
  assert.deepEqual([shown(1300), shown(1551)], [1, 0], 'a stream that stops fades within 0.25 s');
  await fails(() => person.setFaceMotion(0, { blinks: 2 }), 'DPL_ERROR_INVALID_ARGUMENT', /blinks/);
  person.setFaceMotion(0, { blinks: 0, glances: 0 });
  person.setExpression({});
  person.dispose();
  await fails(() => person.setExpression({}), 'DPL_ERROR_INVALID_ARGUMENT', /disposed/);
});

test('a pose may have a time, and what clothes remember is saved and restored', async () => {
  const person = await load(), rest = person.joints.flatMap(() => [0, 0, 0, 1]), arm = 4 * person.joints.findIndex(({ bone }) => bone === 'leftUpperArm');
  const raised = [...rest];
  raised.splice(arm, 4, 0, 0, Math.sin(0.6), Math.cos(0.6));
  person.setPose(raised, [0, 0, 0.25]);
  const places = person.jointPositions();
  person.setPose(rest, [0, 0, 0], { timeMs: 1000 });
  assert.notDeepEqual(person.jointPositions(), places);
  person.setPose(raised, [0, 0, 0.25], { timeMs: 1100 });
  assert.deepEqual(person.jointPositions(), places, 'with a time it is the same pose');
  const state = person.motionState();
  assert.ok(state instanceof Uint8Array && state.length > 8, `${state.length} bytes`);
  person.settle();
  person.setMotionState(state);
  assert.deepEqual(person.motionState(), state);
  await fails(() => person.setMotionState(state.subarray(1)), 'DPL_ERROR_INVALID_ARGUMENT', /motion state/);
  await fails(() => person.setPose(rest, [0, 0, 0], { timeMs: NaN }), 'DPL_ERROR_INVALID_ARGUMENT', /a time of NaN ms/);
  assert.deepEqual(person.jointPositions(), places, 'after errors the pose stays');
  const other = await load();
  other.setMotionState(state);
  assert.deepEqual(other.motionState(), state, 'another person of the same file takes it');
  person.dispose();
  other.dispose();
});

test('straight alpha divides by alpha, and a buffer of the caller is filled', async () => {
  const person = await load();
  const camera = person.lookAt(SHOTS[0]), into = new Uint8ClampedArray(camera.width * camera.height * 4);
  const premultiplied = person.draw(camera), straight = person.draw(camera, { straight: true, into });
  assert.equal(straight, into);
  const i = premultiplied.findIndex((value, at) => at % 4 === 3 && value > 60 && value < 200) - 3;
  assert.ok(i >= 0);
  for (let k = 0; k < 3; ++k) assert.ok(Math.abs(straight[i + k] * premultiplied[i + 3] / 255 - premultiplied[i + k]) <= 1.5);
});

test('several persons have their own state and memory', async () => {
  const [a, b] = await Promise.all([load(), load()]);
  const camera = a.lookAt(SHOTS[0]);
  a.setClip(0, 0.4);
  assert.ok(compare(a.draw(camera), b.draw(camera)).levels > 50);
  a.dispose();
  await fails(() => a.draw(camera), 'DPL_ERROR_INVALID_ARGUMENT', /disposed/);
  b.draw(camera);
});

test('damaged files are an error with a sentence', async () => {
  const json = glb.readUInt32LE(12);
  for (let i = 0; i < 24; ++i) {
    let bytes = Buffer.from(glb);
    if (i % 2) for (let k = 0; k < 3; ++k) bytes[20 + (i * 7919 + k * 104729) % json] = 32 + (i + k) % 90;
    else bytes = bytes.subarray(0, Math.floor(glb.length * i / 24));
    try {
      (await load(bytes, { onLog: () => {} })).dispose();
      assert.ok(i % 2, `truncated to ${bytes.length} bytes`);  // a changed letter may do no harm
    } catch (error) {
      assert.ok(error instanceof DoppelError && error.message.length > 10, String(error));
      assert.notEqual(error.code, 'DPL_ERROR_INTERNAL', error.message);
    }
  }
  await fails(() => load(Buffer.from('<html>Not found</html>')), 'DPL_ERROR_UNSUPPORTED', /./);
});

test('a file that is not there, and a request that is ended', async () => {
  await fails(() => load(pathToFileURL('/nowhere/ada.glb')), 'NETWORK', /ada\.glb: cannot be fetched/);
  await fails(() => load(new Response('gone', { status: 404 })), 'NETWORK', /404/);
  const controller = new AbortController();
  controller.abort();
  await assert.rejects(load(glb, { signal: controller.signal }), { name: 'AbortError' });
});

test('a file that streams tells how far it is', async () => {
  const seen = [];
  const body = new ReadableStream({
    start(stream) {
      for (let at = 0; at < glb.length; at += 100000) stream.enqueue(new Uint8Array(glb.subarray(at, at + 100000)));
      stream.close();
    },
  });
  const person = await load(new Response(body, { headers: { 'content-length': String(glb.length) } }), { onProgress: (loaded, total) => seen.push([loaded, total]) });
  assert.ok(person.splatCount > 0);
  assert.deepEqual(seen.at(-1), [glb.length, glb.length]);
});

test('wrong calls are errors, and the person lives', async () => {
  const person = await load();
  const camera = person.lookAt(SHOTS[0]), identity = person.joints.flatMap(() => [0, 0, 0, 1]);
  await fails(() => person.setPose([0, 0, 0, 1]), 'DPL_ERROR_INVALID_ARGUMENT', /4 for each/);
  await fails(() => person.setPose(identity.map((v, i) => i === 7 ? NaN : v)), 'DPL_ERROR_INVALID_ARGUMENT', /./);
  await fails(() => person.setClip('dance', 0), 'DPL_ERROR_NOT_FOUND', /walk, moves/);
  await fails(() => person.setClip(99, 0), 'DPL_ERROR_NOT_FOUND', /./);
  await fails(() => person.setClip(0, NaN), 'DPL_ERROR_INVALID_ARGUMENT', /./);
  await fails(() => person.draw({ ...camera, width: 0 }), 'DPL_ERROR_INVALID_ARGUMENT', /1 to 8192/);
  await fails(() => person.draw({ ...camera, width: 1e9 }), 'DPL_ERROR_INVALID_ARGUMENT', /1 to 8192/);
  await fails(() => person.draw({ ...camera, fx: NaN }), 'DPL_ERROR_INVALID_ARGUMENT', /./);
  await fails(() => person.draw({ ...camera, viewFromWorld: [] }), 'DPL_ERROR_INVALID_ARGUMENT', /12 numbers/);
  await fails(() => person.setClothStiffness(-1), 'DPL_ERROR_INVALID_ARGUMENT', /1 is as learned/);
  await fails(() => person.setTransform([1, 2, 3]), 'DPL_ERROR_INVALID_ARGUMENT', /12 are needed/);
  await fails(() => person.lookAt({ ...SHOTS[0], eye: SHOTS[0].target }), 'DPL_ERROR_INVALID_ARGUMENT', /./);
  await fails(() => person.loadClip(Buffer.from('HIERARCHY nothing')), 'DPL_ERROR_CORRUPT_DATA', /./);
  person.draw(camera);
});

test('tells of layers, and says why one cannot be hidden', async () => {
  const person = await load();
  assert.equal(person.layers[0].role, 'body');
  assert.equal(person.layers.reduce((sum, layer) => sum + layer.triangleCount, 0), person.triangleCount);
  await fails(() => person.hideLayer(0), 'DPL_ERROR_UNSUPPORTED', /body/);
  await fails(() => person.hideLayer('<b>hat'), 'DPL_ERROR_NOT_FOUND', /there are: body/);
  await fails(() => person.hideLayer(99), 'DPL_ERROR_NOT_FOUND', /./);
  person.hideLayer(person.layers.length - 1, false);
});

/** A PLY of `count` splats in a row. */
function plyOf(count) {
  const names = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity', 'scale_0', 'scale_1', 'scale_2', 'rot_0', 'rot_1', 'rot_2', 'rot_3'];
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${count}\n${names.map(n => `property float ${n}\n`).join('')}end_header\n`;
  const rows = Array.from({ length: count }, (_, i) => [0.1 * i, 0, 0, 1, 0, 0, 4, -3, -3, -3, 1, 0, 0, 0]);
  return Buffer.concat([Buffer.from(header), Buffer.from(Float32Array.from(rows.flat()).buffer)]);
}

test('general splats are read by the module for them, which is loaded for them alone', async () => {
  const ply = plyOf(5), beside = pathToFileURL(process.env.WEB_MODULE);
  await fails(() => load(ply), 'DPL_ERROR_UNSUPPORTED', /general splats.*persons only/);
  const splats = await Doppel.load(ply, { module: beside });
  assert.equal(splats.splatCount, 5);
  const picture = splats.draw(splats.lookAt({ eye: [0.2, 0, 2], target: [0.2, 0, 0], width: 80, height: 60 }));
  assert.ok(picture.some((value, i) => i % 4 === 3 && value > 200), 'something is seen');
  const large = fs.readFileSync(path.join(path.dirname(process.env.WEB_MODULE), 'doppel-splats.wasm'));
  assert.equal((await load(ply, { splatsModule: large })).splatCount, 5);
  await fails(() => load(ply.subarray(0, 300), { splatsModule: large }), 'DPL_ERROR_CORRUPT_DATA', /./);
  await fails(() => load(ply, { splatsModule: pathToFileURL('/nowhere/doppel-splats.wasm') }), 'NETWORK', /doppel-splats\.wasm/);
  await fails(() => load(Buffer.from('<html>Not found</html>'), { splatsModule: pathToFileURL('/nowhere/doppel-splats.wasm') }), 'DPL_ERROR_UNSUPPORTED', /./);
  assert.ok((await load(glb, { splatsModule: pathToFileURL('/nowhere/doppel-splats.wasm') })).joints.length > 10);
});

test('gives the posed mesh, in the space of the person', async () => {
  const person = await load(), { positions, triangles } = person.posedMesh(), rest = positions.slice();
  assert.deepEqual([positions.length, triangles.length], [3 * person.vertexCount, 3 * person.triangleCount]);
  assert.ok(triangles.every(vertex => vertex < person.vertexCount));
  for (let axis = 0; axis < 3; ++axis) {
    const values = rest.filter((value, i) => i % 3 === axis);
    assert.ok(Math.abs(Math.min(...values) - person.restMin[axis]) < 0.05 && Math.abs(Math.max(...values) - person.restMax[axis]) < 0.05, `axis ${axis}`);
  }
  person.setTransform([2, 0, 0, 5, 0, 2, 0, 0, 0, 0, 2, 0]);
  assert.deepEqual(person.posedMesh().positions, rest);
  person.setClip('walk', 0.4);
  const walking = person.posedMesh();
  assert.ok(walking.positions === positions && walking.triangles === triangles, 'nothing new is made');
  assert.ok(positions.some((value, i) => Math.abs(value - rest[i]) > 0.1));
  person.dispose();
  assert.throws(() => person.posedMesh(), /disposed/);
});

test('memory that is refused is an error of that person alone', async () => {
  await fails(() => load(glb, { memoryLimit: 6 << 20 }), 'DPL_ERROR_OUT_OF_MEMORY', /memory/);
  const person = await load();
  person.draw(person.lookAt(SHOTS[0]));
});

test('a picture that does not fit into 256 MB is an error, and the person lives', async () => {
  const person = await load(glb, { memoryLimit: 256 << 20 });
  const large = person.lookAt({ ...SHOTS[0], width: 8192, height: 8192 });
  await fails(() => person.draw(large), 'DPL_ERROR_OUT_OF_MEMORY', /memory|bytes more/);
  const { covered } = compare(person.draw(person.lookAt(SHOTS[0])), new Uint8Array(SHOTS[0].width * SHOTS[0].height * 4));
  assert.ok(covered > 500);
  person.dispose();
});

test('many pictures take no more memory', async t => {
  const memories = [];
  const Memory = WebAssembly.Memory;
  WebAssembly.Memory = class extends Memory { constructor(...values) { super(...values); memories.push(this); } };
  const person = await load();
  WebAssembly.Memory = Memory;
  const camera = person.lookAt({ ...SHOTS[0], width: 60, height: 100 });
  let warm = 0;
  for (let i = 0; i < 60; ++i) {
    person.setClip(0, i / 30);
    person.draw(camera);
    if (i === 10) warm = memories[0].buffer.byteLength;
  }
  assert.equal(memories[0].buffer.byteLength, warm);
  t.diagnostic(`${(warm / 1048576).toFixed(1)} MB of memory for a file of ${(glb.length / 1048576).toFixed(1)} MB`);
});

test('projects what is drawn: sorted, within the budget, two eyes, no memory more', async () => {
  const person = await load(), camera = person.lookAt(SHOTS[1]);
  const all = { ...person.project(camera) }, count = all.counts[0];
  assert.ok(count > 1000 && count <= person.splatCount && all.counts[1] === 0 && all.rows === Math.ceil(count / 512));
  const depths = new Float32Array(all.words.buffer), depthOf = i => depths[all.at + 8 * i + 2];
  for (let i = 1; i < count; ++i) assert.ok(depthOf(i) <= depthOf(i - 1), `splat ${i}`);
  const eyes = person.project(camera, { ...camera, cx: camera.cx + 3 });
  assert.ok(eyes.counts[0] === count && eyes.counts[1] > 1000);
  const floats = new Float32Array(eyes.words.buffer), last = eyes.at + 8 * (count - 1), other = eyes.at + 8 * (count + eyes.counts[1] - 1);
  assert.ok(Math.abs(floats[other] - floats[last] - 3) < 1e-3, 'the nearest splat of the other eye is 3 pixels aside');
  person.setDetail({ splatBudget: 2000 });
  assert.ok(person.project(camera).counts[0] <= 2000);
  person.setDetail();
  const bytes = person.project(camera).words.buffer.byteLength;
  for (let i = 0; i < 50; ++i) assert.equal(person.project(camera).words.buffer.byteLength, bytes);
  await fails(() => person.project({ ...camera, width: 0 }), 'DPL_ERROR_INVALID_ARGUMENT', /1 to 8192/);
  await fails(() => person.project(camera, { ...camera, fx: NaN }), 'DPL_ERROR_INVALID_ARGUMENT', /./);
  person.dispose();
  await fails(() => person.project(camera), 'DPL_ERROR_INVALID_ARGUMENT', /disposed/);
});

test('a slow device gets fewer splats until it keeps 30 frames a second, and all of them when it stands still', () => {
  const pacer = new SplatPacer();
  let budget = 0;
  const person = { splatCount: 50000, setDetail: ({ splatBudget = 0 } = {}) => { budget = splatBudget; } };
  const shown = () => budget || person.splatCount;
  pacer.reset(person);
  const deviceMs = () => 4 + shown() / 500;  // 104 ms with all splats
  for (let frame = 0; frame < 200; ++frame) pacer.pace(person, deviceMs());
  assert.ok(deviceMs() < 39 && shown() > 8000, `${shown()} splats, ${deviceMs()} ms`);
  pacer.pace(person, 0);
  assert.equal(budget, 0);
  pacer.pace(person, deviceMs());
  assert.ok(shown() < 20000);
  for (let frame = 0; frame < 3000; ++frame) pacer.pace(person, 16.7);
  assert.equal(budget, 0, 'a device that has become fast shows all');
  pacer.pace(person, 5000);
  pacer.pace(person, 5000);
  pacer.pace(person, 5000);
  assert.equal(budget, 0, 'a page that was hidden is not slow');
});
