// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/posed_splats.h"

#include <cmath>

#include "sdk/avatar/scene_light.h"
#include "sdk/splat/posed_splats.h"

namespace dpl {

SplatPoser::SplatPoser(const AvatarData& avatar, float sunkM)
    : avatar_(avatar),
      sunkM_(sunkM),
      rest_(restTriangles(avatar.mesh)),
      normals_(avatar.light.empty() ? std::vector<Vec3f>() : restVertexNormals(avatar.mesh)),
      cloth_(avatar.joints, avatar.mesh, avatar.correctives) {}

Result<StaticSplatData> SplatPoser::in(const Pose& pose, bool all) {
    const AvatarData& avatar = avatar_;
    DPL_RETURN_IF_ERROR(checkPose(avatar.joints, pose));
    posed_.pose({avatar.joints, avatar.mesh, avatar.correctives, {rest_}, &avatar.light, normals_, &cloth_}, pose, jobs_);

    const SplatData& in = avatar.splats;
    const uint32_t shFloats = 3 * shCoefficientCount(in.shDegree);
    StaticSplatData out;
    out.shDegree = in.shDegree, out.compensated = avatar.compensated;
    for (size_t t = 0; t + 1 < in.triangleStart.size(); ++t) {
        if (in.triangleStart[t] == in.triangleStart[t + 1] || !(all || posed_.frames()[t].valid)) continue;
        const PosedTriangle triangle(posed_.frames()[t]);
        const ShTurn<float> turn = rotator_.turn(triangle.frame().worldFromRest, in.shDegree);
        for (uint32_t i = in.triangleStart[t]; i < in.triangleStart[t + 1]; ++i) {
            const GaussianAxes axes = triangle.axes(
                triangle.ellipse(Formulas<float>::planeAxes(std::cos(in.phi[i]), std::sin(in.phi[i]), in.scaleM[i].x, in.scaleM[i].y)));
            const Vec3f centre = triangle.centre(in.uv[i]);
            const bool singleFace = (in.flags[i] & kSplatSingleFace) != 0;
            out.position.push_back(singleFace && triangle.frame().valid ? centre - sunkM_ * triangle.frame().normal : centre);
            out.rotation.push_back(axes.rotation);
            out.scaleM.push_back(axes.scaleM);
            out.opacity.push_back(in.opacity[i] * triangle.shown(centre, singleFace, {}));
            out.sh.insert(out.sh.end(), in.sh.begin() + size_t(i) * shFloats, in.sh.begin() + size_t(i + 1) * shFloats);
            float* sh = out.sh.data() + out.sh.size() - shFloats;
            turn.apply(sh);
            foldLight(triangle.light(in.uv[i]), in.shDegree, sh);
        }
    }
    return out;
}

Result<StaticSplatData> posedSplats(const AvatarData& avatar, const Pose& pose) {
    return SplatPoser(avatar).in(pose, /*all=*/false);
}

}  // namespace dpl
