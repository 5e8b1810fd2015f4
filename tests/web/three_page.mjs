// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: persons in scenes of three.js. Posts pictures, and what their judge (three_test.mjs) needs to know of them.
import * as THREE from 'three';
import { Doppel } from '../../platform/web/doppel.js';
import { DoppelGroup } from '../../platform/web/three-group.js';

const MODULE = '/module/doppel.wasm', PERSON = '/work/person.glb', KIT = '/work/kit/';
const WIDTH = 320, HEIGHT = 400, FRAMES = 60, MOST_WINDOWS = 20, QUIET_BYTES = 12 * FRAMES;  // less than one object a frame
const found = { revision: THREE.REVISION, scenes: [] };
const post = (path, body) => fetch(path, { method: 'POST', body });
const event = (target, type) => new Promise(done => target.addEventListener(type, done, { once: true }));
const load = (source = PERSON) => Doppel.load(source, { module: MODULE });
const persons = await Promise.all([load(), load()]);

const rendererOf = (options = {}) => {
  const renderer = new THREE.WebGLRenderer({ alpha: true, antialias: false, ...options });
  renderer.setSize(WIDTH, HEIGHT);
  return renderer;
};
const camera = new THREE.PerspectiveCamera(40, WIDTH / HEIGHT, 0.1, 100);
camera.position.set(0.6, 1.3, 3.2);
camera.lookAt(0, 0.9, 0);

/** What the canvas shows: premultiplied, top row first. */
function read(renderer, width = renderer.domElement.width, height = renderer.domElement.height) {
  const gl = renderer.getContext(), row = 4 * width, upsideDown = new Uint8Array(row * height), rgba = new Uint8Array(row * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, upsideDown);
  for (let y = 0; y < height; ++y) rgba.set(upsideDown.subarray((height - 1 - y) * row, (height - y) * row), y * row);
  return rgba;
}
const rowsOf = matrix => [0, 1, 2].flatMap(row => [0, 1, 2, 3].map(column => matrix.elements[4 * column + row]));

/** The camera for dplRender, from where three puts three points: another way than the group's. */
function cameraNumbers(view, width, height) {
  view.updateMatrixWorld();
  const at = (x, y, z) => new THREE.Vector3(x, y, z).applyMatrix4(view.projectionMatrix), middle = at(0, 0, -1);
  const fx = (at(1, 0, -1).x - middle.x) * width / 2, fy = (at(0, 1, -1).y - middle.y) * height / 2;
  const inverse = rowsOf(new THREE.Matrix4().makeScale(1, -1, -1).multiply(view.matrixWorldInverse));
  return [width, height, fx, fy, (1 + middle.x) * width / 2, (1 - middle.y) * height / 2, ...inverse];
}

/** Posts a picture, and notes what dplRenderTogether is to draw of it. */
async function note(name, rgba, width, height, view, groups, more = {}) {
  await post(`/picture/${name}.rgba`, rgba);
  found.scenes.push({
    name, width, height, camera: cameraNumbers(view, width, height), sceneDepthM: 0,
    persons: groups.map(group => ({ clip: group.userData.clip, time: group.userData.time, transform: rowsOf(group.matrixWorld) })), ...more,
  });
}
function picture(name, renderer, scene, groups, { view = camera, ...more } = {}) {
  renderer.render(scene, view);
  const { width, height } = renderer.domElement;
  return note(name, read(renderer), width, height, view, groups, more);
}
/** A part of a picture; x, y: its upper left corner. */
function partOf(rgba, pitch, x, y, width, height) {
  const part = new Uint8Array(4 * width * height);
  for (let row = 0; row < height; ++row) {
    const from = 4 * ((y + row) * pitch + x);
    part.set(rgba.subarray(from, from + 4 * width), 4 * width * row);
  }
  return part;
}
function groupOf(person, clip, time) {
  const group = new DoppelGroup(person);
  person.setClip(clip, time);
  Object.assign(group.userData, { clip, time });
  group.userData.errors = [];
  group.addEventListener('error', ({ error }) => group.userData.errors.push({ message: error.message, code: error.code }));
  return group;
}
const box = (width, height, depth, colour, options = {}) =>
  new THREE.Mesh(new THREE.BoxGeometry(width, height, depth), new THREE.MeshBasicMaterial({ color: colour, ...options }));

