// SPDX-License-Identifier: Apache-2.0
// Compares pictures of the viewer, and makes its avatar.
//
//   viewer_check make OUT.glb                             an avatar with the box that the empty viewer shows
//   viewer_check compose AVATAR ROOM.png SHOT.png TIME    PSNR, in dB, of SHOT to the avatar drawn by the CPU over ROOM
//   viewer_check differ A.png B.png                       mean difference of the channels, in levels
//   viewer_check psnr A.png B.png                         PSNR of the channels, dB; 99 if they are equal
//   viewer_check colour PICTURE.png X Y                   the pixel, as three numbers
//
// compose: pictures without panels of the viewer with one avatar, which plays its first clip at TIME seconds. The PSNR is that of the
// pixels on which the avatar is, and not its shadow on the floor, which ROOM lacks.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "apps/viewer/room_plan.h"
#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/sdk_camera.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/package/tiny_avatar.h"
#include "tests/viewer/room_depth.h"

namespace {

using namespace dpl;

[[noreturn]] void give(const std::string& why) {
    std::fprintf(stderr, "viewer_check: %s\n", why.c_str());
    std::exit(1);
}

template <class T>
T valueOf(Result<T> result) {
    if (!result) give(result.error().message);
    return std::move(*result);
}

Picture read(const char* path) {
    return valueOf(decodePicture(valueOf(readFile(path)), PictureChannels::Rgb));
}

/** Whether the floor that a pixel looks at carries some of a shadow, or its neighbour does. */
bool showsShadow(const doppel::ContactShadow& shadow, const Camerad& camera, const Vec2d& px) {
    const auto vec = [](const float* v) { return Vec3d(v[0], v[1], v[2]); };
    const Vec3d corner = vec(shadow.corner), across = vec(shadow.across), along = vec(shadow.along), up = glm::cross(along, across);
    const Vec3d way =
        glm::transpose(camera.viewFromWorldRotation) * Vec3d((px.x - camera.cx) / camera.fx, (px.y - camera.cy) / camera.fy, 1);
    const double t = glm::dot(up, corner - camera.eye()) / glm::dot(up, way);
    if (!(t > 0)) return false;
    const Vec3d on = camera.eye() + t * way - corner;
    const auto cell = [&](const Vec3d& axis) { return int(std::floor(DPL_CONTACT_SHADOW_PX * glm::dot(axis, on) / glm::dot(axis, axis))); };
    const int side = int(DPL_CONTACT_SHADOW_PX), column = cell(across), row = cell(along);
    for (int y = std::max(0, row - 1); y <= std::min(side - 1, row + 1); ++y)
        for (int x = std::max(0, column - 1); x <= std::min(side - 1, column + 1); ++x)
            if (shadow.alpha[size_t(y * side + x)] != 0) return true;
    return false;
}

int compose(const char* avatarPath, const char* roomPath, const char* shotPath, double timeS) {
    const Picture room = read(roomPath), shot = read(shotPath);
    if (room.widthPx != shot.widthPx || room.heightPx != shot.heightPx) give("the pictures differ in size");
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    if (!context) give(context.error().message);
    auto avatar = context->loadAvatar(valueOf(readFile(avatarPath)));
    if (!avatar) give(avatar.error().message);
    ViewedSubject subject = valueOf(ViewedSubject::of(std::move(*avatar), "avatar"));
    if (const Status posed = subject.pose({.timeS = timeS}, 0); !posed) give(posed.error().message);

    OrbitCamera orbit;
    orbit.frame(subject.box(), double(shot.widthPx) / shot.heightPx);
    const Camerad camera = orbit.camera(shot.widthPx, shot.heightPx, 0.5 * shot.widthPx);
    std::vector<ViewedSubject> subjects;
    subjects.push_back(std::move(subject));
    const ViewedSubject& shown = subjects[0];
    const std::vector<float> depth = test::roomDepthM(roomAround(subjects, shown.box(), orbit.distanceM()), camera);
    DplCamera view = sdkCamera(camera.cast<float>());
    view.sceneDepthM = depth.data(), view.sceneDepthCount = depth.size();
    const size_t pixels = size_t(shot.widthPx) * shot.heightPx;
    std::vector<uint8_t> over(pixels * 4), layer(pixels * 4);
    for (size_t i = 0; i < pixels; ++i) {
        std::copy_n(&room.pixels[3 * i], 3, &over[4 * i]);
        over[4 * i + 3] = 255;
    }
    const auto draw = [&](std::vector<uint8_t>& rgba, uint32_t flags, DplImageFormat format) {
        DplImage image{};
        image.structSize = sizeof image;
        image.flags = flags, image.format = format;
        image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
        if (const auto drawn = shown.avatar.render({&view, 1}, {&image, 1}); !drawn) give(drawn.error().message);
    };
    draw(over, DPL_IMAGE_OVER, DPL_FORMAT_RGBA8_SRGB);
    draw(layer, 0, DPL_FORMAT_RGBA8);
    const auto shadow = shown.avatar.contactShadow();
    if (!shadow) give(shadow.error().message);
    double sum = 0;
    size_t covered = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (layer[4 * i + 3] == 0) continue;
        if (showsShadow(*shadow, camera, Vec2d(double(i % shot.widthPx) + 0.5, double(i / shot.widthPx) + 0.5))) continue;
        ++covered;
        for (size_t c = 0; c < 3; ++c) {
            const double d = (double(over[4 * i + c]) - double(shot.pixels[3 * i + c])) / 255;
            sum += d * d;
        }
    }
    if (covered < pixels / 50) give("the avatar covers only " + std::to_string(covered) + " pixels");
    std::printf("%.2f\n", 10 * std::log10(double(covered) * 3 / std::max(sum, 1e-12)));
    return 0;
}

