// SPDX-License-Identifier: Apache-2.0
// The built-in body: the parametric human that Doppel uses when the user brings none. It is computed, without data files.
#pragma once

#include "reconstruction/subject/body/body_model.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** A neutral adult, 1.75 m tall, in an A-pose (arms 42° down, feet apart): one closed 2-manifold of 10k to 16k vertices with face, ears,
 * five separate fingers and toes; 55 joints in SMPL-X order with VRM humanoid names; four unorm8 weights per vertex, sum 255; shape morphs
 * "height", "weight", "build", "shoulder_width", "hip_width", "arm_length", "leg_length", "torso_length", "head_size", "hair_volume",
 * "chest"; 64 keypoints named as in docs/formats/scan.md; all expressions but tongueOut. Takes about two seconds. Same bytes for any thread
 * count. */
BodyModel makeBuiltinBody(Jobs& jobs);

/** The same on its own thread pool (one thread per core). */
BodyModel makeBuiltinBody();

}  // namespace dpl
