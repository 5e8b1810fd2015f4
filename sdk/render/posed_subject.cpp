// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/posed_subject.h"

#include "sdk/avatar/pose_correctives.h"

namespace dpl {

void poseAvatar(const LoadedSubject& subject, const Pose& pose, DrawnSubject& out) {
    const AvatarData& avatar = *subject.avatar;
    jointTransforms(avatar.joints, pose, out.worldFromRest);
    out.pushedM = 0;
    if (avatar.correctives.empty()) {
        out.coefficients.clear(), out.nodes.clear();
        return;
    }
    const float drawn = correctiveCoefficients(avatar.correctives, pose, out.coefficients).drawn;
    correctiveNodes(avatar.correctives, out.coefficients, out.nodes);
    addExpression(avatar.expressions, pose.expression, out.coefficients, out.nodes);
    out.pushedM = subject.cloth.apply(out.worldFromRest, drawn, out.nodes, out.cloth);
}

PosedSet SubjectPoser::pose(std::span<const Drawn> what, std::span<LoadedSubject* const> subjects, const FrameViews& views,
                            const DetailOptions& detail, bool cullComponents) {
    DetailMember members[kMaxDrawnTogether];
    for (size_t k = 0; k < subjects.size(); ++k) {
        DrawnSubject& out = posed_[k];
        out.views = SubjectViews(what[k].placement, views.all);
        members[k].views = out.views.cameras(), members[k].scale = out.views.scale();
        if (!subjects[k]->avatar) {
            out.worldFromRest.clear(), out.coefficients.clear(), out.nodes.clear();
            members[k].general = &subjects[k]->generalDetail;
            continue;
        }
        poseAvatar(*subjects[k], *what[k].pose, out);
        members[k].avatar = &subjects[k]->detail;
        members[k].worldFromRest = out.worldFromRest;
    }
    const DetailTotals splats = chooseDetails(detail, {members, subjects.size()});
    for (size_t k = 0; k < subjects.size(); ++k) {
        const LoadedSubject& subject = *subjects[k];
        DrawnSubject& out = posed_[k];
        out.detail = members[k].detail;
        out.generalDetail = members[k].generalDetail;
        out.drawnShare = members[k].share;
        out.largestGrowth = subject.detail.largestGrowth(out.detail.perM2);
        out.unseen.fill(subject.components.ofLayers(what[k].hiddenLayers));
        if (!subject.avatar || !cullComponents) continue;
        const FrameViews own{out.views.cameras(), views.shared};
        for (size_t frame = 0; frame < own.frameCount(); ++frame)
            out.unseen[frame] |= subject.components.unseen(out.worldFromRest, out.coefficients, own.of(frame), subject.splats.kappaPx2,
                                                           out.largestGrowth, out.views.scale(), out.pushedM);
    }
    return {{posed_.data(), subjects.size()}, splats};
}

}  // namespace dpl
