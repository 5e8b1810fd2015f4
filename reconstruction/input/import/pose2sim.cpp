// SPDX-License-Identifier: Apache-2.0
// Calibrations of Pose2Sim. Follows github.com/perfanalytics/pose2sim (README, "Calibration"; calibration.py, toml_write). Each table is a
// camera: name, size [width, height], matrix 3 × 3 in pixels, distortions [k1, k2, p1, p2], rotation (Rodrigues vector, world to camera)
// and translation in metres, OpenCV axes, z-up world. The table `metadata` is not a camera.
#include <algorithm>
#include <cmath>
#include <optional>

// toml++ asserts that a table's name begins with a letter, and in a build with NDEBUG tells clang that it does: hostile text is undefined
// behaviour there. Without its asserts it goes on to report an error. This file is compiled by itself for that reason.
#undef NDEBUG
#define TOML_ASSERT(condition) static_assert(true)
#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/import/calibration.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr size_t kMaxCameras = 256;
constexpr uint64_t kMaxCalibrationBytes = 1 << 20;

std::optional<double> numberOf(const toml::node* node) {
    if (!node) return std::nullopt;
    const auto value = node->value<double>();  // whole numbers convert
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/** Exactly `count` numbers of an array, or nothing. */
std::optional<std::vector<double>> numbersOf(const toml::node* node, size_t count) {
    const toml::array* list = node ? node->as_array() : nullptr;
    if (!list || list->size() != count) return std::nullopt;
    std::vector<double> out;
    for (const toml::node& entry : *list) {
        const auto value = numberOf(&entry);
        if (!value) return std::nullopt;
        out.push_back(*value);
    }
    return out;
}

/** Rotation by |v| radians about v. */
Mat3d fromRodrigues(const Vec3d& v) {
    const double angle = glm::length(v);
    if (angle < 1e-12) return Mat3d(1);
    return glm::mat3_cast(glm::angleAxis(angle, v / angle));
}

Result<CalibratedCamera> convert(const toml::table& table, const std::string& key, const std::string& file) {
    CalibratedCamera out;
    out.name = table["name"].value_or(std::string(key));
    const std::string where = formatText("{} camera '{}'", file, out.name.substr(0, 60));
    const auto missing = [&](const char* what) {
        return fail(Code::CorruptData, "{}: '{}' is missing or has the wrong numbers; calibrate again", where, what);
    };
    if (table["fisheye"].value_or(false))
        return fail(Code::Unsupported, "{}: fisheye lenses are not read; undistort the videos first", where);
    const auto size = numbersOf(table.get("size"), 2);
    if (!size || !((*size)[0] >= 1 && (*size)[1] >= 1 && (*size)[0] <= 65536 && (*size)[1] <= 65536)) return missing("size");
    const toml::array* rows = table.get("matrix") ? table.get("matrix")->as_array() : nullptr;
    if (!rows || rows->size() != 3) return missing("matrix");
    const auto first = numbersOf(rows->get(0), 3), second = numbersOf(rows->get(1), 3);
    if (!first || !second) return missing("matrix");
    const toml::array* distortions = table.get("distortions") ? table.get("distortions")->as_array() : nullptr;
    const auto lens = numbersOf(distortions, distortions ? distortions->size() : 0);
    if (!lens || (lens->size() != 4 && lens->size() != 5)) return missing("distortions");
    if (lens->size() == 5 && (*lens)[4] != 0)
        return fail(Code::Unsupported, "{}: distortion k3 is not read; undistort the videos first", where);
    const auto rotation = numbersOf(table.get("rotation"), 3), translation = numbersOf(table.get("translation"), 3);
    if (!rotation) return missing("rotation");
    if (!translation) return missing("translation");
    Camerad& camera = out.camera;
    camera.widthPx = uint32_t((*size)[0]), camera.heightPx = uint32_t((*size)[1]);
    camera.fx = (*first)[0], camera.cx = (*first)[2], camera.fy = (*second)[1], camera.cy = (*second)[2];
    out.lens = {(*lens)[0], (*lens)[1], (*lens)[2], (*lens)[3]};
    camera.viewFromWorldRotation = fromRodrigues({(*rotation)[0], (*rotation)[1], (*rotation)[2]});
    camera.viewFromWorldTranslation = {(*translation)[0], (*translation)[1], (*translation)[2]};
    turnZUpWorld(camera);
    DPL_RETURN_IF_ERROR(checkCamera(camera, where));
    DPL_RETURN_IF_ERROR(checkDistortion(out.lens, camera, where));
    return out;
}

}  // namespace

Result<std::vector<CalibratedCamera>> parsePose2sim(std::string_view text, const std::string& where) {
    // Pose2Sim writes ASCII, and toml++ 3.3 reaches unreachable code at some characters beyond it.
    if (!std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 128; }))
        return fail(Code::Unsupported, "{}: characters beyond ASCII are not read; rename the cameras", where);
    const toml::parse_result parsed = toml::parse(text);
    if (!parsed)
        return fail(Code::CorruptData, "{}: not valid TOML at line {} ({}); calibrate again", where, parsed.error().source().begin.line,
                    std::string(parsed.error().description()));
    const toml::table& file = parsed.table();
    std::vector<CalibratedCamera> cameras;
    for (const auto& [key, node] : file) {
        const toml::table* table = node.as_table();
        if (!table || !table->contains("matrix")) continue;
        if (cameras.size() >= kMaxCameras) return fail(Code::Unsupported, "{}: more than {} cameras", where, kMaxCameras);
        DPL_TRY(auto camera, convert(*table, std::string(key.str()), where));
        cameras.push_back(std::move(camera));
    }
    if (cameras.empty())
        return fail(Code::CorruptData, "{}: no table in it is a camera (matrix, rotation, translation); calibrate again", where);
    return cameras;
}

Result<std::vector<CalibratedCamera>> readCalibration(const std::filesystem::path& file) {
    DPL_TRY(const auto bytes, readFile(file, kMaxCalibrationBytes));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return file.extension() == ".toml" ? parsePose2sim(text, file.string()) : parseQualisys(text, file.string());
}

}  // namespace dpl
