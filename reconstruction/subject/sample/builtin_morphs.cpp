// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "reconstruction/subject/sample/builtin_parts.h"

namespace dpl {
namespace {

struct MorphMaker {
    const SurfaceMesh& mesh;
    const std::vector<float>& dense;
    const std::vector<JointData>& joints;
    std::vector<Vec3f> normals;
    std::vector<int> child;  // per joint: the joint at the end of its bone, or −1

    MorphMaker(const SurfaceMesh& m, const std::vector<float>& d, const std::vector<JointData>& j)
        : mesh(m), dense(d), joints(j), normals(vertexNormals(m.positions, m.triangles)), child(j.size(), -1) {
        for (int k = int(j.size()) - 1; k > 0; --k) child[j[k].parent] = k;
        child[kPelvis] = kSpine1;
        child[kSpine3] = kNeck;
        child[kHead] = -1;
        child[kLeftWrist] = kLeftMiddle1;
        child[kRightWrist] = kLeftMiddle1 + (kRightIndex1 - kLeftIndex1);
    }

    /** Moves joint j by offset[j], metres. The skin follows its bones; a bone stretches evenly between its ends. */
    ShapeMorph follow(const char* name, std::vector<Vec3f> offset) const {
        ShapeMorph morph{name, -3, 3, std::vector<Vec3f>(mesh.positions.size(), Vec3f(0)), std::move(offset)};
        const size_t count = joints.size();
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            const float* w = &dense[v * count];
            for (size_t j = 0; j < count; ++j) {
                if (w[j] <= 0) continue;
                Vec3f move = morph.jointOffsets[j];
                if (child[j] >= 0) {
                    const Vec3f bone = joints[child[j]].restPosition - joints[j].restPosition;
                    const float t =
                        glm::clamp(glm::dot(mesh.positions[v] - joints[j].restPosition, bone) / glm::dot(bone, bone), 0.0f, 1.0f);
                    move += t * (morph.jointOffsets[child[j]] - morph.jointOffsets[j]);
                }
                morph.vertexOffsets[v] += w[j] * move;
            }
        }
        return morph;
    }

    std::vector<Vec3f> noOffsets() const { return std::vector<Vec3f>(joints.size(), Vec3f(0)); }

    /** Adds `offset` to a joint and its descendants. */
    void moveBranch(std::vector<Vec3f>& offsets, int root, const Vec3f& offset) const {
        std::vector<uint8_t> below(joints.size(), 0);
        for (size_t j = 0; j < joints.size(); ++j) {
            below[j] = int(j) == root || (joints[j].parent >= 0 && below[joints[j].parent]);
            if (below[j]) offsets[j] += offset;
        }
    }

