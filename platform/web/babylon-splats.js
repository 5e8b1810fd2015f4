// SPDX-License-Identifier: Apache-2.0
// A person among the splats that Babylon.js draws itself: fills a GaussianSplattingMesh for each pose. It imports nothing of Babylon.js, so
// that it takes either of its packages.
//
//   const mesh = new GaussianSplattingMesh('ada', null, scene), ada = new BabylonSplats(person, mesh);
//   person.setClip('walk', seconds), ada.update(camera);
//
// Babylon.js keeps 8 bits of each number of a rotation and of a colour.
const BYTES = 32;  // a splat: position and scale, 3 floats each, then a byte for each of r, g, b, a and of the rotation, w first
const LAYOUT = [
  { property: 'position', offset: 0, stride: 56 }, { property: 'scale', offset: 12, stride: 56 }, { property: 'colour', offset: 24, stride: 56 },
  { property: 'opacity', offset: 36, stride: 56 }, { property: 'rotation', offset: 40, stride: 56 },
];

/** A person as splats of Babylon.js. Place the mesh; leave person.setTransform() alone. */
export class BabylonSplats {
  /** splatBudget: most splats, 0: all. */
  constructor(person, mesh, { splatBudget = 0 } = {}) {
    this.person = person;
    this.mesh = mesh;
    this.options = { eye: null, splatBudget };
    this.#write();
  }

  /** Takes the person's pose. Call it once a frame, before the scene is drawn. Splats are sorted beside, so their order may be a frame old.
   *  camera: who looks. */
  update(camera) {
    const world = this.mesh.computeWorldMatrix(true), { m } = world.clone().invert(), { x, y, z } = camera.globalPosition;
    const at = k => m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k];
    this.options.eye = [-at(0), at(1), at(2)];
    this.#write();
  }

  /** Babylon.js has a left hand: x is mirrored. */
  #write() {
    const { bytes, count } = this.person.writeSplats(LAYOUT, this.options);
    if (this.source !== bytes) this.source = bytes, this.numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length >> 2);
    this.floats ??= new Float32Array(count * BYTES / 4);
    const from = this.numbers, { floats } = this, to = new Uint8ClampedArray(floats.buffer);
    for (let i = 0; i < count; ++i) {
      const at = 14 * i, number = 8 * i, byte = BYTES * i;
      floats[number] = -from[at];
      for (let k = 1; k < 6; ++k) floats[number + k] = from[at + k];
      for (let k = 0; k < 4; ++k) to[byte + 24 + k] = 255 * from[at + 6 + k];
      to[byte + 28] = 127.5 * from[at + 13] + 127.5, to[byte + 29] = 127.5 * from[at + 10] + 127.5;
      to[byte + 30] = 127.5 - 127.5 * from[at + 11], to[byte + 31] = 127.5 - 127.5 * from[at + 12];
    }
    this.mesh.updateData(floats.buffer, undefined, { flipY: false });
  }
}
