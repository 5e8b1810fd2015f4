// SPDX-License-Identifier: Apache-2.0
#include "apps/shared/pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "reconstruction/base/sdk_camera.h"
#include "sdk/core/files.h"

namespace dpl {

Error fromSdk(const doppel::Error& error) {
    const Code code = error.code == DPL_ERROR_INVALID_ARGUMENT ? Code::InvalidArgument
                      : error.code == DPL_ERROR_CORRUPT_DATA   ? Code::CorruptData
                      : error.code == DPL_ERROR_UNSUPPORTED    ? Code::Unsupported
                      : error.code == DPL_ERROR_NOT_FOUND      ? Code::NotFound
                      : error.code == DPL_ERROR_VERSION        ? Code::Version
                                                               : Code::Device;
    return {code, error.message};
}

Result<uint32_t> chooseClip(doppel::Avatar& avatar, const std::string& clip, const std::string& animation) {
    auto info = avatar.info();
    if (!info) return fromSdk(info.error());
    std::string names;
    for (uint32_t i = 0; i < info->clipCount; ++i) {
        auto about = avatar.clip(i);
        if (!about) return fromSdk(about.error());
        if (clip == about->name) {
            if (animation.empty()) return i;
            return fail(Code::InvalidArgument, "--animation {}: '{}' is a clip of the avatar, not a glTF file; leave the option out",
                        animation, clip);
        }
        names += (names.empty() ? "" : ", ") + std::string(about->name);
    }
    auto bytes = readFile(clip, uint64_t(512) << 20);
    if (!bytes)
        return fail(bytes.error().code, "--clip {} is neither a clip of the avatar ({}) nor a readable BVH or glTF file", clip,
                    names.empty() ? "it has none" : names);
    DplClipOptions how{};
    how.structSize = sizeof how;
    how.flags = DPL_CLIP_IN_PLACE;  // the camera stands still, so the avatar walks on the spot
    const std::string name = std::filesystem::path(clip).stem().string();
    how.name = name.c_str();
    how.animationName = animation.empty() ? nullptr : animation.c_str();
    auto loaded = avatar.loadClip(*bytes, &how);
    if (!loaded) return fail(fromSdk(loaded.error()).code, "{}: {}", clip, loaded.error().message);
    return *loaded;
}

DplFill fillOf(const std::string& name) {
    return name == "quads" ? DPL_FILL_QUADS : name == "tiles" ? DPL_FILL_TILES : DPL_FILL_AUTO;
}

Mat3d uprightFromFile(const std::string& axes) {
    if (axes == "y-down") return Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
    if (axes == "z-up") return Mat3d(1, 0, 0, 0, 0, -1, 0, 1, 0);
    if (axes == "z-down") return Mat3d(1, 0, 0, 0, 0, 1, 0, -1, 0);
    return Mat3d(1);
}

Mat3d loadedFromFile(const DplFileAxes& axes) {
    Mat3d out;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) out[column][row] = axes.loadedFromFile[3 * column + row];
    return out;
}

Mat3d uprightFromLoaded(const std::string& axes, const Mat3d& loadedFromFile) {
    if (axes.empty()) return Mat3d(1);
    Mat3d fileFromLoaded = glm::transpose(loadedFromFile);
    if (glm::determinant(fileFromLoaded) < 0) fileFromLoaded = Mat3d(-1, 0, 0, 0, 1, 0, 0, 0, 1) * fileFromLoaded;  // cameras do not mirror
    return uprightFromFile(axes) * fileFromLoaded;
}

std::array<float, 12> standing(const Mat3d& upright, double asideM) {
    std::array<float, 12> rows{};
    for (size_t row = 0; row < 3; ++row)
        for (size_t column = 0; column < 3; ++column) rows[4 * row + column] = float(upright[int(column)][int(row)]);
    rows[3] = float(asideM);
    return rows;
}