    /** Grows the skin along its normals by `amount(position)` metres, smoothed so that folds do not cross. */
    template <class Amount>
    void grow(ShapeMorph& morph, const Amount& amount) const {
        std::vector<Vec3f> push(mesh.positions.size());
        for (size_t v = 0; v < push.size(); ++v) push[v] = normals[v] * amount(mesh.positions[v]);
        const auto neighbours = vertexNeighbours(push.size(), mesh.triangles);
        for (int round = 0; round < 6; ++round) {
            std::vector<Vec3f> next = push;
            for (size_t v = 0; v < push.size(); ++v) {
                Vec3f sum(0);
                for (uint32_t n : neighbours[v]) sum += push[n];
                next[v] = 0.5f * push[v] + 0.5f * sum / float(neighbours[v].size());
            }
            push = std::move(next);
        }
        for (size_t v = 0; v < push.size(); ++v) morph.vertexOffsets[v] += push[v];
    }
};

float bump(const Vec3f& p, const Vec3f& centre, const Vec3f& radius) {
    const Vec3f q = (p - centre) / radius;
    return std::exp(-glm::dot(q, q));
}

/** 1 for x between low and high, 0 outside, with ramps `soft` wide. */
float band(float x, float low, float high, float soft) {
    auto step = [&](float t) {
        t = glm::clamp(t, 0.0f, 1.0f);
        return t * t * (3 - 2 * t);
    };
    return step((x - low) / soft + 0.5f) * step((high - x) / soft + 0.5f);
}

float weightGrowth(const Vec3f& w) {
    const Vec3f p(std::abs(w.x), w.y, w.z);
    float g = 0.0165f * bump(p, {0, 1.06f, 0.06f}, {0.20f, 0.15f, 0.11f});    // belly
    g += 0.0085f * bump(p, {0.12f, 1.03f, -0.02f}, {0.09f, 0.13f, 0.12f});    // flanks
    g += 0.0090f * bump(p, {0.09f, 0.89f, -0.08f}, {0.13f, 0.12f, 0.12f});    // seat
    g += 0.0070f * bump(p, {0.08f, 1.29f, 0.05f}, {0.13f, 0.11f, 0.12f});     // chest
    g += 0.0060f * bump(p, {0.10f, 1.25f, -0.08f}, {0.14f, 0.17f, 0.10f});    // back
    g += 0.0085f * bump(p, {0.10f, 0.76f, 0}, {0.14f, 0.16f, 0.14f});         // thighs
    g += 0.0038f * bump(p, {0.13f, 0.36f, -0.02f}, {0.10f, 0.14f, 0.12f});    // calves
    g += 0.0052f * bump(p, {0.27f, 1.33f, -0.02f}, {0.12f, 0.12f, 0.12f});    // upper arms
    g += 0.0024f * bump(p, {0.46f, 1.16f, -0.02f}, {0.10f, 0.10f, 0.10f});    // forearms
    g += 0.0045f * bump(p, {0.02f, 1.50f, 0.02f}, {0.08f, 0.05f, 0.08f});     // neck, chin
    g += 0.0036f * bump(p, {0.045f, 1.585f, 0.05f}, {0.04f, 0.035f, 0.06f});  // cheeks
    return g;
}

float buildGrowth(const Vec3f& w) {
    const Vec3f p(std::abs(w.x), w.y, w.z);
    float g = 0.0085f * bump(p, {0.085f, 1.30f, 0.09f}, {0.08f, 0.06f, 0.06f});  // pectorals
    g += 0.0075f * bump(p, {0.21f, 1.405f, -0.02f}, {0.07f, 0.07f, 0.08f});      // deltoids
    g += 0.0065f * bump(p, {0.13f, 1.27f, -0.07f}, {0.07f, 0.12f, 0.08f});       // lats
    g += 0.0070f * bump(p, {0.09f, 1.455f, -0.035f}, {0.07f, 0.04f, 0.05f});     // trapezius
    g += 0.0062f * bump(p, {0.29f, 1.315f, -0.02f}, {0.09f, 0.09f, 0.09f});      // upper arms
    g += 0.0040f * bump(p, {0.43f, 1.19f, -0.02f}, {0.07f, 0.07f, 0.08f});       // forearms
    g += 0.0055f * bump(p, {0.10f, 0.74f, 0.03f}, {0.11f, 0.15f, 0.10f});        // thighs
    g += 0.0048f * bump(p, {0.13f, 0.37f, -0.05f}, {0.09f, 0.09f, 0.06f});       // calves
    g += 0.0035f * bump(p, {0.08f, 0.88f, -0.09f}, {0.08f, 0.08f, 0.07f});       // seat
    g -= 0.0045f * bump(p, {0.03f, 1.06f, 0.08f}, {0.14f, 0.11f, 0.10f});        // a flatter belly
    return g;
}

}  // namespace