/** A board from the stand's near edge to above its far edge. Its clip turns it and lowers it, so that the stand hides its lower edge. */
int make(const char* path) {
    AvatarData avatar = test::tinyAvatar();
    const WorldBox box = boxOf({});
    const auto at = [](const Vec3d& p) { return Vec3f(p); };
    avatar.mesh.restPositions = {at({box.low.x, box.low.y, box.high.z}), at({box.high.x, box.low.y, box.high.z}),
                                 at({box.high.x, box.high.y, box.low.z}), at({box.low.x, box.high.y, box.low.z})};
    for (Vec2f& scaleM : avatar.splats.scaleM) scaleM = Vec2f(0.12f);
    avatar.clips[0].rootTranslations = {{0, 0, 0}, {0, -0.5f, 0}};
    sortSplats(avatar);
    if (const Status written = writeFileAtomically(path, valueOf(writeAvatar(avatar))); !written) give(written.error().message);
    return 0;
}

int differ(const char* first, const char* second) {
    const Picture a = read(first), b = read(second);
    if (a.widthPx != b.widthPx || a.heightPx != b.heightPx) give("the pictures differ in size");
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(int(a.pixels[i]) - int(b.pixels[i]));
    std::printf("%.3f\n", sum / double(a.pixels.size()));
    return 0;
}

int psnr(const char* first, const char* second) {
    const Picture a = read(first), b = read(second);
    if (a.widthPx != b.widthPx || a.heightPx != b.heightPx) give("the pictures differ in size");
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        const double d = (double(a.pixels[i]) - double(b.pixels[i])) / 255;
        sum += d * d;
    }
    std::printf("%.2f\n", sum > 0 ? std::min(99.0, 10 * std::log10(double(a.pixels.size()) / sum)) : 99.0);
    return 0;
}

int colour(const char* path, uint32_t x, uint32_t y) {
    const Picture picture = read(path);
    if (x >= picture.widthPx || y >= picture.heightPx) give("the pixel lies outside the picture");
    const uint8_t* p = &picture.pixels[(size_t(y) * picture.widthPx + x) * 3];
    std::printf("%d %d %d\n", p[0], p[1], p[2]);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const std::string command = argc > 1 ? argv[1] : "";
    if (command == "make" && argc == 3) return make(argv[2]);
    if (command == "compose" && argc == 6) return compose(argv[2], argv[3], argv[4], std::atof(argv[5]));
    if (command == "differ" && argc == 4) return differ(argv[2], argv[3]);
    if (command == "psnr" && argc == 4) return psnr(argv[2], argv[3]);
    if (command == "colour" && argc == 5) return colour(argv[2], uint32_t(std::atoi(argv[3])), uint32_t(std::atoi(argv[4])));
    std::fprintf(stderr, "usage: viewer_check make|compose|differ|psnr|colour ...; see the source\n");
    return 2;
}
