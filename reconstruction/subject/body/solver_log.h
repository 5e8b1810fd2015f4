// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace dpl {

/** Keeps Ceres' own log off standard error. It names source lines and steps that were tried again; each caller of the solver says itself
 *  what failed. For programs: the log belongs to the whole process. Call it before the first solve. */
void silenceSolverLog();

}  // namespace dpl
