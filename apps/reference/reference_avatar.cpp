// SPDX-License-Identifier: Apache-2.0
// Pose correctives, skinning and binding in double precision.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "apps/reference/reference_maths.h"
#include "apps/reference/reference_renderer.h"

namespace dpl {
namespace {

constexpr double kMinAreaM2 = 1e-10, kMaxAspect = 1e4;
constexpr double kDarkest = 0.2, kBrightest = 3;
constexpr double kDimmest = 0.3, kFullest = 3;  // irradiance over its mean
constexpr double kPi = 3.14159265358979323846;
constexpr double kLeast = 0.5, kLeastGivesWay = 0.25, kMost = 1.7, kMostGivesWay = 0.3;  // singular values of F
constexpr double kFades = 3, kIsGone = 4, kFadesBelow = 0.25;

/** The singular value that is drawn. */
double drawnStretch(double s) {
    if (s > kMost) return kMost + 1 / (1 / (s - kMost) + 1 / kMostGivesWay);
    if (s < kLeast) return kLeast - 1 / (1 / (kLeast - s) + 1 / kLeastGivesWay);
    return s;
}

/** Bounds the singular values of [f0 f1], whose right singular vectors are the eigenvectors of its Gram matrix. Returns the opacity factor
 *  of the triangle's splats. */
double boundStretch(glm::dvec3& f0, glm::dvec3& f1) {
    const double angle = 0.5 * std::atan2(2 * glm::dot(f0, f1), glm::dot(f0, f0) - glm::dot(f1, f1));
    const glm::dvec2 right[2] = {{std::cos(angle), std::sin(angle)}, {-std::sin(angle), std::cos(angle)}};
    const glm::dvec3 wide = right[0].x * f0 + right[0].y * f1, narrow = right[1].x * f0 + right[1].y * f1;
    const double largest = glm::length(wide), smallest = glm::length(narrow);
    if (largest <= kMost && smallest >= kLeast) return 1;
    const glm::dvec3 drawnWide = drawnStretch(largest) / largest * wide, drawnNarrow = drawnStretch(smallest) / smallest * narrow;
    f0 = right[0].x * drawnWide + right[1].x * drawnNarrow, f1 = right[0].y * drawnWide + right[1].y * drawnNarrow;
    double shown = 1;
    for (const double s : {largest, smallest}) shown *= referenceSmoothstep(kIsGone, kFades, s) * referenceSmoothstep(0, kFadesBelow, s);
    return shown;
}

/** Rotation part of J = Q·S by Newton's iteration Q ← ½(Q + Q⁻ᵀ); J must have a positive determinant. */
glm::dmat3 polarRotation(const glm::dmat3& j) {
    glm::dmat3 q = j;
    for (int i = 0; i < 100; ++i) {
        const glm::dmat3 next = 0.5 * (q + glm::transpose(glm::inverse(q)));
        double change = 0;
        for (int c = 0; c < 3; ++c) change += glm::length(next[c] - q[c]);
        q = next;
        if (change < 1e-15) break;
    }
    return q;
}

}  // namespace

std::vector<glm::dmat4> referenceJointTransforms(const std::vector<JointData>& joints, const Pose& pose) {
    std::vector<glm::dmat4> world(joints.size());
    for (size_t j = 0; j < joints.size(); ++j) {
        const glm::dmat3 r = referenceRotation(pose.localRotations[j]);
        const glm::dvec3 p(joints[j].restPosition);
        glm::dmat4 local(r);
        local[3] = glm::dvec4(p - r * p, 1);
        if (joints[j].parent >= 0) {
            world[j] = world[size_t(joints[j].parent)] * local;
        } else {
            local[3] += glm::dvec4(glm::dvec3(pose.rootTranslation), 0);
            world[j] = local;
        }
    }
    return world;
}

ReferenceCoefficients referenceCoefficients(const PoseCorrectiveData& c, const Pose& pose) {
    std::vector<double> heard;
    for (const uint32_t joint : c.joints) {
        const glm::dmat3 turned = referenceRotation(pose.localRotations[joint]) - glm::dmat3(1);
        for (int column = 0; column < 2; ++column)
            for (int row = 0; row < 3; ++row) heard.push_back(turned[column][row] - double(c.mean[heard.size()]));
    }
    std::vector<double> k(c.modeCount, 0.0);
    double squares = 0;
    for (size_t i = 0; i < k.size(); ++i) {
        for (size_t f = 0; f < heard.size(); ++f) k[i] += double(c.modes[i * heard.size() + f]) * heard[f];
        squares += k[i] * k[i];
    }
    // `off`: squared length of the part of the features that is orthogonal to every mode.
    double off = 0;
    for (const double f : heard) off += f * f;
    for (size_t i = 0; i < k.size(); ++i) {
        double mode = 0;
        for (size_t f = 0; f < heard.size(); ++f) mode += double(c.modes[i * heard.size() + f]) * double(c.modes[i * heard.size() + f]);
        if (mode > 0) off -= k[i] * k[i] / mode;
    }
    const double shorter = std::min(1.0, double(c.reach) / std::sqrt(squares));  // for k = 0, reach/0 is infinite and the factor is 1
    const double fade = off > 0 ? std::min(1.0, double(c.reachOffModes) / std::sqrt(off)) : 1.0;
    for (double& x : k) x *= shorter * fade;
    for (const double x : referenceMotion(c.motion, pose)) k.push_back(x);
    return {k, shorter * fade};
}

ReferenceCorrection referenceCorrection(const AvatarData& avatar, const Pose& pose) {
    const size_t vertices = avatar.mesh.restPositions.size();
    ReferenceCorrection out{std::vector<glm::dvec3>(vertices, glm::dvec3(0)), std::vector<double>(vertices, 1.0)};
    const PoseCorrectiveData& c = avatar.correctives;
    if (c.nodeCount == 0) return out;
    const auto [k, drawn] = referenceCoefficients(c, pose);
    std::vector<glm::dvec3> sums(c.nodeCount, glm::dvec3(0));
    for (size_t n = 0; n < sums.size(); ++n)
        for (size_t i = 0; i < k.size(); ++i) sums[n] += k[i] * glm::dvec3(c.nodes[n * k.size() + i]);
    const ExpressionData& expressions = avatar.expressions;
    for (size_t s = 0, e = 0; s < expressions.shapes.size(); ++s)
        for (; e < expressions.ends[s]; ++e)
            sums[expressions.nodes[e]] += double(pose.expression[expressions.shapes[s]]) * glm::dvec3(expressions.offsetsM[e]);
    const std::vector<glm::dvec3> nodes = referenceClothNodes(avatar, pose, drawn, sums);
    for (size_t v = 0; v < vertices; ++v) {
        for (int slot = 0; slot < 4; ++slot) {
            const uint32_t node = c.nodeIndices[v][slot];
            const double share = double(c.nodeWeights[v][slot]) / 255.0;
            out.offset[v] += share * nodes[node];
            for (size_t i = 0; i < k.size(); ++i) out.light[v] += share * k[i] * double(c.nodes[size_t(node) * k.size() + i].w);
        }
        out.light[v] = std::clamp(out.light[v], kDarkest, kBrightest);
    }
    return out;
}

std::vector<glm::dvec3> referenceSkin(const AvatarData& avatar, const Pose& pose) {
    const std::vector<glm::dmat4> joints = referenceJointTransforms(avatar.joints, pose);
    const MeshData& mesh = avatar.mesh;
    const ReferenceCorrection correction = referenceCorrection(avatar, pose);
    std::vector<glm::dvec3> positions(mesh.restPositions.size());
    for (size_t v = 0; v < positions.size(); ++v) {
        glm::dvec4 sum(0);
        const glm::dvec4 rest(glm::dvec3(mesh.restPositions[v]) + correction.offset[v], 1);
        for (int k = 0; k < 4; ++k) {
            const double weight = double(mesh.jointWeights[v][k]) / 255.0;
            if (weight > 0) sum += weight * (joints[mesh.jointIndices[v][k]] * rest);
        }
        positions[v] = glm::dvec3(sum);
    }
    return positions;
}

/** The irradiance on a unit normal over its mean: real spherical harmonics of degrees 1 and 2. */
double referenceIrradiance(const LightData& light, const glm::dvec3& n) {
    const auto& c = light.irradiance;
    const double linear = std::sqrt(3 / (4 * kPi)), mixed = std::sqrt(15 / (4 * kPi));
    double e = 1 + linear * (-double(c[0]) * n.y + double(c[1]) * n.z - double(c[2]) * n.x);
    e += mixed * (double(c[3]) * n.x * n.y - double(c[4]) * n.y * n.z - double(c[6]) * n.x * n.z);
    e += mixed / std::sqrt(12.0) * double(c[5]) * (3 * n.z * n.z - 1) + mixed / 2 * double(c[7]) * (n.x * n.x - n.y * n.y);
    return std::clamp(e, kDimmest, kFullest);
}

/** Brightness of every vertex in the light of the scene. */
std::vector<double> referenceSceneLight(const AvatarData& avatar, const Pose& pose) {
    const MeshData& mesh = avatar.mesh;
    std::map<std::array<float, 3>, glm::dvec3> areas;  // by place
    const auto placeOf = [&](uint32_t v) { return std::array{mesh.restPositions[v].x, mesh.restPositions[v].y, mesh.restPositions[v].z}; };
    for (const Triangle& t : mesh.triangles) {
        const glm::dvec3 a(mesh.restPositions[t.x]), b(mesh.restPositions[t.y]), c(mesh.restPositions[t.z]);
        for (int k = 0; k < 3; ++k) areas[placeOf(t[k])] += glm::cross(b - a, c - a);
    }
    const std::vector<glm::dmat4> joints = referenceJointTransforms(avatar.joints, pose);
    std::vector<double> light;
    for (uint32_t v = 0; v < mesh.restPositions.size(); ++v) {
        const glm::dvec3 area = areas[placeOf(v)], normal = glm::length(area) > 0 ? glm::normalize(area) : glm::dvec3(0, 1, 0);
        glm::dvec3 turned(0);
        for (int k = 0; k < 4; ++k)
            turned += double(mesh.jointWeights[v][k]) / 255.0 * (glm::dmat3(joints[mesh.jointIndices[v][k]]) * normal);
        light.push_back(referenceIrradiance(avatar.light, glm::normalize(turned)) / referenceIrradiance(avatar.light, normal));
    }
    return light;
}

ReferenceScene sceneOf(const AvatarData& avatar, const Pose& pose) {
    ReferenceScene scene;
    for (const Vec3f& p : avatar.mesh.restPositions) scene.rest.emplace_back(p);
    scene.posed = referenceSkin(avatar, pose);
    if (avatar.correctives.nodeCount) scene.light = referenceCorrection(avatar, pose).light;
    if (!avatar.light.empty()) {
        scene.light.resize(scene.rest.size(), 1.0);
        const std::vector<double> turned = referenceSceneLight(avatar, pose);
        for (size_t v = 0; v < turned.size(); ++v) scene.light[v] = std::clamp(scene.light[v] * turned[v], kDarkest, kBrightest);
    }
    scene.triangles = avatar.mesh.triangles;
    scene.shDegree = avatar.splats.shDegree;
    const SplatData& s = avatar.splats;
    const size_t coefficients = size_t(s.shDegree + 1) * (s.shDegree + 1) * 3;
    for (uint32_t t = 0; t < scene.triangles.size() && t + 1 < s.triangleStart.size(); ++t)
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i) {
            ReferenceBoundSplat b{t, glm::dvec2(s.uv[i]), s.phi[i], glm::dvec2(s.scaleM[i]), s.opacity[i], s.flags[i], {}};
            b.sh.assign(s.sh.begin() + ptrdiff_t(i * coefficients), s.sh.begin() + ptrdiff_t((i + 1) * coefficients));
            scene.splats.push_back(std::move(b));
        }
    return scene;
}