/** Persons alone: on a canvas of their own, placed, seen off-centre, two among each other, in other sizes. */
async function alone() {
  const renderer = rendererOf(), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4);
  scene.add(ada);
  await picture('own-canvas', renderer, scene, [ada]);
  renderer.toneMapping = THREE.ACESFilmicToneMapping;
  await picture('tone-mapped', renderer, scene, [ada]);
  renderer.toneMapping = THREE.NoToneMapping;

  const parent = new THREE.Group();
  parent.position.set(0.2, -0.1, -0.4), parent.rotation.y = 0.7;
  scene.add(parent);
  parent.add(ada);
  ada.position.set(0.1, 0.2, 0.3), ada.rotation.set(0.2, -0.3, 0.4), ada.scale.setScalar(1.3);
  const offCentre = camera.clone();
  offCentre.setViewOffset(640, 500, 190, 70, WIDTH, HEIGHT);
  offCentre.filmOffset = 3;
  offCentre.updateProjectionMatrix();
  await picture('placed-off-centre', renderer, scene, [ada], { view: offCentre });

  const bob = groupOf(persons[1], 1, 2.5);
  scene.add(ada, bob);
  ada.position.set(-0.06, 0, 0), ada.rotation.set(0, 0, 0), ada.scale.setScalar(1);
  bob.position.set(0.08, 0, 0.03), bob.rotation.set(0, 2.2, 0);
  await picture('two-among-each-other', renderer, scene, [ada, bob]);
  bob.position.set(0.9, 0, -1.2);
  await picture('two-apart', renderer, scene, [bob, ada]);
  bob.visible = false;
  renderer.setSize(211, 333);
  camera.aspect = 211 / 333, camera.updateProjectionMatrix();
  await picture('smaller', renderer, scene, [ada]);
  renderer.setPixelRatio(2);
  await picture('pixel-ratio-2', renderer, scene, [ada]);
  renderer.setPixelRatio(1);
  renderer.setSize(WIDTH, HEIGHT);
  camera.aspect = WIDTH / HEIGHT, camera.updateProjectionMatrix();
  await picture('larger-again', renderer, scene, [ada]);
  for (const group of [ada, bob]) group.dispose();
  renderer.dispose();
}

/** On devices without targets of half floats, as they say or as it turns out. */
async function bytes() {
  const prototype = WebGL2RenderingContext.prototype, { getExtension, checkFramebufferStatus } = prototype;
  const refuse = [['bytes', () => {
    prototype.getExtension = function(name) { return /color_buffer/.test(name) ? null : getExtension.call(this, name); };
  }], ['bytes-later', () => {
    prototype.checkFramebufferStatus = function(which) {
      const kind = this.getFramebufferAttachmentParameter(which, this.COLOR_ATTACHMENT0, this.FRAMEBUFFER_ATTACHMENT_COMPONENT_TYPE);
      return kind === this.FLOAT ? this.FRAMEBUFFER_UNSUPPORTED : checkFramebufferStatus.call(this, which);
    };
  }]];
  for (const [name, begin] of refuse) {
    begin();
    const renderer = rendererOf(), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4);
    scene.add(ada);
    await picture(name, renderer, scene, [ada], { bytes: true });
    Object.assign(prototype, { getExtension, checkFramebufferStatus });
    ada.dispose();
    renderer.dispose();
  }
}

const FRONT = 0x2060c0, BEHIND = 0xc04020;
/** Among meshes. front, behind, through: boxes and planes that face the camera, with their distance. */
async function among(prefix, options) {
  const renderer = rendererOf(options), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4);
  scene.background = new THREE.Color(0x405060);
  scene.add(ada);
  const view = camera.clone();
  view.position.set(0, 0.9, 3.2);
  view.lookAt(0, 0.9, 0);
  await picture(`${prefix}background`, renderer, scene, [ada], { view, background: 0x405060 });
  const front = box(0.5, 0.5, 0.1, FRONT), behind = box(1, 3, 0.1, BEHIND);
  front.position.set(0.2, 0.6, 1), behind.position.set(0, 1, -1);
  scene.add(front, behind);
  await picture(`${prefix}front-and-behind`, renderer, scene, [ada], { view, background: 0x405060, front: FRONT, behind: BEHIND });
  scene.remove(front, behind);
  const through = new THREE.Mesh(new THREE.PlaneGeometry(8, 8), new THREE.MeshBasicMaterial({ color: BEHIND }));
  through.position.z = 0.02;
  scene.add(through);
  await picture(`${prefix}plane-through`, renderer, scene, [ada], { view, sceneDepthM: 3.18, background: BEHIND });
  through.position.z = -1;
  through.material = new THREE.MeshBasicMaterial({ color: BEHIND, transparent: true, opacity: 0.5 });
  await picture(`${prefix}transparent-behind`, renderer, scene, [ada], { view, background: 0x405060, over: BEHIND });
  through.position.z = 1;
  await picture(`${prefix}transparent-before`, renderer, scene, [ada], { view, background: 0x405060, over: BEHIND });
  through.material = new THREE.MeshPhysicalMaterial({ transmission: 1, roughness: 0, thickness: 0 });
  const glass = () => {
    renderer.render(scene, view);
    return read(renderer);
  };
  const seen = glass();
  ada.visible = false;
  const alone = glass();
  found[`${prefix}throughGlass`] = seen.filter((value, i) => Math.abs(value - alone[i]) > 20).length;
  ada.dispose();
  renderer.dispose();
}

