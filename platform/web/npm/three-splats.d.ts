// SPDX-License-Identifier: Apache-2.0
// Types of three.js come from @types/three, where a project has them.
import type { Camera } from 'three';
import type { GaussianSplat } from 'three/addons/objects/GaussianSplat.js';
import type { Doppel } from './doppel.js';

/** A person as three's own splats, for its WebGPURenderer. Place it by position, rotation and scale; leave person.setTransform() alone. */
export class DoppelSplats extends GaussianSplat {
  /** person: one that nothing else draws. It stays yours. splatBudget: most splats, 0: all. Throws DoppelError. */
  constructor(person: Doppel, options?: { splatBudget?: number });
  readonly person: Doppel;
  /** Takes the person's pose. Call it once a frame, before the scene is drawn. camera: who looks. */
  update(camera: Camera): void;
  /** Throws DoppelError: a person stands in one place. */
  clone(): never;
  /** Leaves the scene and gives back what the graphics device holds. */
  dispose(): void;
}
