// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: opens each file of /work/viewers/files.json in the viewer that the address names, draws it from the cameras of
// viewers_shots.mjs over white, and posts the pictures. What a viewer cannot open is an answer too.
import { HEIGHT, shotsOf, WIDTH } from './viewers_shots.mjs';

const post = (path, body) => fetch(path, { method: 'POST', body });
const pause = ms => new Promise(done => setTimeout(done, ms));
const degrees = radians => radians * 180 / Math.PI;
const LONGEST_LOAD_MS = 40000, LONGEST_SORT_MS = 60000;

/** Pixels of a canvas that has just been drawn, over white. */
function pixelsOf(canvas) {
  const copy = new OffscreenCanvas(WIDTH, HEIGHT), to = copy.getContext('2d');
  to.fillStyle = 'white';
  to.fillRect(0, 0, WIDTH, HEIGHT);
  to.drawImage(canvas, 0, 0);
  return new Uint8Array(to.getImageData(0, 0, WIDTH, HEIGHT).data.buffer);
}

function newCanvas() {
  const canvas = document.createElement('canvas');
  canvas.width = WIDTH, canvas.height = HEIGHT;
  document.querySelector('main').append(canvas);
  return canvas;
}

async function threeScene(THREE, renderer) {
  const scene = new THREE.Scene(), camera = new THREE.PerspectiveCamera(40, WIDTH / HEIGHT, 0.05, 100);
  scene.background = new THREE.Color(0xffffff);
  renderer.setSize(WIDTH, HEIGHT, false);
  const aim = shot => {
    camera.fov = degrees(shot.fovY);
    camera.position.set(...shot.eye);
    camera.lookAt(...shot.target);
    camera.updateProjectionMatrix();
  };
  return { scene, draw: shot => (aim(shot), renderer.render(scene, camera), renderer.domElement) };
}

const KINDS = { three: ['mesh'], 'three-splats': ['splats'], spark: ['splats'], playcanvas: ['splats', 'mesh'], babylon: ['splats', 'mesh'] };

