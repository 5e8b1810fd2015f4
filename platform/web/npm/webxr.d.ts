// SPDX-License-Identifier: Apache-2.0
// Types of WebXR come from @types/webxr, where a project has them.
import type { Camera, Doppel } from './doppel.js';
import type { SplatRenderer } from './webgl-renderer.js';

/** The camera of an XRView. width, height: of its viewport, px. into: a camera to overwrite. */
export function cameraOfXRView(view: XRView, width: number, height: number, into?: Camera | { viewFromWorld: number[] }): Camera;

export class XREyes {
  /** Draws into the frame's base layer. False: the headset does not know where it is, or the graphics device is lost. */
  draw(renderer: SplatRenderer, person: Doppel, frame: XRFrame, referenceSpace: XRReferenceSpace): boolean;
}
