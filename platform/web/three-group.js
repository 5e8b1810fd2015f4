// SPDX-License-Identifier: Apache-2.0
// Persons in a scene of three.js, drawn by its WebGLRenderer: they hide meshes and are hidden, and persons are sorted together.
//
//   const ada = new DoppelGroup(await Doppel.load('ada.glb'));
//   scene.add(ada);
//   ada.person.setClip('walk', seconds);   // then renderer.render(scene, camera)
//
// three draws meshes in the order of renderOrder. After all opaque ones come, of each group that can be seen, a mesh that only says so, and
// then, of each group, one that paints. The first of these paints all (three-pass.js); why so: docs/adr/0088.
import { Box3, BufferAttribute, BufferGeometry, DynamicDrawUsage, Mesh, Object3D, Sphere, Vector3 } from 'three';
import { Doppel, DoppelError } from './doppel.js';
import { ScenePass, paintMaterial, unseenMaterial } from './three-pass.js';

const SAYS = 1e9, PAINTS = SAYS + 1;  // renderOrder
const MOST_SENTENCES = 16;
const wrong = sentence => new DoppelError(sentence, 'DPL_ERROR_INVALID_ARGUMENT');
const shown = new WeakSet();   // persons that have a group
const passes = new WeakMap();  // of renderers

function passOf(renderer) {
  if (!passes.has(renderer)) passes.set(renderer, new ScenePass(renderer));
  return passes.get(renderer);
}

/** A mesh that belongs to a group and is no part of the app's scene. */
function partOf(group, geometry, material) {
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.layers = group.layers;
  mesh.raycast = () => {};
  group.add(mesh);
  return mesh;
}

/** A person in a scene, placed by position, rotation and one scale for all axes. `castShadow`: by the posed mesh. The person stays yours:
 *  pose it, and dispose of it after the group. Event `error`: why the person is not drawn, a DoppelError in `error`; each sentence once. */
export class DoppelGroup extends Object3D {
  #told = new Set(); #rows = new Array(12).fill(NaN); #placed = false; #passes = new Set(); #parts = []; #caster;
  /** Why the person is not drawn; null: they are. */
  error = null;

  /** person: a Doppel, which no other group shows. */
  constructor(person) {
    super();
    if (!(person instanceof Doppel)) throw wrong('a DoppelGroup needs a person, from Doppel.load');
    if (shown.has(person)) throw wrong('this person has a DoppelGroup already; load them again to show them twice');
    shown.add(person);
    this.type = 'DoppelGroup';
    this.person = person;
    this.name = person.name;
    const box = new Box3(new Vector3(...person.restMin), new Vector3(...person.restMax));
    const triangle = this.#geometry(box);
    triangle.setAttribute('position', new BufferAttribute(new Float32Array(9), 3));  // of no size, whatever material draws it
    const says = partOf(this, triangle, paintMaterial), paints = partOf(this, triangle, paintMaterial);
    says.renderOrder = SAYS, paints.renderOrder = PAINTS;
    says.onBeforeRender = (renderer, scene, camera, geometry, material) => {
      triangle.setDrawRange(0, 0);
      if (material === paintMaterial) this.#passOf(renderer).expect(this, camera);
    };
    let painted = false;
    paints.onBeforeRender = (renderer, scene, camera, geometry, material) => {
      painted = material === paintMaterial && this.#passOf(renderer).prepare(camera);
      triangle.setDrawRange(0, painted ? 3 : 0);
    };
    paints.onAfterRender = (renderer, scene, camera) => {
      if (painted) this.#passOf(renderer).writeDepth(camera);
      painted = false;
    };
    this.#caster = partOf(this, this.#geometry(box), unseenMaterial);
    this.#caster.onBeforeRender = () => this.#caster.geometry.setDrawRange(0, 0);
    this.#caster.onBeforeShadow = () => this.#caster.geometry.setDrawRange(0, Infinity);
    this.#caster.visible = false;
    this.#parts = [says, paints, this.#caster];
  }

  #geometry(box) {
    const geometry = new BufferGeometry();
    geometry.boundingBox = box.clone();
    geometry.boundingSphere = box.getBoundingSphere(new Sphere());
    geometry.setDrawRange(0, 0);
    return geometry;
  }

  #passOf(renderer) {
    const pass = passOf(renderer);
    this.#passes.add(pass);
    return pass;
  }

  /** three calls it before it draws: so the shadow has the pose that the person has then. */
  updateMatrixWorld(force) {
    if (this.castShadow) this.#poseCaster();
    this.#caster.visible = this.#caster.castShadow = this.castShadow;
    super.updateMatrixWorld(force);
  }

  /** Tells the person where they stand. For three-pass.js. Throws DoppelError. */
  place() {
    const m = this.matrixWorld.elements, rows = this.#rows;
    let moved = !this.#placed;
    for (let row = 0; row < 3; ++row)
      for (let column = 0; column < 4; ++column) {
        const at = 4 * row + column, value = m[4 * column + row];
        if (rows[at] !== value) rows[at] = value, moved = true;
      }
    if (!moved) return;
    this.#placed = false;
    this.person.setTransform(rows);
    this.#placed = true;
  }

  /** For three-pass.js: why the person is not drawn; null: they are. */
  tell(error) {
    this.error = error;
    if (!error || this.#told.has(error.message) || this.#told.size >= MOST_SENTENCES) return;
    this.#told.add(error.message);
    console.error(`DoppelGroup: ${error.message}`);
    this.dispatchEvent({ type: 'error', error });
  }

  #poseCaster() {
    const { geometry } = this.#caster;
    try {
      const { positions, triangles } = this.person.posedMesh();
      if (geometry.attributes.position?.array !== positions)
        geometry.setAttribute('position', new BufferAttribute(positions, 3).setUsage(DynamicDrawUsage));
      geometry.attributes.position.needsUpdate = true;
      if (geometry.index?.array !== triangles) geometry.setIndex(new BufferAttribute(triangles, 1));
    } catch (error) {
      if (!(error instanceof DoppelError)) throw error;
      this.castShadow = false;
      this.tell(error);
    }
  }

  /** It cannot be cloned: a person stands in one place. */
  clone() { throw wrong('a DoppelGroup cannot be cloned; load the person again'); }

  /** Gives back what the graphics device holds. The person stays. */
  dispose() {
    this.removeFromParent();
    for (const pass of this.#passes) pass.leave(this);
    this.#passes.clear();
    for (const part of this.#parts) part.geometry.dispose();
    shown.delete(this.person);
  }
}
