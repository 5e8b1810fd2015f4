// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/subject.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/input/capture/hand_keypoints.h"
#include "reconstruction/subject/sample/builtin_body.h"
#include "reconstruction/subject/sample/builtin_parts.h"
#include "reconstruction/subject/sample/garments.h"
#include "reconstruction/subject/sample/random.h"

namespace dpl {
namespace {

constexpr int kNearest = 6;  // body vertices from which a garment vertex takes weights and morphs
constexpr float kClearanceM = 0.004f;
constexpr float kHairClearanceM = 0.0012f;                               // hair lies closer to the skin than cloth
constexpr float kUnderLocksM = 0.003f;                                   // thickness of the cap that locks stand on
constexpr const char* kHairNames[] = {"", "-short-hair", "-long-hair"};  // by Hairstyle: in the subject's name
constexpr int kCloseRounds = 8;                                          // smoothing of weights and morphs along a sheet
constexpr float kHangingM = 0.02f;  // cloth farther from the skin hangs free, and takes part in kHangingRounds more
constexpr int kHangingRounds = 200;

struct Fitting {
    const BodyModel& body;
    const std::vector<Vec3f>& displacement;  // per body vertex, by morphs
    std::vector<Vec3f> bodyNormals;
    std::vector<uint8_t> usable;  // per body vertex: 1 if clothes may follow it (not the hands)
};

float smooth01(float t) {
    t = std::clamp(t, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/** Appends a sheet to the subject. Weights and morphs come from the nearest body vertices and are smoothed along the sheet. */
void addGarment(Subject& subject, const Fitting& fit, const SurfaceMesh& sheet, const SubjectPart& part, const char* role, bool rigidHead,
                Jobs& jobs) {
    const size_t count = sheet.positions.size(), jointCount = fit.body.joints.size();
    const auto& bodyAt = fit.body.mesh.restPositions;
    std::vector<float> dense(count * jointCount, 0.0f);
    std::vector<Vec3f> moved(count);
    std::vector<uint32_t> nearest(count);
    std::vector<uint8_t> hangs(count);
    jobs.forRange(count, 64, [&](size_t begin, size_t end, uint32_t) {
        for (size_t v = begin; v < end; ++v) {
            float best[kNearest];
            uint32_t who[kNearest];
            std::fill(best, best + kNearest, 1e9f);
            std::fill(who, who + kNearest, 0u);
            for (uint32_t b = 0; b < bodyAt.size(); ++b) {
                if (!fit.usable[b]) continue;
                const Vec3f d = bodyAt[b] - sheet.positions[v];
                const float d2 = glm::dot(d, d);
                if (d2 >= best[kNearest - 1]) continue;
                int k = kNearest - 1;
                for (; k > 0 && best[k - 1] > d2; --k) best[k] = best[k - 1], who[k] = who[k - 1];
                best[k] = d2, who[k] = b;
            }
            nearest[v] = who[0];
            hangs[v] = best[0] > kHangingM * kHangingM;
            float total = 0;
            for (float d2 : best) total += 1 / (d2 + 1e-5f);
            Vec3f sum(0);
            for (int k = 0; k < kNearest; ++k) {
                const float share = 1 / ((best[k] + 1e-5f) * total);
                sum += share * fit.displacement[who[k]];
                for (int w = 0; w < 4; ++w)
                    dense[v * jointCount + fit.body.mesh.jointIndices[who[k]][w]] +=
                        share * float(fit.body.mesh.jointWeights[who[k]][w]) / 255;
            }
            moved[v] = sum;
            if (rigidHead) {
                std::fill_n(&dense[v * jointCount], jointCount, 0.0f);
                dense[v * jointCount + kHead] = 1;
            }
        }
    });
    const auto neighbours = vertexNeighbours(count, sheet.triangles);
    // Cloth bends more softly than skin, and a skirt spans the legs.
    const bool anyHangs = subject.bottom == Bottom::Skirt && part.label == kLabelBottom;
    for (int round = 0; round < kCloseRounds + (anyHangs ? kHangingRounds : 0); ++round) {
        std::vector<float> nextDense = dense;
        std::vector<Vec3f> nextMoved = moved;
        jobs.forRange(count, 64, [&](size_t begin, size_t end, uint32_t) {
            for (size_t v = begin; v < end; ++v) {
                if (round >= kCloseRounds && !hangs[v]) continue;
                const float share = 0.6f / float(std::max<size_t>(1, neighbours[v].size()));
                for (size_t j = 0; j < jointCount; ++j) nextDense[v * jointCount + j] *= 0.4f;
                nextMoved[v] *= 0.4f;
                for (uint32_t n : neighbours[v]) {
                    nextMoved[v] += share * moved[n];
                    for (size_t j = 0; j < jointCount; ++j) nextDense[v * jointCount + j] += share * dense[n * jointCount + j];
                }
            }
        });
        dense.swap(nextDense);
        moved.swap(nextMoved);
    }
    MeshData& mesh = subject.mesh;
    const uint32_t firstVertex = uint32_t(mesh.restPositions.size()), firstTriangle = uint32_t(mesh.triangles.size());
    for (size_t v = 0; v < count; ++v) {
        Vec3f p = sheet.positions[v] + moved[v];
        const Vec3f skin = bodyAt[nearest[v]] + fit.displacement[nearest[v]];
        const float off = glm::dot(p - skin, fit.bodyNormals[nearest[v]]);
        const float least = rigidHead ? kHairClearanceM : kClearanceM;
        if (off < least) p += (least - off) * fit.bodyNormals[nearest[v]];
        mesh.restPositions.push_back(p);
        subject.canonical.push_back(sheet.positions[v]);
        subject.anchor.push_back(nearest[v]);
    }
    std::vector<glm::u16vec4> indices;
    std::vector<glm::u8vec4> weights;
    cutWeights(dense, jointCount, indices, weights);
    mesh.jointIndices.insert(mesh.jointIndices.end(), indices.begin(), indices.end());
    mesh.jointWeights.insert(mesh.jointWeights.end(), weights.begin(), weights.end());
    for (const Triangle& t : sheet.triangles) mesh.triangles.push_back(t + firstVertex);
    mesh.layers.push_back({part.name, role, firstVertex, uint32_t(count), firstTriangle, uint32_t(sheet.triangles.size())});
    subject.parts.push_back(part);
}

/** Nearest vertex of a layer to a canonical point. */
uint32_t vertexNear(const Subject& subject, const LayerData& layer, const Vec3f& p) {
    uint32_t best = layer.firstVertex;
    for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v)
        if (glm::dot(subject.canonical[v] - p, subject.canonical[v] - p) <
            glm::dot(subject.canonical[best] - p, subject.canonical[best] - p))
            best = v;
    return best;
}

void addClothDynamics(Subject& subject, const WardrobeChoice& wardrobe) {
    subject.cloth.assign(subject.mesh.restPositions.size(), {});
    const auto skeleton = builtinSkeleton();
    const Vec3f shoulder = skeleton[kLeftShoulder].restPosition;
    const Vec3f arm = glm::normalize(skeleton[kLeftElbow].restPosition - shoulder);
    auto alongArm = [&](const Vec3f& p) { return glm::dot(Vec3f(std::abs(p.x), p.y, p.z) - shoulder, arm); };
    for (size_t i = 0; i < subject.parts.size(); ++i) {
        if (!subject.parts[i].cloth || subject.parts[i].label == kLabelHair) continue;
        const LayerData& layer = subject.mesh.layers[i];
        const uint8_t first = uint8_t(subject.drivers.size());
        const bool top = subject.parts[i].label == kLabelTop;
        if (top) {
            for (const Vec3f& at : {Vec3f(0, wardrobe.shirtHemY, 0.14f), Vec3f(0.19f, wardrobe.shirtHemY, 0),
                                    Vec3f(0, wardrobe.shirtHemY, -0.16f), Vec3f(-0.19f, wardrobe.shirtHemY, 0)})
                subject.drivers.push_back({vertexNear(subject, layer, at), 1.25f, 0.22f});
            for (float side : {1.0f, -1.0f}) {
                const Vec3f cuff = shoulder + arm * wardrobe.sleeveM + Vec3f(0, -0.06f, 0);
                subject.drivers.push_back({vertexNear(subject, layer, {side * cuff.x, cuff.y, cuff.z}), 1.7f, 0.25f});
            }
        } else if (subject.bottom == Bottom::Skirt) {
            for (int i = 0; i < 8; ++i) {
                const float angle = 0.785398f * float(i);
                const Vec3f hem(0.25f * std::sin(angle), wardrobe.skirtHemY, 0.22f * std::cos(angle));
                subject.drivers.push_back({vertexNear(subject, layer, hem), 1.1f, 0.20f, 0.12});
            }
        } else {
            for (float side : {1.0f, -1.0f})
                for (float z : {0.10f, -0.10f})
                    subject.drivers.push_back({vertexNear(subject, layer, {side * 0.12f, wardrobe.shortsHemY, z}), 1.4f, 0.22f});
        }
        const uint8_t last = uint8_t(subject.drivers.size());
        for (uint32_t v = layer.firstVertex; v < layer.firstVertex + layer.vertexCount; ++v) {
            const Vec3f p = subject.canonical[v];
            ClothVertex& cloth = subject.cloth[v];
            float free;
            if (top) {
                const float below = glm::dot(Vec3f(std::abs(p.x), p.y, p.z) - shoulder, Vec3f(-arm.y, arm.x, 0));
                const float s = alongArm(p), sleeve = smooth01((s - 0.02f) / 0.05f) * smooth01((below - kSleeveReachM) / 0.04f + 0.5f);
                const float trunk = smooth01((1.16f - p.y) / (1.16f - wardrobe.shirtHemY));
                free = sleeve * 0.75f * smooth01((s - 0.05f) / (wardrobe.sleeveM - 0.05f)) + (1 - sleeve) * trunk;
                // Raised arms pull the shirt up, most at the sides.
                cloth.slide = (1 - sleeve) * (0.012f + 0.030f * smooth01((1.38f - p.y) / 0.5f)) * (0.75f + 0.25f * std::abs(p.x) / 0.18f) *
                              smooth01((1.44f - p.y) / 0.10f);
            } else if (subject.bottom == Bottom::Skirt) {
                free = smooth01((0.88f - p.y) / (0.88f - wardrobe.skirtHemY));
            } else {
                free = 0.85f * smooth01((0.84f - p.y) / (0.84f - wardrobe.shortsHemY));
            }
            if (free <= 0.001f) continue;
            // The three nearest drivers of this garment, by inverse square distance.
            std::array<std::pair<float, uint8_t>, 3> best;
            best.fill({1e9f, 0});
            for (uint8_t d = first; d < last; ++d) {
                const Vec3f q = subject.canonical[subject.drivers[d].vertex] - p;
                std::pair<float, uint8_t> candidate{glm::dot(q, q) + 1e-3f, d};
                for (auto& b : best)
                    if (candidate.first < b.first) std::swap(candidate, b);
            }
            float total = 0;
            for (const auto& b : best) total += 1 / b.first;
            for (int k = 0; k < 3; ++k) {
                cloth.drivers[k] = best[k].second;
                cloth.swing[k] = free / (best[k].first * total);
            }
        }
    }
}

}  // namespace

Subject makeSubject(uint64_t seed, Jobs& jobs, Bottom bottom, Hairstyle hair) {
    Subject subject;
    subject.seed = seed;
    subject.bottom = bottom;
    const bool skirted = bottom == Bottom::Skirt;
    subject.name = "procedural-" + std::to_string(seed) + (skirted ? "-skirt" : "") + kHairNames[size_t(hair)];
    subject.look = makeLook(seed);
    Random random(seed, 1);
    WardrobeChoice wardrobe;
    wardrobe.looseness = float(random.uniform(0.8, 1.3));
    wardrobe.sleeveM = float(random.uniform(0.155, 0.195));
    wardrobe.shirtHemY = float(random.uniform(0.82, 0.85));
    wardrobe.shortsHemY = float(random.uniform(0.555, 0.62));
    wardrobe.hairM = float(random.uniform(0.014, 0.026));
    wardrobe.foldPhase = float(random.uniform(0, 6.28));
    if (hair != Hairstyle::Cap) wardrobe.hairM = kUnderLocksM, wardrobe.quiffM = 0;
    subject.look.shirtHemY = wardrobe.shirtHemY, subject.look.sleeveM = wardrobe.sleeveM,
    subject.look.bottomHemY = skirted ? wardrobe.skirtHemY : wardrobe.shortsHemY;
    subject.look.dotted = skirted;

    const BodyModel body = makeBuiltinBody(jobs);
    const BodyField field;
    for (const ShapeMorph& m : body.morphs) {
        if (m.name == "hair_volume") continue;  // the subject's hair is a layer of its own
        const double spread = m.name == "weight" || m.name == "build" ? 0.9 : m.name == "chest" ? 0.25 : 0.7;
        subject.morphValues.push_back({m.name, float(spread * std::clamp(random.normal(), -1.8, 1.8))});
    }
    std::vector<Vec3f> displacement(body.mesh.restPositions.size(), Vec3f(0));
    subject.joints = body.joints;
    for (const auto& [name, value] : subject.morphValues)
        for (const ShapeMorph& m : body.morphs)
            if (m.name == name) {
                for (size_t v = 0; v < displacement.size(); ++v) displacement[v] += value * m.vertexOffsets[v];
                for (size_t j = 0; j < subject.joints.size(); ++j) subject.joints[j].restPosition += value * m.jointOffsets[j];
            }

    subject.mesh = body.mesh;
    subject.canonical = body.mesh.restPositions;
    for (size_t v = 0; v < displacement.size(); ++v) subject.mesh.restPositions[v] += displacement[v];
    for (uint32_t v = 0; v < displacement.size(); ++v) subject.anchor.push_back(v);
    subject.parts = {{"body", kLabelBody, false}};
    for (const BodyKeypoint& k : body.keypoints) (handKeypointNamed(k.name) < 0 ? subject.keypoints : subject.handKeypoints).push_back(k);

    Fitting fit{body, displacement, vertexNormals(subject.mesh.restPositions, body.mesh.triangles), {}};
    fit.usable.resize(displacement.size());
    for (size_t v = 0; v < displacement.size(); ++v) fit.usable[v] = std::abs(body.mesh.restPositions[v].x) < 0.5f;
    const GarmentPattern below = skirted ? skirtPattern(field, wardrobe) : shortsPattern(field, wardrobe);
    const GarmentPattern shirt = shirtPattern(field, wardrobe, below);
    addGarment(subject, fit, sewGarment(hairPattern(field, wardrobe), jobs), {"hair", kLabelHair, hair == Hairstyle::Long}, "hair", true,
               jobs);
    if (hair != Hairstyle::Cap) sowLocks(subject, hair);
    addGarment(subject, fit, sewGarment(shoePattern(field, wardrobe), jobs), {"shoes", kLabelShoes, false}, "garment", false, jobs);
    addGarment(subject, fit, sewGarment(shirt, jobs), {"top", kLabelTop, true}, "garment", false, jobs);
    addGarment(subject, fit, sewGarment(below, jobs), {"bottom", kLabelBottom, true}, "garment", false, jobs);

    // Skin far enough inside clothes is hidden in every pose.
    std::vector<uint8_t> deep(displacement.size(), 0);
    for (size_t v = 0; v < deep.size(); ++v) {
        const Vec3f p = body.mesh.restPositions[v];
        const bool underShirt = shirt.keep(p) > 0.045f && shirt.field(p) < -0.003f;
        const bool shown = skirted && p.y < wardrobe.skirtHemY + 0.25f;  // a skirt that swings shows the legs
        const bool underBottom = below.keep(p) > 0.060f && below.field(p) < -0.003f && !shown;
        const bool inShoe = p.y < 0.055f && std::abs(p.x) < 0.4f;
        deep[v] = underShirt || underBottom || inShoe;
    }
    subject.hiddenFace.assign(subject.mesh.triangles.size(), 0);
    for (size_t t = 0; t < body.mesh.triangles.size(); ++t) {
        const Triangle& f = body.mesh.triangles[t];
        subject.hiddenFace[t] = deep[f.x] && deep[f.y] && deep[f.z];
    }
    addClothDynamics(subject, wardrobe);
    for (Vec3f& p : subject.mesh.restPositions) p.y += kSoleM;
    for (JointData& j : subject.joints) j.restPosition.y += kSoleM;
    if (hair != Hairstyle::Cap) growLocks(subject, jobs);

    subject.mesh.colours.resize(subject.mesh.restPositions.size());
    for (size_t i = 0; i < subject.parts.size(); ++i)
        for (uint32_t v = subject.mesh.layers[i].firstVertex; v < subject.mesh.layers[i].firstVertex + subject.mesh.layers[i].vertexCount;
             ++v) {
            const Vec3f c = surfaceColour(subject.look, subject.parts[i].label, subject.canonical[v], 0.012f).albedo;
            auto encode = [](float x) {
                return uint8_t(std::clamp(std::pow(std::clamp(x, 0.0f, 1.0f), 1 / 2.2f) * 255 + 0.5f, 0.0f, 255.0f));
            };
            subject.mesh.colours[v] = {encode(c.x), encode(c.y), encode(c.z), 255};
        }
    return subject;
}

}  // namespace dpl
