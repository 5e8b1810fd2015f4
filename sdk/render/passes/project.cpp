// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/passes/project.h"

namespace dpl {
namespace {

/** The kernel built for the views of the frame and the SH degree of the subject. */
std::string ofColour(const char* shader, const FrameIds& frame, const SubjectIds& subject) {
    return frame.ofViews(formatText("{}.sh{}", shader, subject.shDegree));
}

}  // namespace

void addProject(FramePlan& plan, const FrameIds& frame, const SubjectIds& subject) {
    if (subject.general) {
        plan.compute("splat.project", frame.ofViews("project.general"))
            .uniform(subject.uniforms)
            .reads(subject.splats)
            .writes(frame.projected, frame.visibility)
            .updates(frame.counts)
            .push(gpu::SplatPush{subject.splatCount, frame.allGroups, subject.firstGroup, subject.firstSplat, subject.drawn})
            .groups(subject.groupCount);
        plan.compute("splat.colour", ofColour("colour.general", frame, subject))
            .uniform(subject.uniforms)
            .reads(subject.splats, subject.sh)
            .updates(frame.projected)
            .push(gpu::ColourPush{subject.splatCount, subject.firstSplat})
            .threads(subject.splatCount);
        return;
    }
    plan.compute("splat.project", ofColour("project", frame, subject))
        .uniform(subject.uniforms)
        .reads(subject.splats, subject.triangleFrames)
        .writes(frame.projected)
        .updates(frame.visibility)
        .push(frame.codesPush(subject))
        .groupsFrom(frame.counts, offsetof(gpu::FrameCounts, chunkGroupsX));
}

}  // namespace dpl