/** Each returns {draw(shot) → canvas, isSorting(), end()}; without isSorting it has sorted when 0.4 s have passed. */
const VIEWERS = {
  async three({ url }) {
    const THREE = await import('three'), { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
    const renderer = new THREE.WebGLRenderer({ antialias: true, canvas: newCanvas() }), { scene, draw } = await threeScene(THREE, renderer);
    scene.add((await new GLTFLoader().loadAsync(url)).scene);
    return { draw, end: () => renderer.dispose() };
  },

  // three.js' own splats need its WebGPURenderer, which falls back to WebGL2.
  async 'three-splats'({ url, name }) {
    const THREE = await import('three/webgpu');
    const renderer = new THREE.WebGPURenderer({ antialias: false, forceWebGL: true, canvas: newCanvas() });
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace;  // the colours of splats are those of the screen already
    await renderer.init();
    const { scene, draw } = await threeScene(THREE, renderer), { GaussianSplat } = await import('three/addons/objects/GaussianSplat.js');
    if (name.endsWith('.glb')) {
      const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
      const { GLTFGaussianSplatLoaderExtension } = await import('three/addons/loaders/GLTFGaussianSplatLoaderExtension.js');
      const loader = new GLTFLoader();
      loader.register(parser => new GLTFGaussianSplatLoaderExtension(parser));
      scene.add((await loader.loadAsync(url)).scene);
    } else {
      const [file, loader] = name.endsWith('.spz') ? ['SPZLoader', 'SPZLoader'] : ['GaussianSplatPLYLoader', 'GaussianSplatPLYLoader'];
      const { [loader]: Loader } = await import(`three/addons/loaders/${file}.js`);
      scene.add(new GaussianSplat(await new Loader().loadAsync(url)));
    }
    return { draw, end: () => renderer.dispose() };
  },

  async spark({ url }) {
    const THREE = await import('three'), { SparkRenderer, SplatMesh } = await import('spark');
    const renderer = new THREE.WebGLRenderer({ antialias: false, canvas: newCanvas() }), { scene, draw } = await threeScene(THREE, renderer);
    const mesh = new SplatMesh({ url });
    const splats = new SparkRenderer({ renderer });
    scene.add(splats, mesh);
    await mesh.initialized;
    return { draw, isSorting: () => splats.sorting || splats.sortDirty, end: () => (mesh.dispose(), renderer.dispose()) };
  },

  async playcanvas({ url, kind, name }) {
    const pc = await import('playcanvas'), canvas = newCanvas();
    const app = new pc.Application(canvas, { graphicsDeviceOptions: { antialias: kind === 'mesh', alpha: false, preserveDrawingBuffer: true } });
    app.setCanvasFillMode(pc.FILLMODE_NONE, WIDTH, HEIGHT);
    app.setCanvasResolution(pc.RESOLUTION_FIXED, WIDTH, HEIGHT);
    const asset = new pc.Asset(name, kind === 'mesh' ? 'container' : 'gsplat', { url });
    await new Promise((done, fail) => {
      asset.once('load', done), asset.once('error', message => fail(new Error(message)));
      app.assets.add(asset), app.assets.load(asset);
    });
    let person = new pc.Entity();
    if (kind === 'mesh') person = asset.resource.instantiateRenderEntity();
    else person.addComponent('gsplat', { asset });
    const camera = new pc.Entity();
    camera.addComponent('camera', { nearClip: 0.05, farClip: 100, clearColor: new pc.Color(1, 1, 1) });
    app.root.addChild(person), app.root.addChild(camera);
    const draw = shot => {
      camera.camera.fov = degrees(shot.fovY);
      camera.setPosition(...shot.eye);
      camera.lookAt(...shot.target);
      app.update(1 / 30), app.render();
      return canvas;
    };
    return { draw, end: () => app.destroy() };
  },

  async babylon({ url, name }) {
    for (const script of ['/babylon/babylon.js', '/babylon-loaders/babylonjs.loaders.min.js']) {
      if (document.querySelector(`script[src="${script}"]`)) continue;
      await new Promise((done, fail) => {
        const tag = Object.assign(document.createElement('script'), { src: script, onload: done, onerror: () => fail(new Error(`no ${script}`)) });
        document.head.append(tag);
      });
    }
    const { BABYLON } = globalThis, canvas = newCanvas(), engine = new BABYLON.Engine(canvas, true, { preserveDrawingBuffer: true });
    const scene = new BABYLON.Scene(engine);
    scene.clearColor = new BABYLON.Color4(1, 1, 1, 1);
    const camera = new BABYLON.FreeCamera('camera', BABYLON.Vector3.Zero(), scene);
    camera.minZ = 0.05, camera.maxZ = 100;
    await BABYLON.AppendSceneAsync(url, scene, { pluginExtension: name.slice(name.lastIndexOf('.')) });
    scene.stopAllAnimations?.();
    for (const group of scene.animationGroups) group.stop();
    for (const skeleton of scene.skeletons) skeleton.returnToRest();
    const leftHanded = ([x, y, z]) => new BABYLON.Vector3(-x, y, z);  // as its loader turns glTF
    const draw = shot => {
      camera.fov = shot.fovY;
      camera.position = leftHanded(shot.eye);
      camera.setTarget(leftHanded(shot.target));
      scene.render();
      return canvas;
    };
    return { draw, end: () => engine.dispose() };
  },
};

/** The pictures of one file, or why there are none. */
async function show(viewer, file) {
  let shown;
  try {
    const late = new Promise((_, fail) => setTimeout(() => fail(new Error('it did not finish loading')), LONGEST_LOAD_MS));
    shown = await Promise.race([VIEWERS[viewer](file), late]);
  } catch (error) {
    return { cannot: String(error?.message ?? error).slice(0, 200) };
  }
  shown.draw(shotsOf(viewer)[0]);
  await pause(1500);  // shaders and textures are made
  for (const shot of shotsOf(viewer)) {
    const late = performance.now() + LONGEST_SORT_MS;
    shown.draw(shot);
    do await pause(400);  // splats are sorted meanwhile
    while (shown.isSorting?.() && performance.now() < late);
    await post(`/picture/${file.label}-${shot.name}.rgba`, pixelsOf(shown.draw(shot)));
  }
  shown.end();
  document.querySelector('main').replaceChildren();
  return {};
}

const viewer = new URLSearchParams(location.search).get('viewer'), found = { viewer, files: {} };
try {
  const files = await (await fetch('/work/viewers/files.json')).json();
  for (const file of files.filter(({ kind }) => KINDS[viewer].includes(kind))) found.files[file.label] = await show(viewer, file);
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
