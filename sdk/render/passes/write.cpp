// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/write.h"

namespace dpl {

void addWrite(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject, const WriteIds& write) {
    auto step = plan.compute("splat.write", formatText("write.sh{}", subject.shDegree))
                    .uniform(write.data)
                    .reads(subject.splats, subject.triangleFrames, write.kept)
                    .updates(write.rows)
                    .push(frame.codesPush(subject));
    write.keptRows > 0 ? step.threads(write.keptRows) : step.groups(subject.groupCount);
}

}  // namespace dpl
