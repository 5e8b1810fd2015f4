// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/overlays.h"

#include <doppel/doppel_surface.h>

#include <cmath>

#include "apps/shared/pictures.h"

namespace dpl {
namespace {

/** The posed mesh, and its triangles. */
Status readMesh(const ViewedSubject& subject, std::vector<float>& positions, std::vector<uint32_t>& triangles) {
    positions.resize(size_t(subject.info.vertexCount) * 3);
    triangles.resize(size_t(subject.info.triangleCount) * 3);
    const DplResult read =
        dplGetPosedMesh(subject.avatar.handle(), positions.data(), subject.info.vertexCount, triangles.data(), subject.info.triangleCount);
    return read == DPL_OK ? Status() : fromSdk(doppel::lastError(read));
}

std::array<Vec3f, 3> cornersOf(const std::vector<float>& positions, const uint32_t* triangle) {
    const auto at = [&](uint32_t i) { return Vec3f(positions[3 * size_t(i)], positions[3 * size_t(i) + 1], positions[3 * size_t(i) + 2]); };
    return {at(triangle[0]), at(triangle[1]), at(triangle[2])};
}

Result<OverlayShapes> trust(const ViewedSubject& subject) {
    OverlayShapes out;
    const auto positions = subject.avatar.jointPositions();
    if (!positions) return fromSdk(positions.error());
    std::vector<float> distances(subject.joints.size());
    DplPoseTrust trust{};
    trust.structSize = sizeof trust;
    const DplResult told = dplGetPoseTrust(subject.avatar.handle(), &trust, distances.data(), uint32_t(distances.size()));
    if (told == DPL_ERROR_UNSUPPORTED) {
        out.words = "This avatar keeps no record of the poses that it learned from.";
        return out;
    }
    if (told != DPL_OK) return fromSdk(doppel::lastError(told));
    for (size_t i = 0; i < distances.size(); ++i)
        out.joints.push_back({Vec3f((*positions)[3 * i], (*positions)[3 * i + 1], (*positions)[3 * i + 2]), distances[i]});
    out.words = formatText("{} % of what was learned of poses is drawn.", int(std::lround(100 * trust.offsets)));
    if (trust.farthestJoint < subject.joints.size() && trust.farthestDistance > 0)
        out.words += formatText(" Farthest from the film: {}, {} deviations.", subject.joints[trust.farthestJoint],
                                std::round(10 * trust.farthestDistance) / 10);
    return out;
}

}  // namespace

Stretch stretchOf(const std::array<Vec3f, 3>& rest, const std::array<Vec3f, 3>& posed) {
    const Vec3f a = rest[1] - rest[0], b = rest[2] - rest[0];
    const float length = glm::length(a), area = glm::length(glm::cross(a, b));
    if (!(length > 0) || !(area > 1e-12f)) return {};
    // a lies along the first axis of the plane; b has these coordinates.
    const float along = glm::dot(a, b) / length, aside = area / length;
    const Vec3f first = (posed[1] - posed[0]) / length, second = (posed[2] - posed[0] - along * first) / aside;
    const float p = glm::dot(first, first), q = glm::dot(second, second), r = glm::dot(first, second);
    const float middle = 0.5f * (p + q), spread = std::sqrt(0.25f * (p - q) * (p - q) + r * r);
    return {std::sqrt(middle + spread), std::sqrt(std::max(0.0f, middle - spread))};
}

Result<OverlayShapes> OverlayMaker::needles(ViewedSubject& subject, const Playback& clock, double nowS) {
    if (restOf_ != subject.avatar.handle() || rest_.size() != size_t(subject.info.vertexCount) * 3) {
        std::vector<float> still(subject.joints.size() * 4);
        for (size_t i = 3; i < still.size(); i += 4) still[i] = 1;
        const float root[3] = {};
        if (const auto set = subject.avatar.setPose(still, root); !set) return fromSdk(set.error());
        DPL_RETURN_IF_ERROR(readMesh(subject, rest_, triangles_));
        restOf_ = subject.avatar.handle();
        DPL_RETURN_IF_ERROR(subject.pose(clock, nowS));
    }
    DPL_RETURN_IF_ERROR(readMesh(subject, posed_, triangles_));
    std::array<float, 12> rows{};
    if (const DplResult read = dplGetTransform(subject.avatar.handle(), rows.data()); read != DPL_OK)
        return fromSdk(doppel::lastError(read));
    const auto world = [&rows](const Vec3f& p) {
        const auto row = [&](size_t i) { return rows[i] * p.x + rows[i + 1] * p.y + rows[i + 2] * p.z + rows[i + 3]; };
        return Vec3f(row(0), row(4), row(8));
    };
    OverlayShapes out;
    size_t torn = 0;
    for (size_t i = 0; i + 2 < triangles_.size(); i += 3) {
        if (triangles_[i] == triangles_[i + 1]) continue;  // of a hidden layer
        const std::array<Vec3f, 3> posed = cornersOf(posed_, &triangles_[i]);
        const Stretch stretch = stretchOf(cornersOf(rest_, &triangles_[i]), posed);
        using Limits = StretchLimits;
        if (stretch.most <= Limits::kMost && stretch.least >= Limits::kLeast) continue;
        out.triangles.push_back(
            {{world(posed[0]), world(posed[1]), world(posed[2])}, stretch.most > Limits::kTornMost || stretch.least < Limits::kTornLeast});
        torn += out.triangles.back().torn;
    }
    out.words = formatText("{} of {} triangles are stretched or squeezed beyond what is drawn so; {} of them so much that they fade.",
                           out.triangles.size(), triangles_.size() / 3, torn);
    return out;
}

Result<OverlayShapes> OverlayMaker::shapes(ViewedSubject& subject, Overlay overlay, const Playback& clock, double nowS) {
    if (overlay == Overlay::None || overlay == Overlay::Hidden || !subject.isAvatar()) return OverlayShapes();
    return overlay == Overlay::Trust ? trust(subject) : needles(subject, clock, nowS);
}

}  // namespace dpl
