// SPDX-License-Identifier: Apache-2.0
// The referee (docs/reference): pose correctives, skinning, binding, projection, SH and blending in double precision.
//
// It reads the plain structs of sdk/format and sdk/avatar but calls no code of sdk/math or sdk/splat. Units are metres, radians and pixels;
// pixel (i, j) has its centre at (i + 0.5, j + 0.5). All functions are pure, single-threaded and slow.
//
// To take a finite difference of a whole image:
//     ReferenceScene scene = sceneOf(avatar, pose);
//     scene.splats[7].phi += h;                      // or scene.posed[vertex].x, scene.splats[i].sh[k] ...
//     ReferenceImage plus = renderReference(scene, camera, {.minAlpha = 0, .minTransmittance = 0, .clampColour = false});
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** View axes: x right, y down, z forward; X_view = R X_world + t. Same conventions as PinholeCamera, but no shared code. */
struct ReferenceCamera {
    uint32_t widthPx = 0, heightPx = 0;
    double fx = 0, fy = 0, cx = 0, cy = 0;
    glm::dmat3 rotation{1};
    glm::dvec3 translation{0};
};

/** From any camera struct with the fields of PinholeCamera. */
template <class Camera>
ReferenceCamera referenceCamera(const Camera& c) {
    return {c.widthPx,
            c.heightPx,
            double(c.fx),
            double(c.fy),
            double(c.cx),
            double(c.cy),
            glm::dmat3(c.viewFromWorldRotation),
            glm::dvec3(c.viewFromWorldTranslation)};
}

/** Switches for tests. The cut-offs make the image discontinuous: set both to 0 for finite differences. */
struct ReferenceOptions {
    double kappaPx2 = 0.3;
    bool compensated = true;
    double minAlpha = 1.0 / 255.0;
    double minTransmittance = 1e-4;  // a pixel with T at or below this blends no more splats
    bool clampColour = true;
    std::vector<float>
        sceneDepthM;           // depth of the app's opaque scene, one per pixel; hides splats behind it. Empty, or a value <= 0: no scene
    bool fourSamples = false;  // average four samples per pixel, each low-passed to a quarter of the pixel
};

/** One splat in the world: two axes (flat) or three (general). */
struct ReferenceGaussian {
    glm::dvec3 centre{0};
    glm::dvec3 axes[3] = {glm::dvec3(0), glm::dvec3(0), glm::dvec3(0)};  // unit vectors × standard deviation
    glm::dvec3 normal{0, 0, 1};
    glm::dmat3 worldFromRest{1};
    double opacity = 0;
    bool singleFace = false, cloth = false, valid = true;
    uint32_t shDegree = 0;
    std::vector<double> sh;  // (degree+1)²·3, coefficient-major
    double light = 1;        // brightness L: multiplies the colour before it is clamped
};

/** One splat in one view. visible is false behind the near plane (0.05 m) and for numbers that are not finite. */
struct ReferenceFootprint {
    bool visible = false;
    glm::dvec2 centrePx{0};
    glm::dmat2 covariance{1};  // Σ' including κ, px²
    glm::dmat2 conic{1};       // inverse of `covariance`, 1/px²
    double compensation = 1, gate = 1, nearFade = 1;
    double opacity = 0;  // opacity · compensation · gate · nearFade
    double depthM = 0;
    glm::dvec3 colour{0};
    bool cloth = false;
};

ReferenceFootprint projectReference(const ReferenceGaussian& splat, const ReferenceCamera& camera, const ReferenceOptions& options = {});

/** min(0.99, opacity·exp(−σ)) at a point of the image, before the cut-off. */
double referenceAlpha(const ReferenceFootprint& footprint, const glm::dvec2& pointPx);

/** A bound splat in double precision. Tests may perturb its parameters. */
struct ReferenceBoundSplat {
    uint32_t triangle = 0;
    glm::dvec2 uv{0};
    double phi = 0;
    glm::dvec2 scaleM{0};
    double opacity = 0;
    uint8_t flags = 0;  // kSplatSingleFace | kSplatCloth
    std::vector<double> sh;
};

/** A posed avatar in double precision. */
struct ReferenceScene {
    std::vector<glm::dvec3> rest, posed;  // V vertices, metres; rest: the surface that splats are bound to, without correctives
    std::vector<double> light;            // V brightness factors; empty: all 1
    std::vector<glm::uvec3> triangles;
    std::vector<ReferenceBoundSplat> splats;
    uint32_t shDegree = 0;
    bool stretchIsBounded = true;  // false: F as skinning has it, as frames from before the bounds drew it
};

