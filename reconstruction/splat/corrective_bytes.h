// SPDX-License-Identifier: Apache-2.0
// Pose correctives in our own binary files and fingerprints: one list of fields for both.
#pragma once

#include "sdk/core/arrays.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** All but the values of the nodes, which alone are trained. */
inline void putCorrectiveModel(Writer& out, const PoseCorrectiveData& c) {
    out.value(c.modeCount), out.value(c.nodeCount), out.value(c.reach), out.value(c.reachOffModes);
    putArray(out, c.joints), putArray(out, c.mean), putArray(out, c.modes), putArray(out, c.nodeIndices), putArray(out, c.nodeWeights);
}

inline void putCorrectives(Writer& out, const PoseCorrectiveData& c) {
    putCorrectiveModel(out, c);
    putArray(out, c.nodes);
}

/** Checks sizes against the file only; call checkCorrectives() next. */
inline Status getCorrectives(Reader& in, PoseCorrectiveData& c) {
    DPL_TRY(c.modeCount, in.u32());
    DPL_TRY(c.nodeCount, in.u32());
    DPL_TRY(c.reach, in.value<float>());
    DPL_TRY(c.reachOffModes, in.value<float>());
    DPL_CHECK_OK(getArray(in, c.joints));
    DPL_CHECK_OK(getArray(in, c.mean));
    DPL_CHECK_OK(getArray(in, c.modes));
    DPL_CHECK_OK(getArray(in, c.nodeIndices));
    DPL_CHECK_OK(getArray(in, c.nodeWeights));
    return getArray(in, c.nodes);
}

}  // namespace dpl
