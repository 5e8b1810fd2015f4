// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/posed_splats.h"

#include <cmath>

#include "sdk/avatar/posed_mesh.h"
#include "sdk/math/binding.h"
#include "sdk/math/sh.h"
#include "sdk/math/sh_rotation.h"

namespace dpl {
namespace {

/** Principal axes of the ellipse that a1 and a2 span (conjugate half axes), from the eigenvectors of their 2×2 Gram matrix. */
void ellipseOf(const Vec3d& a1, const Vec3d& a2, const Vec3d& normal, Quatf& rotation, Vec3f& scale) {
    const double p = glm::dot(a1, a1), q = glm::dot(a1, a2), r = glm::dot(a2, a2);
    const double angle = 0.5 * std::atan2(2 * q, p - r), c = std::cos(angle), s = std::sin(angle);
    const Vec3d major = c * a1 + s * a2, minor = c * a2 - s * a1;
    const double s1 = glm::length(major), s2 = glm::length(minor);
    const Vec3d x = s1 > 0 ? major / s1 : glm::normalize(glm::cross(normal, Vec3d(0.31, 0.77, 0.55)));
    const Vec3d y = glm::normalize(glm::cross(normal, x));
    rotation = Quatf(glm::quat_cast(Mat3d(x, y, glm::cross(x, y))));
    scale = {float(s1), float(s2), kFlatThicknessM};
}

}  // namespace

Result<StaticSplatData> posedSplats(const AvatarData& avatar, const Pose& pose) {
    DPL_RETURN_IF_ERROR(checkPose(avatar.joints, pose));
    Jobs jobs(1);
    const std::vector<RestTriangle<float>> bind = restTriangles(avatar.mesh);
    const ClothClearance clearance(avatar.joints, avatar.mesh, avatar.correctives);
    PosedMesh posed;
    posed.pose({avatar.joints, avatar.mesh, avatar.correctives, {bind}, &avatar.light, {}, &clearance}, pose, jobs);
    const std::span<const TriangleFrame<float>> frames = posed.frames();

    const SplatData& in = avatar.splats;
    const uint32_t shFloats = 3 * shCoefficientCount(in.shDegree);
    const ShRotator rotator;
    StaticSplatData out;
    out.shDegree = in.shDegree, out.compensated = avatar.compensated;
    for (size_t t = 0; t + 1 < in.triangleStart.size(); ++t) {
        const TriangleFrame<float>& frame = frames[t];
        if (!frame.valid) continue;
        for (uint32_t i = in.triangleStart[t]; i < in.triangleStart[t + 1]; ++i) {
            Vec3f a1, a2;
            splatAxes(frame, in.phi[i], in.scaleM[i].x, in.scaleM[i].y, a1, a2);
            Quatf rotation;
            Vec3f scale;
            ellipseOf(Vec3d(a1), Vec3d(a2), Vec3d(frame.normal), rotation, scale);
            out.position.push_back(splatCentre(frame, in.uv[i]));
            out.rotation.push_back(rotation);
            out.scaleM.push_back(scale);
            out.opacity.push_back(in.opacity[i] * frame.shown);
            out.sh.insert(out.sh.end(), in.sh.begin() + size_t(i) * shFloats, in.sh.begin() + size_t(i + 1) * shFloats);
            float* sh = out.sh.data() + out.sh.size() - shFloats;
            rotator.rotate(Mat3d(frame.worldFromRest), in.shDegree, sh);
            // Fold the light L into plain SH: 0.5 + C0·dc' + … = L·(0.5 + C0·dc + …), so dc' = L·dc + 0.5·(L − 1)/C0.
            const float light = splatLight(frame, in.uv[i]);
            for (uint32_t k = 0; k < shFloats; ++k) sh[k] = light * sh[k] + (k < 3 ? (light - 1) * 0.5f / float(kShC0) : 0.0f);
        }
    }
    return out;
}

}  // namespace dpl
