// SPDX-License-Identifier: Apache-2.0
// Writes the truth of a toy reconstruction in the format of scans: the ball's own mesh in the true poses.
#pragma once

#include "sdk/core/writer.h"
#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl::test {

/** World to file: z up. */
inline Vec3f inFile(const Vec3f& p) {
    return {p.x, -p.z, p.y};
}

inline nlohmann::json tripleOf(const Vec3f& p) {
    return {p.x, p.y, p.z};
}

inline void mustWrite(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    std::filesystem::create_directories(path.parent_path());
    if (const Status written = writeFileAtomically(path, bytes); !written) throw std::runtime_error(written.error().message);
}
inline void mustWrite(const std::filesystem::path& path, const std::string& text) {
    mustWrite(path, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

/** Vertices of the ball in a pose. */
inline std::vector<Vec3f> ballIn(const AvatarData& ball, const Pose& pose, Jobs& jobs) {
    std::vector<Mat3x4f> worldFromRest;
    std::vector<Vec3f> positions;
    jointTransforms(ball.joints, pose, worldFromRest);
    skin(ball.mesh, worldFromRest, jobs, positions);
    return positions;
}

inline std::vector<uint8_t> floatsOf(const std::vector<Vec3f>& positions) {
    Writer out;
    for (const Vec3f& p : positions)
        for (int c = 0; c < 3; ++c) out.value(inFile(p)[c]);
    return out.finish();
}

/** Writes truth.json, scan.json, geometry/ and posed/ into the toy's scan folder. The triangles from `firstCloth` on count as cloth, with
 *  the label "top". */
inline void writeTruth(ToyReconstruction& toy, size_t firstCloth = ~size_t(0)) {
    const AvatarData& ball = toy.avatar;
    const MeshData& mesh = ball.mesh;
    const std::filesystem::path& root = toy.table.scan.root;
    Writer ply;
    const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.restPositions.size()) +
                               "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar label\nelement face " +
                               std::to_string(mesh.triangles.size()) +
                               "\nproperty list uchar int vertex_indices\nproperty uchar hidden\nend_header\n";
    ply.append({reinterpret_cast<const uint8_t*>(header.data()), header.size()});
    for (const Vec3f& p : mesh.restPositions) {
        for (int c = 0; c < 3; ++c) ply.value(inFile(p)[c]);
        ply.value(uint8_t(1));
    }
    for (const Triangle& t : mesh.triangles) {
        ply.value(uint8_t(3));
        for (int c = 0; c < 3; ++c) ply.value(int32_t(t[c]));
        ply.value(uint8_t(0));
    }
    mustWrite(root / "geometry/template.ply", ply.finish());
    Writer weights;
    for (const size_t n : {mesh.restPositions.size(), ball.joints.size(), size_t(4)}) weights.value(uint32_t(n));
    for (const auto& joints : mesh.jointIndices)
        for (int k = 0; k < 4; ++k) weights.value(int32_t(joints[k]));
    for (const auto& w : mesh.jointWeights)
        for (int k = 0; k < 4; ++k) weights.value(float(w[k]) / 255.0f);
    mustWrite(root / "geometry/weights.bin", weights.finish());
    nlohmann::json skeleton = {{"parents", nlohmann::json::array()}, {"rest_positions", nlohmann::json::array()}}, frames;
    for (const JointData& joint : ball.joints) {
        skeleton["parents"].push_back(joint.parent);
        skeleton["rest_positions"].push_back(tripleOf(inFile(joint.restPosition)));
    }
    const size_t bare = std::min(firstCloth, mesh.triangles.size());
    const nlohmann::json parts = {
        {{"name", "ball"}, {"label", "body"}, {"first_triangle", 0}, {"triangle_count", bare}, {"cloth", false}},
        {{"name", "cap"}, {"label", "top"}, {"first_triangle", bare}, {"triangle_count", mesh.triangles.size() - bare}, {"cloth", true}}};
    mustWrite(root / "scan.json", nlohmann::json{{"skeleton", skeleton}, {"geometry", {{"parts", parts}}}}.dump());
    for (size_t f = 0; f < ToyReconstruction::kFrames; ++f) {
        const ScanFrame& frame = toy.table.scan.frames[f];
        nlohmann::json rotations;
        for (const Quatf& q : toy.truth[f].localRotations) {
            const float angle = glm::angle(q);
            rotations.push_back(tripleOf(angle > 0 ? angle * inFile(glm::axis(q)) : Vec3f(0)));
        }
        nlohmann::json entry = {
            {"name", frame.name}, {"rotations", rotations}, {"translation", tripleOf(inFile(toy.truth[f].rootTranslation))}};
        if (frame.kind == FrameKind::Dynamic) {
            entry["posed"] = "posed/" + frame.name + ".bin";
            mustWrite(root / "posed" / (frame.name + ".bin"), floatsOf(ballIn(ball, toy.truth[f], toy.jobs)));
        }
        frames.push_back(entry);
    }
    mustWrite(root / "truth.json", nlohmann::json{{"frames", frames}}.dump());
}

}  // namespace dpl::test
