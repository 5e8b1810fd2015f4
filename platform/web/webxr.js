// SPDX-License-Identifier: Apache-2.0
// Persons in WebXR: both eyes of a frame from one pose, one level of detail and one upload. Each eye has its own order of splats, as the
// engine's CPU renderer: two eyes see crossing splats in different orders.
//
//   const renderer = new SplatRenderer(canvas, { xrCompatible: true });
//   session.updateRenderState({ baseLayer: new XRWebGLLayer(session, renderer.context) });
//   const eyes = new XREyes();
//   session.requestAnimationFrame(function draw(time, frame) { eyes.draw(renderer, person, frame, space); ... });
import { DoppelError } from './doppel.js';

/** The camera of an XRView for Doppel.draw or project. width, height: of its viewport, px. into: a camera to overwrite. */
export function cameraOfXRView(view, width, height, into = { viewFromWorld: new Array(12) }) {
  const p = view.projectionMatrix, m = view.transform.inverse.matrix, to = into.viewFromWorld;
  into.width = width, into.height = height;
  into.fx = p[0] * width / 2, into.fy = p[5] * height / 2;
  into.cx = (1 - p[8]) * width / 2, into.cy = (1 + p[9]) * height / 2;
  for (let row = 0; row < 3; ++row)  // WebXR looks along −z with y up, the camera along +z with y down
    for (let column = 0; column < 4; ++column) to[4 * row + column] = (row === 0 ? 1 : -1) * m[4 * column + row];
  return into;
}

/** What the frames of a session reuse. */
export class XREyes {
  #cameras = [{ viewFromWorld: new Array(12) }, { viewFromWorld: new Array(12) }];

  /** Draws a person into the frame's base layer, over nothing: what was there is replaced. False: the headset does not know where it is, or
   *  the graphics device is lost. Errors of Doppel.project; both eyes must have one size, and there are at most two. */
  draw(renderer, person, frame, referenceSpace) {
    const pose = frame.getViewerPose(referenceSpace), layer = frame.session.renderState.baseLayer;
    if (!pose) return false;
    const { views } = pose;
    if (views.length > 2) throw new DoppelError(`a device with ${views.length} views; 1 or 2 are drawn`, 'DPL_ERROR_UNSUPPORTED');
    const first = layer.getViewport(views[0]), second = views.length > 1 ? layer.getViewport(views[1]) : null;
    const left = cameraOfXRView(views[0], first.width, first.height, this.#cameras[0]);
    const right = second && cameraOfXRView(views[1], second.width, second.height, this.#cameras[1]);
    return renderer.drawEyes(person, left, right, layer.framebuffer, first, second);
  }
}
