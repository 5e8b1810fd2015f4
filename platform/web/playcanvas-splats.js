// SPDX-License-Identifier: Apache-2.0
// A person among the splats that PlayCanvas draws itself: a GSplatContainer in its default format, filled for each pose.
//
//   const ada = new DoppelContainer(app.graphicsDevice, person);
//   entity.addComponent('gsplat', { resource: ada });
//   person.setClip('walk', seconds), ada.pose(entity, cameraEntity.getPosition());
import { BoundingBox, GSplatContainer, GSplatFormat, Mat4, Vec3, WORKBUFFER_UPDATE_ONCE } from 'playcanvas';

const REACH_M = 0.1;  // of a splat beyond its centre, for bounds
const inverse = new Mat4(), local = new Vec3();

/** A person as a resource of PlayCanvas. Place its entity; leave person.setTransform() alone. */
export class DoppelContainer extends GSplatContainer {
  /** splatBudget: most splats, 0: all. */
  constructor(device, person, { splatBudget = 0 } = {}) {
    const { count } = person.writeSplats([{ property: 'opacity' }], { splatBudget });
    super(device, count, GSplatFormat.createDefaultFormat(device));
    this.person = person;
    this.options = { eye: new Float32Array(3), splatBudget };
    // What the textures of the default format hold, one after the other, and last the centres, by which it sorts.
    this.layout = [
      { property: 'position', offset: 0, stride: 16 }, { property: 'colour', number: 'half', offset: 16 * count, stride: 8 },
      { property: 'opacity', number: 'half', offset: 16 * count + 6, stride: 8 }, { property: 'scale', number: 'half', offset: 24 * count, stride: 8 },
      { property: 'rotationWxyz', number: 'half', offset: 32 * count, stride: 8 }, { property: 'position', offset: 40 * count, stride: 12 },
    ];
    this.#write();
  }

  /** Takes the person's pose. Call it once a frame, before the app draws. entity: where the person stands; eye: a Vec3, where the viewer is,
   *  world. */
  pose(entity, eye) {
    inverse.copy(entity.getWorldTransform()).invert().transformPoint(eye, local);
    this.options.eye[0] = local.x, this.options.eye[1] = local.y, this.options.eye[2] = local.z;
    this.#write();
    entity.gsplat.workBufferUpdate = WORKBUFFER_UPDATE_ONCE;  // it copies what the textures hold, and looks no more
  }

  #write() {
    const { bytes, count } = this.person.writeSplats(this.layout, this.options);
    const fill = (texture, Numbers, offset) => {
      this.getTexture(texture).lock().set(new Numbers(bytes.buffer, bytes.byteOffset + offset, 4 * count));
      this.getTexture(texture).unlock();
    };
    fill('dataCenter', Float32Array, 0);
    fill('dataColor', Uint16Array, 16 * count);
    fill('dataScale', Uint16Array, 24 * count);
    fill('dataRotation', Uint16Array, 32 * count);
    this.centers.set(new Float32Array(bytes.buffer, bytes.byteOffset + 40 * count, 3 * count));
    const box = this.aabb ?? new BoundingBox();
    box.compute(this.centers, count);
    box.halfExtents.add(new Vec3(REACH_M, REACH_M, REACH_M));
    this.aabb = box;
    this.update(count);
  }
}
