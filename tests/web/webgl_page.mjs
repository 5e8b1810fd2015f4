// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: draws by WebGL2 what dplRender draws too, takes the device away, counts memory and time, and sends what it found to
// the server of browser.mjs.
import { Doppel } from '../../platform/web/doppel.js';
import { SplatRenderer } from '../../platform/web/webgl-renderer.js';
import { XREyes, cameraOfXRView } from '../../platform/web/webxr.js';
import { SHOTS, poseAs } from './shots.mjs';
import { cameraOf, poseAsIn } from './kit_case.mjs';

const MODULE = '/module/doppel.wasm', PERSON = '/work/person.glb', KIT = '/work/kit/';
const FRAMES = 1000, TIMED = 21;
const found = {};
const post = (path, body) => fetch(path, { method: 'POST', body });
const median = values => values.sort((a, b) => a - b)[values.length >> 1];
const event = (target, type) => new Promise(done => target.addEventListener(type, done, { once: true }));
const load = (source = PERSON) => Doppel.load(source, { module: MODULE });
const canvas = () => document.createElement('canvas');

/** Runs `body` while `object[name]` is replaced. */
async function without(object, name, replacement, body) {
  const before = object[name];
  object[name] = replacement(before);
  try {
    return await body();
  } finally {
    object[name] = before;
  }
}

async function shots(person, renderer, prefix) {
  for (const shot of SHOTS) {
    poseAs(person, shot);
    renderer.draw(person, person.lookAt(shot));
    await post(`/picture/${prefix}-${shot.name}.rgba`, renderer.read());
  }
}

async function kit() {
  const { cases } = await (await fetch(`${KIT}kit.json`)).json();
  const renderer = new SplatRenderer(canvas());
  found.kit = [];
  for (const one of cases) {
    const person = await load(KIT + one.avatar);
    poseAsIn(one, person, camera => renderer.draw(person, camera));
    for (const c of one.views) {
      const camera = cameraOf(c);
      renderer.draw(person, camera);
      await post(`/picture/kit-${c.picture}.rgba`, renderer.read());
      found.kit.push({ name: one.name, picture: c.picture, width: camera.width, height: camera.height, blank: one.may_be_blank });
    }
    person.dispose();
  }
  renderer.dispose();
}

async function lostDevice(person) {
  const target = canvas(), said = [];
  const renderer = new SplatRenderer(target, { onLost: () => said.push('lost'), onRestored: () => said.push('restored') });
  const camera = person.lookAt(SHOTS[1]), device = target.getContext('webgl2').getExtension('WEBGL_lose_context');
  renderer.draw(person, camera);
  const before = renderer.read();
  device.loseContext();
  await event(target, 'webglcontextlost');
  const drawn = renderer.draw(person, camera);
  await new Promise(done => setTimeout(done));  // while the event is told, the browser gives nothing back
  device.restoreContext();
  await event(target, 'webglcontextrestored');
  const again = renderer.draw(person, camera);
  const after = renderer.read();
  found.lost = { said, drawn, again, same: after.every((value, i) => value === before[i]), covered: before.filter(value => value > 0).length };
  renderer.dispose();
}

async function refused(person) {
  const prototype = WebGL2RenderingContext.prototype;
  await without(prototype, 'getExtension', get => function(name) { return /color_buffer/.test(name) ? null : get.call(this, name); }, async () => {
    const renderer = new SplatRenderer(canvas());
    found.refusedTarget = renderer.target;
    await shots(person, renderer, 'rgba8');
    renderer.dispose();
  });
  await without(prototype, 'checkFramebufferStatus', check => function(which) {
    const format = this.getFramebufferAttachmentParameter(which, this.COLOR_ATTACHMENT0, this.FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE);
    return format === this.FLOAT ? this.FRAMEBUFFER_UNSUPPORTED : check.call(this, which);
  }, async () => {
    const renderer = new SplatRenderer(canvas());
    found.unsupportedTarget = renderer.target;
    renderer.dispose();
  });
  await without(HTMLCanvasElement.prototype, 'getContext', get => function(kind, ...rest) { return kind === 'webgl2' ? null : get.call(this, kind, ...rest); }, async () => {
    try {
      new SplatRenderer(canvas());
    } catch (error) {
      found.absent = { message: error.message, code: error.code };
    }
  });
}

