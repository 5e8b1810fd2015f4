// SPDX-License-Identifier: Apache-2.0
// Types of three.js come from @types/three, where a project has them.
import type { Object3D, Object3DEventMap } from 'three';
import type { Doppel, DoppelError } from './doppel.js';

export interface DoppelGroupEventMap extends Object3DEventMap {
  /** The person is not drawn; each sentence is told once. */
  error: { error: DoppelError };
}

/** A person in a scene of three.js, drawn by its WebGLRenderer. Place it by position, rotation and one scale for all axes. castShadow: by the
 * posed mesh. Light and fog of the scene do not change the person. */
export class DoppelGroup extends Object3D<DoppelGroupEventMap> {
  /** person: one that no other group shows. It stays yours: pose it, and dispose of it after the group. Throws DoppelError. */
  constructor(person: Doppel);
  readonly person: Doppel;
  /** Why the person is not drawn; null: they are. */
  readonly error: DoppelError | null;
  /** Throws DoppelError: a person stands in one place. */
  clone(): never;
  /** Leaves the scene and gives back what the graphics device holds. */
  dispose(): void;
}
