// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/sample/scan_files.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "sdk/core/writer.h"

namespace dpl {
namespace {

using Json = nlohmann::ordered_json;

double rounded(double x, double steps) {
    const double r = std::round(x * steps) / steps;
    return r == 0 ? 0.0 : r;  // avoids −0
}

Json triple(const Vec3d& v, double steps = 1e6) {
    return Json::array({rounded(v.x, steps), rounded(v.y, steps), rounded(v.z, steps)});
}

Json pixel(const Vec2d& p) {
    return Json::array({rounded(p.x, 1e3), rounded(p.y, 1e3)});
}

Json cameraJson(const Camerad& c) {
    // Rows of R·M with M = [x, z, −y]: a file point (x, y, z) is the world point (x, z, −y).
    Json r = Json::array();
    for (int row = 0; row < 3; ++row) {
        const double x = c.viewFromWorldRotation[0][row], y = c.viewFromWorldRotation[1][row], z = c.viewFromWorldRotation[2][row];
        for (double v : {x, -z, y}) r.push_back(rounded(v, 1e12));
    }
    return {{"fx", rounded(c.fx, 1e9)},
            {"fy", rounded(c.fy, 1e9)},
            {"cx", c.cx},
            {"cy", c.cy},
            {"R", r},
            {"t", triple(c.viewFromWorldTranslation, 1e12)}};
}

/** The names of the first `count` keypoints: the body's, then the hands'. */
Json nameList(const Subject& subject, size_t count) {
    Json names = Json::array();
    for (const auto* keypoints : {&subject.keypoints, &subject.handKeypoints})
        for (const BodyKeypoint& k : *keypoints)
            if (names.size() < count) names.push_back(k.name);
    return names;
}

}  // namespace

std::string scanJson(const Subject& subject, const std::vector<PlannedFrame>& frames, const SampleScanOptions& o) {
    Json j;
    j["format"] = "avatar-scan";
    j["version"] = 1;
    j["name"] = subject.name;
    j["subject"] = "procedural";
    j["units"] = {{"length", "metre"}, {"angle", "radian"}, {"time", "second"}};
    j["world"] = "right-handed, z up, floor at z=0; at rest the subject stands at the origin and faces -y, its left side is +x";
    j["camera_convention"] =
        "OpenCV: x right, y down, z forward; X_cam = R X_world + t with R row by row; u = fx x/z + cx, v = fy y/z + cy; (0,0) is the "
        "top-left corner of the image, the first pixel has its centre at (0.5,0.5)";
    j["image_size"] = {o.widthPx, o.heightPx};
    j["camera_model"] = "pinhole";
    j["distortion"] = {0.0, 0.0};
    j["labels"] = {{"background", 0}, {"body", 1}, {"top", 2}, {"bottom", 3}, {"hair", 4}, {"shoes", 5}};
    j["keypoint_names"] = nameList(subject, subject.keypoints.size());
    Json names = Json::array(), parents = Json::array(), positions = Json::array();
    for (const JointData& joint : subject.joints) {
        names.push_back(joint.name);
        parents.push_back(joint.parent);
        positions.push_back(triple(fileFromWorld(Vec3d(joint.restPosition)), 1e9));
    }
    j["skeleton"] = {{"names", names}, {"parents", parents}, {"rest_positions", positions}};
    Json parts = Json::array();
    constexpr const char* kLabelNames[] = {"background", "body", "top", "bottom", "hair", "shoes"};
    for (size_t i = 0; i < subject.parts.size(); ++i) {
        const LayerData& layer = subject.mesh.layers[i];
        parts.push_back({{"name", subject.parts[i].name},
                         {"label", kLabelNames[subject.parts[i].label]},
                         {"first_vertex", layer.firstVertex},
                         {"vertex_count", layer.vertexCount},
                         {"first_triangle", layer.firstTriangle},
                         {"triangle_count", layer.triangleCount},
                         {"cloth", subject.parts[i].cloth}});
    }
    j["geometry"] = {{"template", "geometry/template.ply"},
                     {"weights", "geometry/weights.bin"},
                     {"parts", parts},
                     {"vertex_count", subject.mesh.restPositions.size()},
                     {"triangle_count", subject.mesh.triangles.size()}};
    j["truth"] = "truth.json";
    j["counts"] = {{"static_full", o.fullFrames}, {"static_closeup", o.closeupFrames}, {"dynamic", o.dynamicFrames}};
    Json list = Json::array();
    for (size_t i = 0; i < frames.size(); ++i) {
        const PlannedFrame& f = frames[i];
        Json entry{{"id", i},
                   {"name", f.name},
                   {"kind", frameKindName(f.kind)},
                   {"split", splitName(f.split)},
                   {"image", "images/" + f.name + ".jpg"},
                   {"mask", "masks/" + f.name + ".png"},
                   {"labels", "labels/" + f.name + ".png"},
                   {"keypoints", "keypoints/" + f.name + ".json"},
                   {"camera", cameraJson(f.camera)}};
        if (!f.closeupOf.empty()) entry["closeup_of"] = f.closeupOf;
        if (f.kind == FrameKind::Dynamic) entry["time"] = rounded(f.timeS, 1e6);
        list.push_back(std::move(entry));
    }
    j["frames"] = std::move(list);
    return j.dump(1) + "\n";
}

std::string truthJson(const Subject& subject, const std::vector<PlannedFrame>& frames, const std::vector<TruePoints>& truePoints) {
    Json j;
    j["format"] = "avatar-scan-truth";
    j["version"] = 1;
    j["rotations"] = "axis-angle per joint, in the order of skeleton.names, relative to the parent, axes parallel to the world at rest";
    Json morphs = Json::object();
    for (const auto& [name, value] : subject.morphValues) morphs[name] = rounded(double(value), 1e9);
    j["shape"] = {{"body", "builtin"}, {"seed", subject.seed}, {"morphs", morphs}};
    Json list = Json::array();
    for (size_t i = 0; i < frames.size(); ++i) {
        const PlannedFrame& f = frames[i];
        Json rotations = Json::array(), points = Json::array(), hands = Json::array();
        for (const Vec3d& r : f.pose.rotations) rotations.push_back(triple(fileFromWorld(r), 1e9));
        for (const Vec3d& p : truePoints[i].body) points.push_back(triple(fileFromWorld(p), 1e7));
        Json entry{{"name", f.name},
                   {"rotations", rotations},
                   {"translation", triple(fileFromWorld(f.pose.translation), 1e9)},
                   {"keypoints_world", points}};
        for (const Vec3d& p : truePoints[i].hands) hands.push_back(triple(fileFromWorld(p), 1e7));
        if (!hands.empty()) entry["hand_keypoints_world"] = hands;
        for (const BarsSeen& seen : truePoints[i].bars) {
            Json top = Json::array(), bottom = Json::array();
            for (const Vec2d& p : seen.topPx) top.push_back(pixel(p));
            for (const Vec2d& p : seen.bottomPx) bottom.push_back(pixel(p));
            entry["bars"].push_back({{"width_mm", rounded(seen.barMm, 1e6)}, {"top_px", top}, {"bottom_px", bottom}});
        }
        entry["posed"] = f.keepPosed ? Json("posed/" + f.name + ".bin") : Json(nullptr);
        list.push_back(std::move(entry));
    }
    j["frames"] = std::move(list);
    return j.dump() + "\n";
}

std::string keypointsJson(const Subject& subject, const PlannedFrame& frame, const std::vector<SampleKeypoint>& keypoints) {
    Json xy = Json::array(), noisy = Json::array(), visibility = Json::array(), confidence = Json::array(), sigma = Json::array();
    for (const SampleKeypoint& k : keypoints) {
        xy.push_back(k.inFront ? pixel(k.px) : Json(nullptr));
        noisy.push_back(k.inFront ? pixel(k.noisyPx) : Json(nullptr));
        visibility.push_back(k.visibility);
        confidence.push_back(rounded(k.confidence, 1e3));
        sigma.push_back(rounded(k.sigmaPx, 1e3));
    }
    const Json j{{"image", frame.name},
                 {"names", nameList(subject, keypoints.size())},
                 {"xy", xy},
                 {"detections", noisy},
                 {"visibility", visibility},
                 {"confidence", confidence},
                 {"noise_sigma_px", sigma}};
    return j.dump() + "\n";
}

std::vector<uint8_t> templatePly(const Subject& subject) {
    const MeshData& mesh = subject.mesh;
    const std::string header =
        "ply\nformat binary_little_endian 1.0\ncomment " + subject.name + "\nelement vertex " + std::to_string(mesh.restPositions.size()) +
        "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar label\nelement face " +
        std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nproperty uchar hidden\nend_header\n";
    Writer out;
    out.append({reinterpret_cast<const uint8_t*>(header.data()), header.size()});
    for (size_t i = 0; i < subject.parts.size(); ++i)
        for (uint32_t v = mesh.layers[i].firstVertex; v < mesh.layers[i].firstVertex + mesh.layers[i].vertexCount; ++v) {
            const Vec3d p = fileFromWorld(Vec3d(mesh.restPositions[v]));
            for (int c = 0; c < 3; ++c) out.value(float(p[c]));
            out.value(subject.parts[i].label);
        }
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        out.value(uint8_t(3));
        for (int c = 0; c < 3; ++c) out.value(int32_t(mesh.triangles[t][c]));
        out.value(subject.hiddenFace[t]);
    }
    return out.finish();
}

std::vector<uint8_t> weightsBin(const Subject& subject) {
    const MeshData& mesh = subject.mesh;
    Writer out;
    out.value(uint32_t(mesh.restPositions.size()));
    out.value(uint32_t(subject.joints.size()));
    out.value(uint32_t(4));
    for (const auto& j : mesh.jointIndices)
        for (int k = 0; k < 4; ++k) out.value(int32_t(j[k]));
    for (const auto& w : mesh.jointWeights)
        for (int k = 0; k < 4; ++k) out.value(float(w[k]) / 255.0f);
    return out.finish();
}

std::vector<uint8_t> posedBin(const std::vector<Vec3d>& vertices) {
    Writer out;
    for (const Vec3d& v : vertices) {
        const Vec3d p = fileFromWorld(v);
        for (int c = 0; c < 3; ++c) out.value(float(p[c]));
    }
    return out.finish();
}

}  // namespace dpl