std::vector<ShapeMorph> bodyMorphs(const SurfaceMesh& mesh, const std::vector<float>& dense, const std::vector<JointData>& joints) {
    const MorphMaker maker(mesh, dense, joints);
    std::vector<ShapeMorph> morphs;

    {  // Scales everything from the floor: 6 cm taller at value 1.
        ShapeMorph m{"height", -3, 3, {}, {}};
        constexpr float s = 0.06f / 1.75f;
        for (const Vec3f& p : mesh.positions) m.vertexOffsets.push_back(s * p);
        for (const JointData& j : joints) m.jointOffsets.push_back(s * j.restPosition);
        morphs.push_back(std::move(m));
    }
    {
        ShapeMorph m = maker.follow("weight", maker.noOffsets());
        maker.grow(m, weightGrowth);
        morphs.push_back(std::move(m));
    }
    {
        ShapeMorph m = maker.follow("build", maker.noOffsets());
        maker.grow(m, buildGrowth);
        morphs.push_back(std::move(m));
    }
    {
        auto o = maker.noOffsets();
        maker.moveBranch(o, kLeftShoulder, {0.012f, 0, 0});
        maker.moveBranch(o, kRightShoulder, {-0.012f, 0, 0});
        o[kLeftCollar] += Vec3f(0.003f, 0, 0);
        o[kRightCollar] += Vec3f(-0.003f, 0, 0);
        ShapeMorph m = maker.follow("shoulder_width", o);
        for (size_t v = 0; v < mesh.positions.size(); ++v) {  // the rib cage widens with the shoulders
            const Vec3f& p = mesh.positions[v];
            const float chest = band(p.y, 1.20f, 1.42f, 0.14f) * band(std::abs(p.x), -1, 0.17f, 0.06f);
            m.vertexOffsets[v].x += chest * 0.035f * p.x;
        }
        morphs.push_back(std::move(m));
    }
    {
        auto o = maker.noOffsets();
        maker.moveBranch(o, kLeftHip, {0.008f, 0, 0});
        maker.moveBranch(o, kRightHip, {-0.008f, 0, 0});
        ShapeMorph m = maker.follow("hip_width", o);
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            const Vec3f& p = mesh.positions[v];
            if (std::abs(p.x) > 0.30f) continue;
            const float seat = band(p.y, 0.84f, 1.00f, 0.16f);
            m.vertexOffsets[v].x += seat * 0.045f * p.x * float(p.y > 0.80f);
            m.vertexOffsets[v].z += seat * 0.030f * std::min(p.z, 0.0f);
        }
        morphs.push_back(std::move(m));
    }
    {
        auto o = maker.noOffsets();
        for (const auto& [from, to] :
             {std::pair{kLeftShoulder, kLeftElbow}, {kLeftElbow, kLeftWrist}, {kRightShoulder, kRightElbow}, {kRightElbow, kRightWrist}})
            maker.moveBranch(o, to, 0.045f * (joints[to].restPosition - joints[from].restPosition));
        morphs.push_back(maker.follow("arm_length", o));
    }
    {  // The feet stay on the floor; everything above rises.
        auto o = maker.noOffsets();
        maker.moveBranch(o, kPelvis, {0, 0.030f, 0});
        for (int side = 0; side < 2; ++side) {
            o[kLeftKnee + side] = {0, 0.0145f, 0};
            for (int foot : {kLeftAnkle + side, kLeftFoot + side}) o[foot] = Vec3f(0);
        }
        ShapeMorph m = maker.follow("leg_length", o);
        morphs.push_back(std::move(m));
    }
    {
        auto o = maker.noOffsets();
        maker.moveBranch(o, kSpine1, {0, 0.006f, 0});
        maker.moveBranch(o, kSpine2, {0, 0.008f, 0});
        maker.moveBranch(o, kSpine3, {0, 0.007f, 0});
        for (int j : {kNeck, kLeftCollar, kRightCollar}) maker.moveBranch(o, j, {0, 0.007f, 0});
        morphs.push_back(maker.follow("torso_length", o));
    }
    {
        auto o = maker.noOffsets();
        const Vec3f base = joints[kHead].restPosition;
        for (int j : {kJaw, kLeftEye, kRightEye}) o[j] = 0.04f * (joints[j].restPosition - base);
        ShapeMorph m = maker.follow("head_size", o);
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            m.vertexOffsets[v] = dense[v * joints.size() + kHead] * 0.04f * (mesh.positions[v] - base);
        morphs.push_back(std::move(m));
    }
    {  // A cap of hair on the skull: value 1 is short hair, 3 a full head of hair.
        ShapeMorph m = maker.follow("hair_volume", maker.noOffsets());
        m.minValue = 0;
        maker.grow(m, [](const Vec3f& p) {
            // The hairline runs from the forehead over the ears to the nape.
            const float line = 1.700f - 0.95f * std::max(0.0f, 0.075f - p.z);
            const float low = std::max(line, 1.560f);
            return 0.010f * band(p.y, low + 0.006f, 3, 0.022f) * (p.z > 0.03f && p.y < 1.690f ? 0.0f : 1.0f);
        });
        morphs.push_back(std::move(m));
    }
    {
        ShapeMorph m = maker.follow("chest", maker.noOffsets());
        maker.grow(m, [](const Vec3f& w) {
            return 0.015f * bump({std::abs(w.x), w.y, w.z}, {0.072f, 1.275f, 0.10f}, {0.055f, 0.055f, 0.06f});
        });
        morphs.push_back(std::move(m));
    }
    return morphs;
}

}  // namespace dpl