/** Both eyes of a session that is mocked: a headset of 64 mm between its eyes, fields of view that differ to both sides, turned a little. */
async function eyes(person) {
  const renderer = new SplatRenderer(canvas(), { xrCompatible: true }), gl = renderer.context, width = 320, height = 360;
  const framebuffer = gl.createFramebuffer(), texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA8, 2 * width, height + 10);
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
  const c = Math.cos(0.3), s = Math.sin(0.3), near = 0.1;
  const eye = (aside, left, right) => ({  // tangents of the field of view; up and down are 0.9 and 0.7
    projectionMatrix: [2 / (right + left), 0, 0, 0, 0, 2 / 1.6, 0, 0, (right - left) / (right + left), (0.9 - 0.7) / 1.6, -1, -1, 0, 0, -2 * near, 0],
    transform: { inverse: { matrix: [c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0, -aside, -1.1, -2, 1] } },
  });
  const views = [eye(-0.032, 0.8, 0.6), eye(0.032, 0.6, 0.8)];
  const at = [{ x: 0, y: 10, width, height }, { x: width, y: 10, width, height }];
  const layer = { framebuffer, getViewport: view => at[views.indexOf(view)] };
  let known = true;
  const frame = { session: { renderState: { baseLayer: layer } }, getViewerPose: () => known ? { views } : null };
  const xr = new XREyes();
  person.setClip(0, 0.4);
  found.eyes = { drawn: xr.draw(renderer, person, frame, {}), width, height };
  gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  for (const [i, name] of ['left', 'right'].entries()) {
    const upsideDown = new Uint8Array(width * height * 4), rgba = new Uint8Array(width * height * 4), row = 4 * width;
    gl.readPixels(at[i].x, at[i].y, width, height, gl.RGBA, gl.UNSIGNED_BYTE, upsideDown);
    for (let y = 0; y < height; ++y) rgba.set(upsideDown.subarray((height - 1 - y) * row, (height - y) * row), y * row);
    await post(`/picture/eye-${name}.rgba`, rgba);
    await post(`/picture/eye-${name}-cpu.rgba`, person.draw(cameraOfXRView(views[i], width, height)));
  }
  // A point in front of the left eye, through WebGL's matrices and through the camera.
  const camera = cameraOfXRView(views[0], width, height), world = [0.3, 1.4, 0.2, 1], p = views[0].projectionMatrix, m = views[0].transform.inverse.matrix;
  const times = (a, v) => [0, 1, 2, 3].map(row => v.reduce((sum, value, k) => sum + a[4 * k + row] * value, 0)), clip = times(p, times(m, world));
  const [x, y, z] = [0, 1, 2].map(row => world.reduce((sum, value, k) => sum + camera.viewFromWorld[4 * row + k] * value, 0));
  found.eyes.off = Math.hypot((clip[0] / clip[3] + 1) / 2 * width - (camera.fx * x / z + camera.cx), (1 - clip[1] / clip[3]) / 2 * height - (camera.fy * y / z + camera.cy));
  known = false;
  found.eyes.unknown = xr.draw(renderer, person, frame, {});
  renderer.dispose();
}

/** Memory after many frames, and the time of their parts. */
async function many(person) {
  const renderer = new SplatRenderer(canvas()), view = { ...SHOTS[0], width: 120, height: 160 }, camera = person.lookAt(view);
  const frame = i => {
    person.setClip(0, i / 30);
    person.lookAt(view, camera);
    renderer.draw(person, camera);
  };
  const wasmBytes = () => person.project(camera).words.buffer.byteLength;
  const settle = async () => {
    renderer.read();
    await new Promise(done => setTimeout(done, 100));
    globalThis.gc();
    return performance.memory.usedJSHeapSize;
  };
  for (let i = 0; i < 100; ++i) frame(i);
  const heap = await settle(), wasm = wasmBytes();
  let least = Infinity, most = 0, half = 0;
  for (let i = 0; i < FRAMES; ++i) {
    frame(i);
    if (i % 20 === 19) await new Promise(requestAnimationFrame);  // the device keeps up, as on a page
    if (i === FRAMES / 2 - 1) half = await settle();
    if (i === FRAMES / 2) least = performance.memory.usedJSHeapSize;
    if (i > FRAMES / 2) most = Math.max(most, performance.memory.usedJSHeapSize);
  }
  const end = await settle();
  found.growth = { heap: end - heap, later: end - half, wasm: wasmBytes() - wasm, garbage: most - least, frames: FRAMES };
  found.uploadedBytes = renderer.uploadedBytes;
  found.splats = person.project(camera).counts[0];
  view.width = 480, view.height = 640;
  frame(0);
  // draw() projects too; its time is taken off.
  const pose = [], submit = [], whole = [], project = person.project.bind(person);
  let spent = 0;
  person.project = one => {
    const t = performance.now(), made = project(one);
    spent = performance.now() - t;
    return made;
  };
  for (let i = 0; i < TIMED; ++i) {
    const t0 = performance.now();
    person.setClip(0, i / 30);
    const t1 = performance.now();
    renderer.draw(person, person.lookAt(view, camera));
    const t2 = performance.now();
    pose.push(t1 - t0 + spent), submit.push(t2 - t1 - spent);
    renderer.read();
    whole.push(performance.now() - t0);
  }
  found.ms = { project: median(pose), submit: median(submit), whole: median(whole) };
  person.project = project;
  found.parts = [0, 60000, 20000].map(splatBudget => {
    person.setDetail({ splatBudget });
    const timed = work => median(Array.from({ length: TIMED }, (_, i) => {
      const t = performance.now();
      person.setClip(0, i / 30);
      work();
      return performance.now() - t;
    }));
    return { splatBudget, splats: person.project(camera).counts[0], projectMs: timed(() => person.project(camera)), meshMs: timed(() => person.posedMesh()) };
  });
  person.setDetail();
  renderer.dispose();
}

try {
  const person = await load();
  const renderer = new SplatRenderer(canvas());
  found.target = renderer.target;
  await shots(person, renderer, 'webgl');
  renderer.dispose();
  await kit();
  await lostDevice(person);
  await refused(person);
  await eyes(person);
  await many(person);
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
