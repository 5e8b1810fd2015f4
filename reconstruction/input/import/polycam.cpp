// SPDX-License-Identifier: Apache-2.0
// Polycam's raw data, as exported in developer mode. Follows github.com/PolyCam/polyform (README, "Raw data") and its reader
// polyform/core/capture_folder.py. Every keyframe has a JSON file with intrinsics in pixels and the first three rows of a camera-to-world
// matrix t_00 … t_23. The world is ARKit's: metres, +Y up. Camera axes are OpenGL's. The corrected_ folders hold what Polycam's own
// optimisation made of them and are read where they exist. Newer versions of the app write no width and height there.
#include <array>

#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/capture/picture_size.h"
#include "reconstruction/input/capture/scan_readers.h"
#include "reconstruction/input/import/folder_contents.h"
#include "reconstruction/input/import/readers.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

Result<Camerad> parsePolycamCamera(const json& object, const ImageHeader& picture, const std::string& where) {
    const JsonFields fields(object, where);
    Camerad camera;
    DPL_TRY(camera.fx, fields.number("fx"));
    DPL_TRY(camera.fy, fields.number("fy"));
    DPL_TRY(camera.cx, fields.number("cx"));
    DPL_TRY(camera.cy, fields.number("cy"));
    DPL_RETURN_IF_ERROR(takeSize(camera, fields, "width", "height", picture));
    std::array<double, 16> pose{};
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 4; ++column) {
            const char key[] = {'t', '_', char('0' + row), char('0' + column), '\0'};
            DPL_TRY(pose[row * 4 + column], fields.number(key));
        }
    setOpenglPose(camera, pose);
    DPL_RETURN_IF_ERROR(checkCamera(camera, where));
    return camera;
}

Result<Capture> readPolycam(const fs::path& root) {
    const fs::path keyframes = root / "keyframes";
    std::error_code ignored;
    const bool corrected =
        fs::is_directory(keyframes / "corrected_cameras", ignored) && fs::is_directory(keyframes / "corrected_images", ignored);
    const fs::path images = keyframes / (corrected ? "corrected_images" : "images");
    const fs::path cameras = keyframes / (corrected ? "corrected_cameras" : "cameras");
    Capture capture;
    capture.what = corrected ? "Polycam raw data, corrected by Polycam" : "Polycam raw data, uncorrected";
    size_t without = 0;
    for (const fs::path& image : picturesIn(images)) {
        const fs::path file = cameras / (image.stem().string() + ".json");
        if (!fs::exists(file, ignored)) {
            ++without;
            continue;
        }
        if (capture.pictures.size() >= kMaxFrames)
            return fail(Code::Unsupported, "{}: more than {} keyframes; remove some", images.string(), kMaxFrames);
        DPL_TRY(const json object, readJsonObject(file));
        CapturePicture picture;
        picture.name = frameName(picture.kind, capture.pictures.size());
        picture.image = image;
        DPL_TRY(const ImageHeader header, probeImage(image));
        DPL_TRY(picture.camera, parsePolycamCamera(object, header, file.string()));
        DPL_RETURN_IF_ERROR(fitToPicture(*picture.camera, header, image, file.string()));
        capture.pictures.push_back(std::move(picture));
    }
    if (capture.pictures.empty())
        return fail(Code::CorruptData, "{}: no picture has a camera in {}; export the raw data again with Polycam's developer mode on",
                    images.string(), cameras.string());
    if (without > 0) capture.notes.push_back(formatText("{} pictures without a camera file are left out", without));
    return capture;
}

}  // namespace dpl