/** Into a target of linear light, and into a part of the canvas. */
async function elsewhere() {
  const renderer = rendererOf(), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4);
  scene.add(ada);
  const target = new THREE.WebGLRenderTarget(WIDTH, HEIGHT, { type: THREE.FloatType });
  renderer.setRenderTarget(target);
  renderer.clear();
  renderer.render(scene, camera);
  const linear = new Float32Array(4 * WIDTH * HEIGHT);
  renderer.readRenderTargetPixels(target, 0, 0, WIDTH, HEIGHT, linear);
  renderer.setRenderTarget(null);
  const display = new Uint8Array(linear.length);  // as dplRender has it: display values, premultiplied
  for (let y = 0; y < HEIGHT; ++y)
    for (let x = 0; x < WIDTH; ++x) {
      const from = 4 * ((HEIGHT - 1 - y) * WIDTH + x), to = 4 * (y * WIDTH + x), alpha = linear[from + 3];
      for (let c = 0; c < 3; ++c) {
        const light = alpha > 0 ? linear[from + c] / alpha : 0;
        display[to + c] = Math.round(255 * alpha * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
      }
      display[to + 3] = Math.round(255 * alpha);
    }
  await note('linear-target', display, WIDTH, HEIGHT, camera, [ada]);
  target.dispose();

  renderer.setSize(WIDTH + 70, HEIGHT + 50);
  renderer.setViewport(40, 30, WIDTH, HEIGHT);
  renderer.render(scene, camera);
  const whole = read(renderer);
  await note('viewport', partOf(whole, WIDTH + 70, 40, 20, WIDTH, HEIGHT), WIDTH, HEIGHT, camera, [ada]);  // 20 of 50 rows lie above
  const eyes = [-0.4, 0.4].map((x, i) => {
    const eye = camera.clone();
    eye.position.x += x;
    eye.aspect = 160 / HEIGHT, eye.updateProjectionMatrix();
    eye.viewport = new THREE.Vector4(160 * i, 0, 160, HEIGHT);
    eye.updateMatrixWorld();
    return eye;
  });
  renderer.setSize(WIDTH, HEIGHT);
  renderer.render(scene, new THREE.ArrayCamera(eyes));
  const both = read(renderer);
  for (const [i, eye] of eyes.entries())
    await note(`array-camera-${i}`, partOf(both, WIDTH, 160 * i, 0, 160, HEIGHT), 160, HEIGHT, eye, [ada]);
  ada.dispose();
  renderer.dispose();
}

/** Four samples a pixel, alone and beside a person of one: against the module, which a test of its own compares. */
async function samples() {
  const renderer = rendererOf(), scene = new THREE.Scene(), { cases } = await (await fetch(`${KIT}kit.json`)).json();
  const one = cases.find(c => c.name === 'coarser-than-trained'), person = await load(KIT + one.avatar), c = one.views[0];
  person.setPose(one.rotations.flat(), one.root_translation);
  const group = new DoppelGroup(person), view = new THREE.PerspectiveCamera();
  const w = view.projectionMatrix, near = 0.01, far = 100;
  w.set(2 * c.fx / c.width_px, 0, 1 - 2 * c.cx / c.width_px, 0, 0, 2 * c.fy / c.height_px, 2 * c.cy / c.height_px - 1, 0,
    0, 0, -(far + near) / (far - near), -2 * far * near / (far - near), 0, 0, -1, 0);
  const m = c.view_from_world, rows = [...m.slice(0, 4), ...m.slice(4, 8).map(v => -v), ...m.slice(8, 12).map(v => -v)];
  new THREE.Matrix4().set(...rows, 0, 0, 0, 1).invert().decompose(view.position, view.quaternion, view.scale);
  scene.add(group);
  renderer.setSize(c.width_px, c.height_px);
  renderer.render(scene, view);
  await post('/picture/samples.rgba', read(renderer));
  const same = { width: c.width_px, height: c.height_px, fx: c.fx, fy: c.fy, cx: c.cx, cy: c.cy, viewFromWorld: m };
  await post('/picture/samples-cpu.rgba', person.draw(same));
  found.samples = { width: c.width_px, height: c.height_px };
  group.dispose();
  person.dispose();
  renderer.dispose();
}

