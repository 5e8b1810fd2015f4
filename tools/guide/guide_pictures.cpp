// SPDX-License-Identifier: Apache-2.0
// Draws the pictures of docs/guides/capture.md: the procedural subject filmed well and badly.
//
//     cmake --build --preset release --target guide_pictures
//     build/release/tools/guide/guide_pictures docs/images
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <vector>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/subject/sample/raycast.h"
#include "reconstruction/subject/sample/skeleton.h"
#include "sdk/core/files.h"

namespace {

using namespace dpl;

constexpr uint32_t kWidthPx = 270, kHeightPx = 360;
constexpr int kQuality = 80;

/** A phone's main camera, 26 mm, held upright. yawRad: turned away from the target. */
Camerad phone(const Vec3d& eye, const Vec3d& target, double yawRad = 0) {
    Camerad c;
    c.widthPx = kWidthPx, c.heightPx = kHeightPx;
    c.fx = c.fy = 26.0 / 43.266615 * std::hypot(double(kWidthPx), double(kHeightPx));
    c.cx = 0.5 * kWidthPx, c.cy = 0.5 * kHeightPx;
    const Vec3d way = glm::normalize(target - eye);
    const Vec3d z(std::cos(yawRad) * way.x + std::sin(yawRad) * way.z, way.y, std::cos(yawRad) * way.z - std::sin(yawRad) * way.x);
    const Vec3d x = glm::normalize(glm::cross(z, Vec3d(0, 1, 0))), y = glm::cross(z, x);
    c.viewFromWorldRotation = glm::transpose(Mat3d(x, y, z));
    c.viewFromWorldTranslation = -(c.viewFromWorldRotation * eye);
    return c;
}

/** The mean of several pictures: what a phone takes that moves while its shutter is open. */
std::vector<uint8_t> meanOf(const PersonTracer& tracer, const std::vector<Camerad>& cameras, const RaycastOptions& options) {
    std::vector<double> sum(size_t(kWidthPx) * kHeightPx * 3, 0);
    for (const Camerad& camera : cameras) {
        const RaycastFrame frame = tracer.render(camera, options);
        for (size_t i = 0; i < sum.size(); ++i) sum[i] += frame.rgb[i];
    }
    std::vector<uint8_t> rgb(sum.size());
    for (size_t i = 0; i < sum.size(); ++i) rgb[i] = uint8_t(std::lround(sum[i] / double(cameras.size())));
    return rgb;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]), 2;
    const std::filesystem::path folder = argv[1];
    Jobs jobs;
    const Subject subject = makeSubject(4, jobs, Bottom::Skirt);
    PersonTracer tracer(subject);
    tracer.setVertices(poseSubject(subject, staticPose(4, 0), nullptr));
    const RaycastOptions well{.samplesPerPixel = 9, .sensorNoise = 0.004, .seed = 4};
    const RaycastOptions dark{.samplesPerPixel = 9, .sensorNoise = 0.05, .gain = 0.18, .seed = 4};
    const Vec3d middle(0, 0.9, 0), head(subject.joints[kHead].restPosition), hand(subject.joints[kLeftMiddle1].restPosition);
    const Vec3d eye(0.74, 1.25, 1.6), away(2.1, 1.35, 4.6);
    std::vector<Camerad> shaken;
    for (int i = 0; i < 12; ++i) shaken.push_back(phone(eye, middle, 0.0035 * i - 0.019));
    const struct {
        const char* name;
        std::vector<Camerad> cameras;
        RaycastOptions options;
    } pictures[] = {
        {"capture-good", {phone(eye, middle)}, well},
        {"capture-blurred", shaken, well},
        {"capture-far", {phone(away, middle)}, well},
        {"capture-cut", {phone({0.55, 1.35, 1.2}, {0, 1.28, 0})}, well},
        {"capture-dark", {phone(eye, middle)}, dark},
        {"capture-face", {phone(head + Vec3d(0.18, 0.08, 0.5), head + Vec3d(0, 0.07, 0))}, well},
        {"capture-hand", {phone(hand + Vec3d(0.3, 0.1, 0.26), hand)}, well},
    };
    for (const auto& picture : pictures) {
        const auto bytes = encodeJpeg(meanOf(tracer, picture.cameras, picture.options), kWidthPx, kHeightPx, 3, kQuality);
        const std::filesystem::path path = folder / (std::string(picture.name) + ".jpg");
        const Status written = bytes ? writeFileAtomically(path, *bytes) : Status(bytes.error());
        if (!written) return std::fprintf(stderr, "guide_pictures: %s\n", written.error().message.c_str()), 1;
        std::printf("%s  %zu bytes\n", path.c_str(), bytes->size());
    }
    return 0;
}