ReferenceGaussian referenceGaussian(const ReferenceScene& scene, const ReferenceBoundSplat& splat) {
    ReferenceGaussian g;
    g.valid = false;
    const glm::uvec3 t = scene.triangles[splat.triangle];
    const glm::dvec3 a0 = scene.rest[t.x], e1 = scene.rest[t.y] - a0, e2 = scene.rest[t.z] - a0;
    const glm::dvec3 v0 = scene.posed[t.x], v1 = scene.posed[t.y], v2 = scene.posed[t.z], d1 = v1 - v0, d2 = v2 - v0, d3 = v2 - v1;
    const glm::dvec3 restCross = glm::cross(e1, e2), posedCross = glm::cross(d1, d2);
    const double restArea = glm::length(restCross) / 2, posedArea = glm::length(posedCross) / 2;
    if (!(restArea > kMinAreaM2) || !(posedArea > kMinAreaM2)) return g;
    const double longest = std::max({glm::length(d1), glm::length(d2), glm::length(d3)});
    if (!(longest * longest / (2 * posedArea) < kMaxAspect)) return g;

    const glm::dvec3 n = glm::normalize(restCross), t1 = glm::normalize(e1), t2 = glm::cross(n, t1);
    const glm::dmat2 d(glm::dot(e1, t1), glm::dot(e1, t2), glm::dot(e2, t1), glm::dot(e2, t2));  // columns: rest edges in the tangent plane
    const glm::dmat2 inverse = glm::inverse(d);
    glm::dvec3 f0 = d1 * inverse[0][0] + d2 * inverse[0][1], f1 = d1 * inverse[1][0] + d2 * inverse[1][1];  // F = [d1 d2]·D⁻¹
    const glm::dmat3 worldFromRest = polarRotation(glm::dmat3(f0, f1, glm::normalize(posedCross)) * glm::transpose(glm::dmat3(t1, t2, n)));
    const double shown = scene.stretchIsBounded ? boundStretch(f0, f1) : 1;
    const double c = std::cos(splat.phi), s = std::sin(splat.phi);
    g.axes[0] = splat.scaleM.x * (c * f0 + s * f1);
    g.axes[1] = splat.scaleM.y * (-s * f0 + c * f1);
    g.centre = (1 - splat.uv.x - splat.uv.y) * v0 + splat.uv.x * v1 + splat.uv.y * v2;
    g.normal = glm::normalize(posedCross);
    g.worldFromRest = worldFromRest;
    g.opacity = splat.opacity * shown;
    g.singleFace = splat.flags & kSplatSingleFace;
    g.cloth = splat.flags & kSplatCloth;
    g.shDegree = scene.shDegree;
    g.sh = splat.sh;
    if (!scene.light.empty())
        g.light = (1 - splat.uv.x - splat.uv.y) * scene.light[t.x] + splat.uv.x * scene.light[t.y] + splat.uv.y * scene.light[t.z];
    g.valid = true;
    return g;
}

ReferenceGaussian referenceGaussian(const StaticSplatData& splats, uint32_t index) {
    ReferenceGaussian g;
    const glm::dmat3 r = referenceRotation(splats.rotation[index]);
    for (int k = 0; k < 3; ++k) g.axes[k] = r[k] * double(splats.scaleM[index][k]);
    g.centre = glm::dvec3(splats.position[index]);
    g.opacity = splats.opacity[index];
    g.shDegree = splats.shDegree;
    const size_t coefficients = size_t(splats.shDegree + 1) * (splats.shDegree + 1) * 3;
    g.sh.assign(splats.sh.begin() + ptrdiff_t(index * coefficients), splats.sh.begin() + ptrdiff_t((index + 1) * coefficients));
    return g;
}

}  // namespace dpl