Cameraf frameAvatar(const DplAvatarInfo& avatar, uint32_t widthPx, uint32_t heightPx, double azimuthRad, const Mat3d& uprightFromFile) {
    Vec3d low(INFINITY), high(-INFINITY);
    for (uint32_t corner = 0; corner < 8; ++corner) {
        Vec3d at;
        for (int k = 0; k < 3; ++k) at[k] = corner >> k & 1 ? avatar.restMax[k] : avatar.restMin[k];
        at = uprightFromFile * at, low = glm::min(low, at), high = glm::max(high, at);
    }
    const Vec3d middle = 0.5 * (low + high);
    const double halfHeight = 0.5 * (high.y - low.y), halfWidth = 0.5 * std::hypot(high.x - low.x, high.z - low.z);
    constexpr double kHalfFovY = 0.3, kMargin = 1.12;  // a 34° lens, as for a portrait of a whole person
    constexpr double kNearestM = 0.2;                  // beyond the near plane and its fade (docs/reference/projection.md)
    double focal = 0.5 * heightPx / std::tan(kHalfFovY);
    const double front = kMargin * std::max(halfHeight * focal / (0.5 * heightPx), halfWidth * focal / (0.5 * widthPx));
    const double farther = front > 0 ? std::max(1.0, kNearestM / front) : 1.0;
    focal *= farther;
    const double distance = front * farther + halfWidth;
    // View axes in the world: z looks from the eye to the middle, y is down.
    const Vec3d back(std::sin(azimuthRad), 0, std::cos(azimuthRad));
    const Vec3d eye = middle + distance * back, z = -back, y(0, -1, 0), x = glm::cross(y, z);
    Camerad camera;
    camera.widthPx = widthPx, camera.heightPx = heightPx;
    camera.fx = camera.fy = focal;
    camera.cx = 0.5 * widthPx, camera.cy = 0.5 * heightPx;
    camera.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * eye);
    camera.viewFromWorldRotation = camera.viewFromWorldRotation * uprightFromFile;
    return camera.cast<float>();
}

Cameraf shiftedSideways(const Cameraf& camera, double metres) {
    Cameraf shifted = camera;
    shifted.viewFromWorldTranslation.x -= float(metres);
    return shifted;
}

Result<std::vector<std::vector<uint8_t>>> drawViews(const doppel::Context& context, std::span<const DplAvatar> avatars,
                                                    std::span<const Cameraf> views) {
    std::vector<std::vector<uint8_t>> pixels(views.size());
    std::vector<DplCamera> cameras;
    std::vector<DplImage> images;
    for (size_t i = 0; i < views.size(); ++i) {
        pixels[i].resize(size_t(views[i].widthPx) * views[i].heightPx * 4);
        cameras.push_back(sdkCamera(views[i]));
        DplImage image{};
        image.structSize = sizeof image;
        image.flags = DPL_IMAGE_STRAIGHT_ALPHA;
        image.rgba = pixels[i].data();
        image.rgbaBytes = pixels[i].size();
        images.push_back(image);
    }
    if (auto drawn = context.renderTogether(avatars, cameras, images); !drawn) return fromSdk(drawn.error());
    return pixels;
}

bool isEmpty(std::span<const std::vector<uint8_t>> views) {
    return std::all_of(views.begin(), views.end(), [](const std::vector<uint8_t>& rgba) {
        for (size_t at = 3; at < rgba.size(); at += 4)
            if (rgba[at] != 0) return false;
        return true;
    });
}

std::string frameNumber(size_t i) {
    const std::string digits = std::to_string(i);
    return digits.size() < 5 ? std::string(5 - digits.size(), '0') + digits : digits;
}

bool isFrameNumber(const std::string& name) {
    return name.size() <= 9 && !name.empty() && name.find_first_not_of("0123456789") == std::string::npos &&
           frameNumber(std::stoul(name)) == name;
}

Result<size_t> removeFrames(const std::filesystem::path& folder, const std::function<bool(const std::string& name)>& isFrame) {
    std::error_code error;
    std::vector<std::filesystem::path> old;
    for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
        if (at->path().extension() == ".png" && isFrame(at->path().stem().string()) && at->is_regular_file(error))
            old.push_back(at->path());
    for (const std::filesystem::path& file : old)
        if (!error && !std::filesystem::remove(file, error) && !error) return fail(Code::Io, "{} vanished; run again", file.string());
    if (error)
        return fail(Code::Io, "cannot remove the frames of an earlier run from {}: {}; name another folder", folder.string(),
                    error.message());
    return old.size();
}

std::vector<uint8_t> sideBySide(std::span<const std::vector<uint8_t>> views, uint32_t widthPx, uint32_t heightPx) {
    std::vector<uint8_t> rgb(views.size() * widthPx * heightPx * 3);
    for (uint32_t row = 0; row < heightPx; ++row) {
        const float background = 236.0f - 40.0f * float(row) / float(heightPx);
        for (size_t view = 0; view < views.size(); ++view)
            for (uint32_t column = 0; column < widthPx; ++column) {
                const uint8_t* in = &views[view][(size_t(row) * widthPx + column) * 4];
                uint8_t* out = &rgb[((size_t(row) * views.size() + view) * widthPx + column) * 3];
                const float alpha = float(in[3]) / 255.0f;
                for (int c = 0; c < 3; ++c) out[c] = uint8_t(float(in[c]) * alpha + background * (1 - alpha) + 0.5f);
            }
    }
    return rgb;
}

}  // namespace dpl