/** Whether points of the posed mesh have their shadow where the light puts it. */
async function shadow() {
  const renderer = rendererOf({ antialias: true }), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4);
  renderer.shadowMap.enabled = true;
  scene.background = new THREE.Color(0x8090a0);
  const light = new THREE.DirectionalLight(0xffffff, 2);
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(8, 8), new THREE.MeshLambertMaterial({ color: 0x908880 }));
  floor.rotation.x = -Math.PI / 2, floor.receiveShadow = true;
  light.position.set(3, 4, 1.5), light.castShadow = true;
  Object.assign(light.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3, near: 0.5, far: 12 });
  light.shadow.mapSize.set(1024, 1024);
  scene.add(ada, light, new THREE.AmbientLight(0xffffff, 0.6), floor);
  const view = camera.clone();
  view.position.set(0.2, 3, 3);
  view.lookAt(-0.4, 0.3, 0);
  const shot = async () => {
    renderer.render(scene, view);
    return read(renderer);
  };
  found.shadow = { at: [] };
  for (const [i, [x, turn, time]] of [[0, 0, 0.4], [-0.5, 1.5, 1.1]].entries()) {
    persons[0].setClip(0, time);
    ada.position.x = x, ada.rotation.y = turn;
    ada.castShadow = false;
    const without = await shot();
    ada.castShadow = true;
    const cast = await shot(), { positions } = persons[0].posedMesh(), told = { asked: 0, dark: 0, opposite: 0 };
    await post(`/picture/shadow-${i}.rgba`, cast);
    /** Whether the floor is darker where the light, or one on the other side, puts a point of the person. */
    const isDark = (v, side) => {
      const p = new THREE.Vector3(positions[v], positions[v + 1], positions[v + 2]).applyMatrix4(ada.matrixWorld);
      const along = -p.y / light.position.y;
      p.set(p.x + side * along * light.position.x, 0, p.z + side * along * light.position.z).project(view);
      const column = Math.floor((p.x + 1) / 2 * WIDTH), row = Math.floor((1 - p.y) / 2 * HEIGHT), at = 4 * (row * WIDTH + column);
      return column >= 0 && column < WIDTH && row >= 0 && row < HEIGHT ? cast[at] < 0.8 * without[at] : null;
    };
    for (let v = 0; v < positions.length; v += 3 * 37) {
      if (isDark(v, 1) === null || isDark(v, -1) === null) continue;
      ++told.asked, told.dark += isDark(v, 1), told.opposite += isDark(v, -1);
    }
    found.shadow.at.push(told);
  }
  ada.castShadow = false;
  ada.visible = false;
  const empty = await shot();
  ada.visible = true, ada.castShadow = true;
  await shot();
  ada.visible = false;
  const again = await shot();
  found.shadow.gone = empty.every((value, i) => value === again[i]);
  found.shadow.errors = ada.userData.errors;
  ada.dispose();
  renderer.dispose();
}

