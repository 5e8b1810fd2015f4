// SPDX-License-Identifier: Apache-2.0
import type { Doppel } from './doppel.js';

/** What it needs of a GaussianSplattingMesh of Babylon.js. */
export interface SplattingMesh {
  updateData(data: ArrayBuffer, sh?: Uint8Array[], options?: { flipY: boolean }): void;
  computeWorldMatrix(force?: boolean): { clone(): { invert(): { readonly m: ArrayLike<number> } } };
}

/** A person as splats of Babylon.js. Place the mesh; leave person.setTransform() alone. */
export class BabylonSplats {
  /** person: one that nothing else draws. It stays yours. splatBudget: most splats, 0: all. Throws DoppelError. */
  constructor(person: Doppel, mesh: SplattingMesh, options?: { splatBudget?: number });
  readonly person: Doppel;
  readonly mesh: SplattingMesh;
  /** Takes the person's pose. Call it once a frame, before the scene is drawn. camera: who looks. */
  update(camera: { readonly globalPosition: { readonly x: number; readonly y: number; readonly z: number } }): void;
}
