// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/subject/body/smplx.h"

#include <algorithm>
#include <cmath>

#include "reconstruction/base/npz.h"
#include "reconstruction/subject/body/body_tools.h"
#include "sdk/avatar/humanoid.h"
#include "sdk/core/files.h"
#include "sdk/format/skin_weights.h"

namespace dpl {
namespace {

constexpr size_t kMaxNpzBytes = size_t(2) << 30;

const char* const kBodyJoints[22] = {"pelvis",     "left_hip",    "right_hip",    "spine1",     "left_knee",     "right_knee",
                                     "spine2",     "left_ankle",  "right_ankle",  "spine3",     "left_foot",     "right_foot",
                                     "neck",       "left_collar", "right_collar", "head",       "left_shoulder", "right_shoulder",
                                     "left_elbow", "right_elbow", "left_wrist",   "right_wrist"};
const char* const kFingers[5] = {"index", "middle", "pinky", "ring", "thumb"};

std::vector<std::string> jointNames(size_t count) {
    std::vector<std::string> names(kBodyJoints, kBodyJoints + 22);
    if (count == 24) return names.insert(names.end(), {"left_hand", "right_hand"}), names;
    if (count == 55) names.insert(names.end(), {"jaw", "left_eye", "right_eye"});
    if (count == 55 || count == 52)
        for (const char* side : {"left", "right"})
            for (const char* finger : kFingers)
                for (int i = 1; i <= 3; ++i) names.push_back(formatText("{}_{}{}", side, finger, i));
    if (names.size() == count) return names;
    names.clear();
    for (size_t j = 0; j < count; ++j) names.push_back(formatText("joint{}", j));
    return names;
}

}  // namespace

Result<BodyModel> importSmplx(const std::filesystem::path& path, const SmplxOptions& options) {
    DPL_TRY(const auto bytes, readFile(path, kMaxNpzBytes));
    const auto named = [&](const Error& e) { return fail(e.code, "{}: {}", path.string(), e.message); };
    auto npz = NpzFile::open(bytes);
    if (!npz) return named(npz.error());

    NpyArray arrays[6];
    const char* const names[6] = {"v_template", "shapedirs", "J_regressor", "weights", "kintree_table", "f"};
    for (int i = 0; i < 6; ++i) {
        auto array = npz->read(names[i]);
        if (!array) return named(array.error());
        for (double v : array->values)
            if (!std::isfinite(v)) return fail(Code::CorruptData, "{}: '{}' holds a number that is not finite", path.string(), names[i]);
        arrays[i] = std::move(*array);
    }
    const NpyArray &vTemplate = arrays[0], &shapeDirs = arrays[1], &regressor = arrays[2], &weights = arrays[3], &tree = arrays[4],
                   &faces = arrays[5];
    const auto shapeIs = [](const NpyArray& a, std::initializer_list<size_t> wanted) {  // 0 accepts any size
        return a.shape.size() == wanted.size() &&
               std::equal(wanted.begin(), wanted.end(), a.shape.begin(), [](size_t w, size_t s) { return w == 0 || w == s; });
    };
    if (!shapeIs(vTemplate, {0, 3}) || !shapeIs(tree, {2, 0}))
        return fail(Code::CorruptData, "{}: v_template must be V×3 and kintree_table 2×J", path.string());
    const size_t vertices = vTemplate.shape[0], joints = tree.shape[1];
    if (!shapeIs(shapeDirs, {vertices, 3, 0}) || !shapeIs(regressor, {joints, vertices}) || !shapeIs(weights, {vertices, joints}) ||
        !shapeIs(faces, {0, 3}) || joints == 0 || joints > 1024)
        return fail(Code::CorruptData, "{}: shapedirs, J_regressor, weights or f do not fit {} vertices and {} joints", path.string(),
                    vertices, joints);

    BodyModel body;
    body.name = path.stem().string();
    const auto regress = [&](size_t joint, auto&& vertexOf) {
        Vec3d sum(0);
        for (size_t v = 0; v < vertices; ++v)
            if (const double w = regressor.values[joint * vertices + v]; w != 0) sum += w * vertexOf(v);
        return sum;
    };
    const auto templateOf = [&](size_t v) {
        return Vec3d(vTemplate.values[3 * v], vTemplate.values[3 * v + 1], vTemplate.values[3 * v + 2]);
    };
    double floorY = 1e9;
    for (size_t v = 0; v < vertices; ++v) floorY = std::min(floorY, templateOf(v).y);
    const Vec3d lift(0, -floorY, 0);

    const std::vector<std::string> jointNameList = jointNames(joints);
    for (size_t j = 0; j < joints; ++j) {
        const double parent = tree.values[j];  // 2³² − 1 or −1 for the root
        if (j > 0 && !(parent >= 0 && parent < double(j)))
            return fail(Code::CorruptData, "{}: kintree_table gives joint {} the parent {}", path.string(), j, parent);
        body.joints.push_back({jointNameList[j], j == 0 ? -1 : int32_t(parent), Vec3f(regress(j, templateOf) + lift), ""});
    }
    assignHumanoidBones(body.joints);

    body.mesh.colours.assign(vertices, glm::u8vec4(214, 172, 146, 255));
    std::vector<std::pair<uint32_t, float>> influences;
    for (size_t v = 0; v < vertices; ++v) {
        body.mesh.restPositions.push_back(Vec3f(templateOf(v) + lift));
        influences.clear();
        for (size_t j = 0; j < joints; ++j)
            if (const double w = weights.values[v * joints + j]; w > 0) influences.emplace_back(uint32_t(j), float(w));
        if (influences.empty()) return fail(Code::CorruptData, "{}: vertex {} has no skin weight", path.string(), v);
        const PackedWeights packed = packWeights(influences);
        body.mesh.jointIndices.push_back(packed.joints);
        body.mesh.jointWeights.push_back(packed.weights);
    }
    for (size_t t = 0; t < faces.shape[0]; ++t) {
        Triangle triangle;
        for (int i = 0; i < 3; ++i) {
            const double index = faces.values[3 * t + size_t(i)];
            if (!(index >= 0 && index < double(vertices)))
                return fail(Code::CorruptData, "{}: triangle {} names vertex {}", path.string(), t, index);
            triangle[i] = uint32_t(index);
        }
        body.mesh.triangles.push_back(triangle);
    }
    body.mesh.layers = {{"body", "body", 0, uint32_t(vertices), 0, uint32_t(body.mesh.triangles.size())}};

    const size_t directions = shapeDirs.shape[2];
    for (size_t m = 0; m < std::min<size_t>(options.shapeCount, directions); ++m) {
        const auto offsetOf = [&](size_t v) {
            const double* d = &shapeDirs.values[v * 3 * directions + m];
            return Vec3d(d[0], d[directions], d[2 * directions]);
        };
        ShapeMorph morph{formatText("shape{}{}", m / 10, m % 10), -4, 4, {}, {}};
        for (size_t v = 0; v < vertices; ++v) morph.vertexOffsets.push_back(Vec3f(offsetOf(v)));
        for (size_t j = 0; j < joints; ++j) morph.jointOffsets.push_back(Vec3f(regress(j, offsetOf)));
        body.morphs.push_back(std::move(morph));
    }
    body.keypoints = deriveKeypoints(body);
    DPL_RETURN_IF_ERROR(checkBody(body));
    return body;
}

}  // namespace dpl