/** Matrices and cameras that cannot be; the other person is drawn all the same. */
async function refused() {
  const renderer = rendererOf(), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4), bob = groupOf(persons[1], 1, 2.5);
  scene.add(ada, bob);
  bob.position.set(0.4, 0, 0);
  const covered = view => {
    renderer.render(scene, view ?? camera);
    return read(renderer).filter((value, i) => i % 4 === 3 && value > 0).length;
  };
  const both = covered();
  ada.position.x = NaN;
  const one = [covered(), covered()];
  ada.position.x = 0, ada.scale.set(1, 2, 1);
  one.push(covered());
  ada.scale.set(-1, 1, 1);
  one.push(covered());
  ada.scale.set(1, 1, 1);
  const again = covered(), fine = ada.error;
  const orthographic = covered(new THREE.OrthographicCamera(-2, 2, 2, -2, 0.1, 10)), bent = camera.clone();
  bent.position.x = NaN;
  const nowhere = covered(bent);
  scene.overrideMaterial = new THREE.MeshNormalMaterial();  // a pass of an effect: persons are not in it
  const overridden = covered();
  scene.overrideMaterial = null;
  found.refused = { both, overridden, one, again, fine, orthographic, nowhere, ada: ada.userData.errors, bob: bob.userData.errors };
  const thrown = body => {
    try {
      body();
      return '';
    } catch (error) {
      return `${error.code}: ${error.message}`;
    }
  };
  found.refused.thrown = [() => new DoppelGroup(persons[0]), () => new DoppelGroup({}), () => ada.clone()].map(thrown);
  ada.dispose(), bob.dispose();
  renderer.dispose();
  const logarithmic = rendererOf({ logarithmicDepthBuffer: true }), cy = groupOf(persons[0], 0, 0.4);
  logarithmic.render(new THREE.Scene().add(cy), camera);
  found.refused.logarithmic = cy.userData.errors;
  cy.dispose();
  logarithmic.dispose();
}

async function lostDevice() {
  const renderer = rendererOf(), scene = new THREE.Scene(), ada = groupOf(persons[0], 0, 0.4);
  const device = renderer.getContext().getExtension('WEBGL_lose_context');
  scene.add(ada);
  renderer.render(scene, camera);
  const before = read(renderer);
  device.loseContext();
  await event(renderer.domElement, 'webglcontextlost');
  renderer.render(scene, camera);
  await new Promise(done => setTimeout(done));
  device.restoreContext();
  await event(renderer.domElement, 'webglcontextrestored');
  renderer.render(scene, camera);
  const after = read(renderer);
  const same = after.every((value, i) => value === before[i]), covered = before.filter(value => value > 0).length;
  found.lost = { same, covered, errors: ada.userData.errors };
  ada.dispose();
  renderer.dispose();
}

/** Memory after many frames, beside the same without persons, and what is left after dispose(). Few splats: SwiftShader is slow. */
async function many() {
  const renderer = rendererOf(), scene = new THREE.Scene(), view = camera.clone(), light = new THREE.DirectionalLight();
  renderer.setSize(60, 80);
  renderer.shadowMap.enabled = true;
  light.castShadow = true;
  light.shadow.mapSize.set(64, 64);
  const floor = box(4, 0.1, 4, 0x808080), glass = box(1, 1, 1, 0xffffff, { transparent: true, opacity: 0.3 });
  floor.castShadow = true;
  scene.add(floor, glass, light);
  renderer.render(scene, view);
  const held = () => ({ ...renderer.info.memory, programs: renderer.info.programs.length }), before = held();
  const groups = persons.map((person, i) => groupOf(person, i, 0));
  for (const group of groups) group.castShadow = true, group.person.setDetail({ splatBudget: 500 });
  scene.add(...groups);
  groups[1].position.x = 0.3;
  const settle = async () => {
    read(renderer);
    await new Promise(done => setTimeout(done, 100));
    globalThis.gc();
    return performance.memory.usedJSHeapSize;
  };
  /** Of windows of frames: the median garbage a frame, and the least that stayed, bytes. Compilers add to a window now and then, and where
   *  the collector found older garbage, much is gone: such a window says nothing. It ends when a window is quiet. */
  const measure = async () => {
    const garbage = [];
    let least = Infinity;
    for (let window = 0; window < MOST_WINDOWS && (window < 3 || least >= QUIET_BYTES); ++window) {
      const before = await settle();
      for (let i = 0; i < FRAMES; ++i) {
        persons[0].setClip(0, i / 30);
        groups[0].position.z = 0.01 * i;
        renderer.render(scene, view);
      }
      garbage.push((performance.memory.usedJSHeapSize - before) / FRAMES);
      const grown = await settle() - before;
      if (grown > -QUIET_BYTES) least = Math.min(least, grown);
    }
    return { garbage: garbage.sort((a, b) => a - b)[garbage.length >> 1], grown: least };
  };
  const drawn = await measure(), during = held();
  for (const group of groups) group.visible = false;
  const hidden = await measure();
  for (const group of groups) group.dispose();
  renderer.render(scene, view);
  found.growth = { frames: FRAMES, drawn, hidden, before, during, after: held() };
  renderer.dispose();
  for (const person of persons) person.setDetail();
}

try {
  await alone();
  await bytes();
  await among('');
  await among('antialias-', { antialias: true });
  await elsewhere();
  await samples();
  await shadow();
  await refused();
  await lostDevice();
  await many();
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
