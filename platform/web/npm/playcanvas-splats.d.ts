// SPDX-License-Identifier: Apache-2.0
import type { Entity, GraphicsDevice, GSplatContainer, Vec3 } from 'playcanvas';
import type { Doppel } from './doppel.js';

/** A person as a resource of PlayCanvas, for the component gsplat of an entity. Place the entity; leave person.setTransform() alone. */
export class DoppelContainer extends GSplatContainer {
  /** person: one that nothing else draws. It stays yours. splatBudget: most splats, 0: all. Throws DoppelError. */
  constructor(device: GraphicsDevice, person: Doppel, options?: { splatBudget?: number });
  readonly person: Doppel;
  /** Takes the person's pose. Call it once a frame, before the app draws. entity: where the person stands; eye: where the viewer is, world. */
  pose(entity: Entity, eye: Vec3): void;
}
