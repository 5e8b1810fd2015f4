// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: one posed person, drawn by Doppel, by Spark and by the PlayCanvas engine in turn, from a camera that goes around
// them. Doppel poses in every frame; the others draw the splats that `doppel export` wrote, and sort in a worker, which nobody waits for.
import * as pc from 'playcanvas';
import { SparkRenderer, SplatMesh } from 'spark';
import * as THREE from 'three';
import { Doppel } from '../../platform/web/doppel.js';
import { DoppelGroup } from '../../platform/web/three-group.js';

const WIDTH = 480, HEIGHT = 640, FRAMES = 3, FOV = 40, DISTANCE = 3.2, STEP = 0.05;
const found = { size: `${WIDTH} × ${HEIGHT}`, frames: FRAMES, peers: [] };
const post = (path, body) => fetch(path, { method: 'POST', body });
const pause = () => new Promise(done => setTimeout(done, 200));
const eyeOf = i => [DISTANCE * Math.sin(STEP * i), 1, DISTANCE * Math.cos(STEP * i)];

/** draw(i): a frame. Its time ends when a pixel is there. */
async function measure(name, gl, draw) {
  const pixel = new Uint8Array(4), took = [];
  for (let i = -1; i < FRAMES; ++i) {
    const start = performance.now();
    draw(Math.max(0, i));
    gl.readPixels(WIDTH / 2, HEIGHT / 2, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    if (i >= 0) took.push(performance.now() - start);
    await pause();  // workers sort
  }
  draw(0);
  const rgba = new Uint8Array(4 * WIDTH * HEIGHT), upright = new Uint8Array(rgba.length), row = 4 * WIDTH;
  gl.readPixels(0, 0, WIDTH, HEIGHT, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
  for (let y = 0; y < HEIGHT; ++y) upright.set(rgba.subarray((HEIGHT - 1 - y) * row, (HEIGHT - y) * row), y * row);
  await post(`/picture/${name}.rgba`, upright);
  took.sort((a, b) => a - b);
  found.peers.push({ name, ms: took[FRAMES >> 1], least: took[0] });
}

function sceneOfThree() {
  const renderer = new THREE.WebGLRenderer({ antialias: false, alpha: true }), scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(FOV, WIDTH / HEIGHT, 0.1, 100);
  renderer.setSize(WIDTH, HEIGHT);
  scene.background = new THREE.Color(0xffffff);
  const draw = i => {
    camera.position.set(...eyeOf(i));
    camera.lookAt(0, 0.9, 0);
    renderer.render(scene, camera);
  };
  return { renderer, scene, draw };
}

async function doppel() {
  const { renderer, scene, draw } = sceneOfThree(), person = await Doppel.load('/work/person.glb', { module: '/module/doppel.wasm' });
  const group = new DoppelGroup(person), gl = renderer.getContext();
  scene.add(group);
  found.splats = person.splatCount;
  await measure('doppel', gl, i => {
    person.setClip(0, 0.4 + i / 30);
    draw(i);
  });
  group.dispose();
  person.dispose();
  renderer.dispose();
}

async function spark() {
  const { renderer, scene, draw } = sceneOfThree(), mesh = new SplatMesh({ url: '/work/person.ply' });
  scene.add(new SparkRenderer({ renderer }), mesh);
  await mesh.initialized;
  draw(0);
  await pause();
  await measure('spark', renderer.getContext(), draw);
  mesh.dispose();
  renderer.dispose();
}

async function playcanvas() {
  const canvas = document.createElement('canvas');
  canvas.width = WIDTH, canvas.height = HEIGHT;
  document.body.append(canvas);
  const app = new pc.Application(canvas, { graphicsDeviceOptions: { antialias: false, alpha: true } });
  app.setCanvasFillMode(pc.FILLMODE_NONE, WIDTH, HEIGHT);
  app.setCanvasResolution(pc.RESOLUTION_FIXED, WIDTH, HEIGHT);
  const asset = new pc.Asset('person', 'gsplat', { url: '/work/person.ply' });
  await new Promise((done, fail) => {
    asset.once('load', done), asset.once('error', fail);
    app.assets.add(asset), app.assets.load(asset);
  });
  const person = new pc.Entity(), camera = new pc.Entity();
  person.addComponent('gsplat', { asset });
  camera.addComponent('camera', { fov: FOV, nearClip: 0.1, farClip: 100, clearColor: new pc.Color(1, 1, 1) });
  app.root.addChild(person), app.root.addChild(camera);
  const draw = i => {
    camera.setPosition(...eyeOf(i));
    camera.lookAt(0, 0.9, 0);
    app.update(1 / 30);
    app.render();
  };
  draw(0);
  await pause();
  await measure('playcanvas', app.graphicsDevice.gl, draw);
  app.destroy();
}

try {
  await doppel();
  await spark();
  await playcanvas();
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