/** G_j = G_parent·[R_j | p_j − R_j p_j]; the root is shifted by pose.rootTranslation. Normalises the rotations. */
std::vector<glm::dmat4> referenceJointTransforms(const std::vector<JointData>& joints, const Pose& pose);

struct ReferenceCoefficients {
    std::vector<double> k;  // then those of the motion modes
    double drawn = 1;       // share of them that the two limits leave
};
/** Coefficients k of a pose. The features are the first two columns of R − I of each joint in correctives.joints, minus the mean. They are
 *  projected on the modes; then k is shortened to length `reach` and faded when the rest of the features is longer than `reachOffModes`. */
ReferenceCoefficients referenceCoefficients(const PoseCorrectiveData& correctives, const Pose& pose);

/** A pose that was drawn before another one. */
struct ReferenceEarlierPose {
    Pose pose;  // without memory
    double secondsToNext = 0;
};
/** What is left of earlier poses, oldest first, when the pose after the last of them comes. The first had been kept for ever. */
MotionMemory referenceMemory(const MotionModeData& motion, std::span<const ReferenceEarlierPose> earlier);
/** The K' coefficients of the motion modes in a pose, with what is left of earlier ones in Pose::before. */
std::vector<double> referenceMotion(const MotionModeData& motion, const Pose& pose);

/** Offset of the rest surface (metres) and brightness of each vertex, L in [0.2, 3]; zeros and ones without correctives. */
struct ReferenceCorrection {
    std::vector<glm::dvec3> offset;
    std::vector<double> light;
};
ReferenceCorrection referenceCorrection(const AvatarData& avatar, const Pose& pose);

/** Where the limits of cloth leave the M control nodes whose modes sum to `offsets`; metres at rest. */
std::vector<glm::dvec3> referenceClothNodes(const AvatarData& avatar, const Pose& pose, double drawn,
                                            const std::vector<glm::dvec3>& offsets);

/** Irradiance on a unit normal over its mean, within the bounds of docs/reference/light.md. */
double referenceIrradiance(const LightData& light, const glm::dvec3& normal);

/** Posed vertices, world: the corrected rest surface, skinned. */
std::vector<glm::dvec3> referenceSkin(const AvatarData& avatar, const Pose& pose);
ReferenceScene sceneOf(const AvatarData& avatar, const Pose& pose);

/** Computes the world axes, centre, normal and polar rotation of a splat (docs/reference/binding.md). valid is false on degenerate
 *  triangles. */
ReferenceGaussian referenceGaussian(const ReferenceScene& scene, const ReferenceBoundSplat& splat);
ReferenceGaussian referenceGaussian(const StaticSplatData& splats, uint32_t index);

/** Premultiplied, display-referred, row-major, top row first. */
struct ReferenceImage {
    uint32_t widthPx = 0, heightPx = 0;
    std::vector<double> rgb;     // 3 per pixel
    std::vector<double> alpha;   // 1 − T
    std::vector<double> cloth;   // Σ αT over cloth splats
    std::vector<double> depthM;  // Σ αTz / Σ αT, 0 where alpha is 0
};

/** Blends front to back in order of view depth; ties are ordered by index. */
ReferenceImage renderReference(const std::vector<ReferenceGaussian>& splats, const ReferenceCamera& camera,
                               const ReferenceOptions& options = {});
ReferenceImage renderReference(const ReferenceScene& scene, const ReferenceCamera& camera, const ReferenceOptions& options = {});
/** Whether a view of the avatar is drawn with four samples per pixel: true when its pixels at the root joint are more than 5/4 times as
 * coarse as those of the training images. Both eyes of a frame use the result of the eye with the finer pixels. */
bool referenceFourSamples(const AvatarData& avatar, const Pose& pose, const ReferenceCamera& camera);
/** Takes κ, compensation and the number of samples per pixel from the avatar. */
ReferenceImage renderReference(const AvatarData& avatar, const Pose& pose, const ReferenceCamera& camera,
                               const std::vector<float>& sceneDepthM = {});
/** Uncompensated by default, because plain 3D Gaussian splatting files are trained that way. */
ReferenceImage renderReference(const StaticSplatData& splats, const ReferenceCamera& camera,
                               const ReferenceOptions& options = {.compensated = false});

}  // namespace dpl
