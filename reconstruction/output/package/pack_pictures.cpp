// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/pack_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "reconstruction/output/package/avatar_drawer.h"
#include "reconstruction/subject/surface/orbit_camera.h"
#include "sdk/motion/clip.h"

namespace dpl {
namespace {

constexpr uint32_t kWidthPx = 288, kHeightPx = 384;
constexpr double kMaxTurnRad = 0.52;
constexpr float kGrey = 0.5f;

/** Uniform in [0, 1). Gives the same numbers on every machine, unlike the distributions of std. */
double uniform(std::mt19937_64& random) {
    return double(random() >> 11) * 0x1p-53;
}

Pose randomPose(const AvatarData& avatar, std::mt19937_64& random) {
    Pose pose = Pose::rest(avatar.joints.size());
    for (Quatf& turn : pose.localRotations) {
        const double z = 2 * uniform(random) - 1, angle = 2 * std::numbers::pi * uniform(random), r = std::sqrt(1 - z * z);
        turn = Quatf(glm::angleAxis(kMaxTurnRad * uniform(random), Vec3d(r * std::cos(angle), r * std::sin(angle), z)));
    }
    pose.localRotations[0] = Quatf(1, 0, 0, 0);  // the root does not turn; the camera moves around instead
    return pose;
}

/** A camera that looks at the posed mesh and fits it into the picture; `close`: only its top third. */
Cameraf randomCamera(std::span<const Vec3f> positions, bool close, std::mt19937_64& random) {
    Vec3f low(0), high(0);
    if (!positions.empty()) low = high = positions[0];
    for (const Vec3f& p : positions) low = glm::min(low, p), high = glm::max(high, p);
    const double azimuth = 2 * std::numbers::pi * uniform(random), elevation = (-20 + 60 * uniform(random)) * std::numbers::pi / 180;
    const double height = std::max(1e-3, double(high.y - low.y)),
                 width = std::max(1e-3, std::hypot(double(high.x - low.x), double(high.z - low.z)));
    Vec3d target = Vec3d(low + high) * 0.5;
    if (close) target.y = high.y - height / 6;
    const double extent = (close ? height / 3 : std::max(height, width * kHeightPx / kWidthPx)) * 1.15;
    const double distance = 1.6 * std::max(height, width);
    return orbitCamera(target, distance, azimuth, elevation, distance / extent * kHeightPx, kWidthPx, kHeightPx).cast<float>();
}

double psnrOf(double squares, double values) {
    return squares > 0 ? 10 * std::log10(values / squares) : std::numeric_limits<double>::infinity();
}

}  // namespace

double PackError::psnrDb() const {
    return psnrOf(squares, values);
}
double PackError::wholePsnrDb() const {
    return psnrOf(squares, allValues);
}

PackPictures::PackPictures(const AvatarData& avatar, uint32_t count, uint64_t seed, Jobs& jobs) : jobs_(jobs) {
    std::mt19937_64 random(seed);
    const std::vector<RestTriangle<float>> rest = restTriangles(avatar.mesh);
    PosedMesh posed;
    AvatarDrawer drawer(avatar, jobs);
    for (uint32_t i = 0; i < count; ++i) {
        Shot shot;
        if (i % 2 == 0 && !avatar.clips.empty()) {
            const ClipData& clip = avatar.clips[i / 2 % avatar.clips.size()];
            shot.pose = samplePose(clip, avatar.joints, clipDurationS(clip) * uniform(random));
        } else {
            shot.pose = randomPose(avatar, random);
        }
        posed.pose({avatar.joints, avatar.mesh, avatar.correctives, rest}, shot.pose, jobs);
        shot.camera = randomCamera(posed.positions(), i % 4 == 3, random);
        SplatImage image;
        drawer.project(shot.pose, shot.camera).blend(image);
        shot.rgb = std::move(image.rgb), shot.alpha = std::move(image.alpha);
        shots_.push_back(std::move(shot));
    }
}

PackError PackPictures::compare(const AvatarData& packed) const {
    PackError error;
    AvatarDrawer drawer(packed, jobs_);
    SplatImage image;
    for (const Shot& shot : shots_) {
        drawer.project(shot.pose, shot.camera).blend(image);
        for (size_t p = 0; p < shot.alpha.size(); ++p) {
            error.allValues += 3;
            if (!(std::max(shot.alpha[p], image.alpha[p]) > 0)) continue;
            error.values += 3;
            for (size_t k = 0; k < 3; ++k) {
                const double off = double(image.rgb[3 * p + k]) - shot.rgb[3 * p + k] + kGrey * (double(shot.alpha[p]) - image.alpha[p]);
                error.squares += off * off;
            }
        }
    }
    return error;
}

std::vector<float> PackPictures::importance(const AvatarData& avatar) const {
    std::vector<double> sum(avatar.splats.count(), 0.0);
    AvatarDrawer drawer(avatar, jobs_);
    for (const Shot& shot : shots_) addContributions(drawer.project(shot.pose, shot.camera), shot.camera, sum);
    return {sum.begin(), sum.end()};
}

}  // namespace dpl
