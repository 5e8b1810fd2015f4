// SPDX-License-Identifier: Apache-2.0
// Interface between PosedSplatWriter (posed_splats.h), which decodes splats, and its SIMD kernel write_kernel.cpp. Private to sdk/splat.
#pragma once

#include <span>

#include "sdk/math/binding.h"
#include "sdk/splat/packed_layout.h"
#include "sdk/splat/posed_splats.h"

namespace dpl {

/** What all splats of a write share. */
struct WriteConstants {
    float rotation[9];     // of the placement, row-major
    float translation[3];  // world
    float scale;           // metres of the world that a metre of the avatar takes
    float eye[3];          // in the avatar's space
    bool hasEye;
    uint32_t shDegree;  // of SplatNumbers::Sh
    // What ShRotator is made of: directions, and P⁻¹ row by row; those of a band behind those of the band before.
    float shDirections[(3 + 5 + 7) * 3], shInverse[9 + 25 + 49];
};

/** Writes `count` splats of packed groups (bound_field) into rows [firstRow, firstRow + count). */
struct WriteTask {
    const WriteConstants* constants;
    const float* packed;
    uint32_t count, shDegree;            // shDegree: of the packed groups
    const TriangleFrame<float>* frames;  // in the avatar's space
    std::span<const SplatColumn> columns;
    size_t firstRow;
};

/** Returns how many numbers were too large for a half. */
uint64_t writeGroups(const WriteTask& task);

}  // namespace dpl
