// SPDX-License-Identifier: Apache-2.0
// A person among the splats that three.js draws itself: its GaussianSplat, which needs WebGPURenderer. For WebGLRenderer there is
// three-group.js, which draws exactly what the library draws. The app's import map or bundler finds 'three/webgpu' and 'three/addons/'.
//
//   const ada = new DoppelSplats(person);
//   scene.add(ada);
//   person.setClip('walk', seconds), ada.update(camera), renderer.render(scene, camera);
//
// Colours are those of the screen: they are shown unchanged where renderer.outputColorSpace is LinearSRGBColorSpace.
import { Box3, BufferAttribute, BufferGeometry, Sphere, Vector3 } from 'three/webgpu';
import { GaussianSplat } from 'three/addons/objects/GaussianSplat.js';
import { DoppelError } from './doppel.js';

const REACH_M = 0.1;  // of a splat beyond its centre, for bounds
const FLOATS = 14;    // a splat: position 3, covariance 6, colour 3, opacity 1, one left free
const LAYOUT = [
  { property: 'position', offset: 0, stride: 4 * FLOATS }, { property: 'covariance', offset: 12, stride: 4 * FLOATS },
  { property: 'colour', offset: 36, stride: 4 * FLOATS }, { property: 'opacity', offset: 48, stride: 4 * FLOATS },
];
const eye = new Vector3(), options = { eye: new Float32Array(3), splatBudget: 0 };

function emptyGeometry(count) {
  const geometry = new BufferGeometry(), add = (name, array, size) => geometry.setAttribute(name, new BufferAttribute(array, size, array instanceof Uint8Array));
  add('position', new Float32Array(3 * count), 3);
  add('covariance', new Float32Array(6 * count), 6);
  add('color', new Uint8Array(4 * count), 4);
  geometry.boundingBox = new Box3(), geometry.boundingSphere = new Sphere();
  return geometry;
}

/** A person as three's own splats. Place it by position, rotation and scale; leave person.setTransform() alone. */
export class DoppelSplats extends GaussianSplat {
  /** splatBudget: most splats, 0: all. */
  constructor(person, { splatBudget = 0 } = {}) {
    super(emptyGeometry(person.writeSplats(LAYOUT, { splatBudget }).count));
    // three gives no way to change splats, so this writes what its object keeps.
    const { centerRead, covarianceARead, covarianceBRead, colorRead } = this._buffers ?? {};
    if (![centerRead, covarianceARead, covarianceBRead, colorRead].every(node => node?.value?.isStorageBufferAttribute) || this._sortInitialized !== false)
      throw new DoppelError('this three.js keeps its splats in another way; r187 is known', 'DPL_ERROR_UNSUPPORTED');
    this.stored = [centerRead.value, covarianceARead.value, covarianceBRead.value, colorRead.value];
    this.person = person;
    this.splatBudget = splatBudget;
    this.boundingBox = new Box3(), this.boundingSphere = new Sphere();
  }

  /** Takes the person's pose. Call it once a frame, before the scene is drawn. camera: who looks. */
  update(camera) {
    this.updateWorldMatrix(true, false);
    this.worldToLocal(camera.getWorldPosition(eye)).toArray(options.eye);
    options.splatBudget = this.splatBudget;
    const { bytes, count } = this.person.writeSplats(LAYOUT, options);
    if (this.source !== bytes) this.source = bytes, this.numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length >> 2);
    const from = this.numbers, { position, covariance, color } = this.splatGeometry.attributes;
    const [centers, a, b, colours] = this.stored.map(({ array }) => array);
    for (let i = 0, at = 0; i < count; ++i, at += FLOATS) {
      for (let k = 0; k < 3; ++k) centers[4 * i + k] = position.array[3 * i + k] = from[at + k];
      for (let k = 0; k < 6; ++k) covariance.array[6 * i + k] = from[at + 3 + k];
      for (let k = 0; k < 4; ++k) a[4 * i + k] = from[at + 3 + k];
      b[4 * i] = from[at + 7], b[4 * i + 1] = from[at + 8];
      let word = 0;
      for (let k = 3; k >= 0; --k) word = word << 8 | (color.array[4 * i + k] = 255 * from[at + 9 + k] + 0.5);
      colours[i] = word >>> 0;
    }
    for (const attribute of this.stored) {
      attribute.needsUpdate = true;
      if (attribute.pbo) attribute.pbo.needsUpdate = true;  // its twin where WebGL2 stands in for WebGPU
    }
    this.boundingBox.setFromArray(position.array).expandByScalar(REACH_M);
    this.boundingBox.getBoundingSphere(this.boundingSphere);
    this._sortInitialized = false;
  }

  /** Throws: a person stands in one place. */
  clone() { throw new DoppelError('a person cannot be cloned; load another', 'DPL_ERROR_UNSUPPORTED'); }

  /** Gives back what the graphics device holds. The person stays. */
  dispose() {
    this.removeFromParent();
    this.geometry.dispose();
    this.material.dispose();
  }
}
