// SPDX-License-Identifier: Apache-2.0
// Pose correctives as bytes, for the trainer's binary files and fingerprints. Both use the same list of fields.
#pragma once

#include "sdk/core/arrays.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** Everything except the node values, which are the only trained part. */
inline void putCorrectiveModel(Writer& out, const PoseCorrectiveData& c) {
    out.value(c.modeCount), out.value(c.nodeCount), out.value(c.reach), out.value(c.reachOffModes);
    putArray(out, c.joints), putArray(out, c.mean), putArray(out, c.modes), putArray(out, c.nodeIndices), putArray(out, c.nodeWeights);
    const MotionModeData& m = c.motion;
    out.value(m.movedFromRad), out.value(m.movedToRad);
    putArray(out, m.groups), putArray(out, m.joints), putArray(out, m.still), putArray(out, m.rangeRad), putArray(out, m.holdsS),
        putArray(out, m.lagsS), putArray(out, m.modes);
}

inline void putCorrectives(Writer& out, const PoseCorrectiveData& c) {
    putCorrectiveModel(out, c);
    putArray(out, c.nodes);
}

/** Checks array sizes against the file's length only. The caller must call checkCorrectives() next. */
inline Status getCorrectives(Reader& in, PoseCorrectiveData& c) {
    DPL_TRY(c.modeCount, in.u32());
    DPL_TRY(c.nodeCount, in.u32());
    DPL_TRY(c.reach, in.value<float>());
    DPL_TRY(c.reachOffModes, in.value<float>());
    DPL_RETURN_IF_ERROR(getArray(in, c.joints));
    DPL_RETURN_IF_ERROR(getArray(in, c.mean));
    DPL_RETURN_IF_ERROR(getArray(in, c.modes));
    DPL_RETURN_IF_ERROR(getArray(in, c.nodeIndices));
    DPL_RETURN_IF_ERROR(getArray(in, c.nodeWeights));
    MotionModeData& m = c.motion;
    DPL_TRY(m.movedFromRad, in.value<float>());
    DPL_TRY(m.movedToRad, in.value<float>());
    DPL_RETURN_IF_ERROR(getArray(in, m.groups));
    DPL_RETURN_IF_ERROR(getArray(in, m.joints));
    DPL_RETURN_IF_ERROR(getArray(in, m.still));
    DPL_RETURN_IF_ERROR(getArray(in, m.rangeRad));
    DPL_RETURN_IF_ERROR(getArray(in, m.holdsS));
    DPL_RETURN_IF_ERROR(getArray(in, m.lagsS));
    DPL_RETURN_IF_ERROR(getArray(in, m.modes));
    return getArray(in, c.nodes);
}

}  // namespace dpl
