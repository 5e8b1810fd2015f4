// SPDX-License-Identifier: Apache-2.0
// Cases of the conformance kit (tests/conformance/kit.h) for the module.

/** The camera of a view of kit.json. */
export const cameraOf = view => ({ width: view.width_px, height: view.height_px, fx: view.fx, fy: view.fy, cx: view.cx, cy: view.cy,
  viewFromWorld: view.view_from_world });

/** Poses a person as a case says. Earlier poses are drawn by draw(camera) first, for clothes remember what was drawn. */
export function poseAsIn(one, person, draw) {
  const pose = (rotations, timeNs) =>
    person.setPose(rotations.flat(), one.root_translation, { timeMs: timeNs === undefined ? undefined : timeNs / 1e6 });
  for (const earlier of one.earlier ?? []) {
    pose(earlier.rotations, earlier.time_ns);
    draw(cameraOf(one.views[0]));
  }
  pose(one.rotations, one.time_ns);
}
