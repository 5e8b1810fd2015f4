// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: other people's viewers, opened with a file or with a live person, and drawn over white.
import { HEIGHT, WIDTH } from './viewers_shots.mjs';

const degrees = radians => radians * 180 / Math.PI;

/** Pixels of a canvas that has just been drawn, over white. */
export function pixelsOf(canvas) {
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
  const draw = (shot, before) => (aim(shot), before?.(camera), renderer.render(scene, camera), renderer.domElement);
  return { scene, draw };
}

export const KINDS = { three: ['mesh'], 'three-vrm': ['vrm'], 'three-splats': ['splats'], spark: ['splats'], playcanvas: ['splats', 'mesh'], babylon: ['splats', 'mesh'] };

/** Each opens a file {url, name, kind}, or shows the live person of {person}. Returns {draw(shot) → canvas, isSorting(), end()}; without
 *  isSorting it has sorted when 0.4 s have passed, with sortsAtOnce at once. express(face of FACES), where the viewer knows morph targets:
 *  shows it, or false where the file has none. */
export const VIEWERS = {
  async three({ url }) {
    const THREE = await import('three'), { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
    const renderer = new THREE.WebGLRenderer({ antialias: true, canvas: newCanvas() }), { scene, draw } = await threeScene(THREE, renderer);
    const { DRACOLoader } = await import('three/addons/loaders/DRACOLoader.js');
    const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
    const draco = new DRACOLoader().setDecoderPath('/three/examples/jsm/libs/draco/gltf/');
    const model = (await new GLTFLoader().setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder).loadAsync(url)).scene;
    scene.add(model);
    const express = ({ weights }) => {
      let found = false;
      model.traverse(({ morphTargetDictionary: numbers, morphTargetInfluences: influences }) => {
        if (!numbers) return;
        found = true;
        influences.fill(0);
        for (const [name, weight] of Object.entries(weights)) if (name in numbers) influences[numbers[name]] = weight;
      });
      return found;
    };
    return { draw, express, end: () => (draco.dispose(), renderer.dispose()) };
  },

  // A VRM stands in its T-pose.
  async 'three-vrm'({ url }) {
    const THREE = await import('three'), { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
    const { VRMLoaderPlugin } = await import('three-vrm');
    const renderer = new THREE.WebGLRenderer({ antialias: true, canvas: newCanvas() }), { scene, draw } = await threeScene(THREE, renderer);
    const loader = new GLTFLoader();
    loader.register(parser => new VRMLoaderPlugin(parser));
    const { vrm } = (await loader.loadAsync(url)).userData;
    if (!vrm?.humanoid?.getNormalizedBoneNode('hips')) throw new Error('it sees no VRM humanoid');
    vrm.update(1 / 30);
    scene.add(vrm.scene);
    const express = ({ vrm: weights }) => {
      const manager = vrm.expressionManager;
      for (const name of Object.keys(manager?.expressionMap ?? {})) manager.setValue(name, 0);
      for (const [name, weight] of Object.entries(weights)) {
        if (!manager?.getExpression(name)) return false;
        manager.setValue(name, weight);
      }
      vrm.update(1 / 30);
      return true;
    };
    return { draw, express, end: () => renderer.dispose() };
  },

  // three.js' own splats need its WebGPURenderer, which falls back to WebGL2.
  async 'three-splats'({ url, name, person }) {
    const THREE = await import('three/webgpu');
    const renderer = new THREE.WebGPURenderer({ antialias: false, forceWebGL: true, canvas: newCanvas() });
    renderer.outputColorSpace = THREE.LinearSRGBColorSpace;  // the colours of splats are those of the screen already
    await renderer.init();
    const { scene, draw } = await threeScene(THREE, renderer), { GaussianSplat } = await import('three/addons/objects/GaussianSplat.js');
    if (person) {
      const { DoppelSplats } = await import('../../platform/web/three-splats.js'), live = new DoppelSplats(person);
      scene.add(live);
      return { sortsAtOnce: true, draw: shot => draw(shot, camera => live.update(camera)), end: () => (live.dispose(), renderer.dispose()) };
    }
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
    return { sortsAtOnce: true, draw, end: () => renderer.dispose() };
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

  async playcanvas({ url, kind, name, person }) {
    const pc = await import('playcanvas'), canvas = newCanvas();
    const app = new pc.Application(canvas, { graphicsDeviceOptions: { antialias: kind === 'mesh', alpha: false, preserveDrawingBuffer: true } });
    app.setCanvasFillMode(pc.FILLMODE_NONE, WIDTH, HEIGHT);
    app.setCanvasResolution(pc.RESOLUTION_FIXED, WIDTH, HEIGHT);
    let entity = new pc.Entity(), live;
    if (person) {
      const { DoppelContainer } = await import('../../platform/web/playcanvas-splats.js');
      live = new DoppelContainer(app.graphicsDevice, person);
      entity.addComponent('gsplat', { resource: live });
    } else {
      const asset = new pc.Asset(name, kind === 'mesh' ? 'container' : 'gsplat', { url });
      await new Promise((done, fail) => {
        asset.once('load', done), asset.once('error', message => fail(new Error(message)));
        app.assets.add(asset), app.assets.load(asset);
      });
      if (kind === 'mesh') entity = asset.resource.instantiateRenderEntity();
      else entity.addComponent('gsplat', { asset });
    }
    const camera = new pc.Entity();
    camera.addComponent('camera', { nearClip: 0.05, farClip: 100, clearColor: new pc.Color(1, 1, 1) });
    app.root.addChild(entity), app.root.addChild(camera);
    const draw = shot => {
      camera.camera.fov = degrees(shot.fovY);
      camera.setPosition(...shot.eye);
      camera.lookAt(...shot.target);
      live?.pose(entity, camera.getPosition());
      app.update(1 / 30), app.render();
      return canvas;
    };
    return { draw, end: () => app.destroy() };
  },

  async babylon({ url, name, person }) {
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
    let live;
    if (person) {
      const { BabylonSplats } = await import('../../platform/web/babylon-splats.js');
      live = new BabylonSplats(person, new BABYLON.GaussianSplattingMesh('person', null, scene));
    } else {
      await BABYLON.AppendSceneAsync(url, scene, { pluginExtension: name.slice(name.lastIndexOf('.')) });
    }
    scene.stopAllAnimations?.();
    for (const group of scene.animationGroups) group.stop();
    for (const skeleton of scene.skeletons) skeleton.returnToRest();
    const leftHanded = ([x, y, z]) => new BABYLON.Vector3(-x, y, z);  // as its loader turns glTF
    const draw = shot => {
      camera.fov = shot.fovY;
      camera.position = leftHanded(shot.eye);
      camera.setTarget(leftHanded(shot.target));
      camera.computeWorldMatrix(true);
      live?.update(camera);
      scene.render();
      return canvas;
    };
    return { draw, end: () => engine.dispose() };
  },
};
