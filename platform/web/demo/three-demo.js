// SPDX-License-Identifier: Apache-2.0
import {
  AmbientLight, BoxGeometry, CircleGeometry, Color, DirectionalLight, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { Doppel } from '../doppel.js';
import { DoppelGroup } from '../three-group.js';

const canvas = document.querySelector('#scene'), said = document.querySelector('#said');
const renderer = new WebGLRenderer({ canvas, antialias: true }), scene = new Scene(), camera = new PerspectiveCamera(40, 1, 0.1, 100);
renderer.shadowMap.enabled = true;
scene.background = new Color(0xc8d0d8);
camera.position.set(1.6, 1.7, 3.6);
const controls = new OrbitControls(camera, canvas);
controls.target.set(0, 0.9, 0);

const sun = new DirectionalLight(0xffffff, 2.2), floor = new Mesh(new CircleGeometry(4, 64), new MeshLambertMaterial({ color: 0xa09890 }));
sun.position.set(3, 5, 2);
sun.castShadow = true;
sun.shadow.mapSize.set(2048, 2048);
Object.assign(sun.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3 });
floor.rotation.x = -Math.PI / 2;
floor.receiveShadow = true;
const box = new Mesh(new BoxGeometry(0.4, 0.8, 0.4), new MeshLambertMaterial({ color: 0x3070c0 }));
box.castShadow = box.receiveShadow = true;
scene.add(sun, new AmbientLight(0xffffff, 1), floor, box);

new ResizeObserver(() => {
  renderer.setPixelRatio(devicePixelRatio);
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  camera.aspect = canvas.clientWidth / canvas.clientHeight;
  camera.updateProjectionMatrix();
}).observe(canvas);

try {
  const group = new DoppelGroup(await Doppel.load('person.glb'));
  group.castShadow = true;
  group.addEventListener('error', ({ error }) => { said.textContent = error.message; });
  scene.add(group);
  said.textContent = `${group.name || 'A person'}, and a box that goes around them. Drag to turn, wheel to zoom.`;
  renderer.setAnimationLoop(ms => {
    const seconds = ms / 1000;
    controls.update();
    if (group.person.clips.length) group.person.setClip(0, seconds);
    box.position.set(0.9 * Math.sin(seconds), 0.4, 0.9 * Math.cos(seconds));
    renderer.render(scene, camera);
  });
} catch (error) {
  said.textContent = error.message;
}
