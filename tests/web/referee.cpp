// SPDX-License-Identifier: Apache-2.0
// web_referee AVATAR: what the module must draw, by dplRender on this machine's CPU. Reads shots from stdin, one a line:
//   clip time eyeX eyeY eyeZ targetX targetY targetZ fovYRad width height expression file
// expression: NAME=WEIGHT, several with commas; -: the neutral face.
// web_referee AVATAR --time N [BUDGET...]: the median of N frames, ms, of what the module does for WebGL2 (clip and dplProject), by one
// thread, for each shot; then that of the posed mesh alone (clip and dplGetPosedMesh); no picture. BUDGET: most splats, 0: all; a line
// each. web_referee AVATAR --track: poses of a tracker for MediaPipe Pose that keeps the person in place. Lines of stdin:
//   seen timeMs, then x y z of 33 landmarks, then their 33 visibilities     "nan" is a number here
//   show timeMs                                                             prints state, driven joints, positions of all joints
// web_referee AVATAR --scenes: pictures of several avatars together, by dplRenderTogether; each is AVATAR. A line is
//   width height fx fy cx cy viewFromWorld(12) sceneDepthM count { clip time worldFromAvatar(12) } file
// sceneDepthM: an opaque plane in front of the camera; 0: none.
// web_referee AVATAR --splats: instead of a picture, dplWriteSplats for each shot and its eye: position, covariance, colour and opacity, 13
// floats a splat.
// clip -1: rest. Each picture goes to its file: 4 bytes a pixel, premultiplied, top row first.
#include <doppel/doppel_convert.h>
#include <doppel/doppel_posed.h>
#include <doppel/doppel_splats.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

int complain(const std::string& what) {
    std::fprintf(stderr, "web_referee: %s: %s\n", what.c_str(), dplGetLastError());
    return 1;
}

/** The median of `frames` times, ms: clip 0 at another time each, then `work`. Below 0 after an error. */
template <class Work>
double medianMs(DplAvatar avatar, int frames, const Work& work) {
    std::vector<double> tookMs;
    for (int i = 0; i < frames; ++i) {
        const auto start = std::chrono::steady_clock::now();
        if (dplSetPoseFromClip(avatar, 0, i / 30.0, DPL_TRUE) != DPL_OK || work() != DPL_OK) return -1;
        tookMs.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(tookMs.begin(), tookMs.end());
    return tookMs[tookMs.size() / 2];
}

/** Prints a line for each budget: ms to project, ms to pose the mesh. */
bool timeFrames(DplContext context, DplAvatar avatar, const DplCamera& camera, int frames, const std::vector<uint32_t>& budgets) {
    DplAvatarInfo about{};
    about.structSize = sizeof about;
    if (dplGetAvatarInfo(avatar, &about) != DPL_OK) return false;
    std::vector<DplScreenSplat> splats(about.splatCount);
    std::vector<float> positions(3 * size_t(about.vertexCount));
    DplProjection made{};
    made.structSize = sizeof made;
    for (const uint32_t budget : budgets) {
        DplDetail detail{};
        detail.structSize = sizeof detail;
        detail.splatBudget = budget;
        if (dplSetDetail(context, &detail) != DPL_OK) return false;
        const double projectMs = medianMs(
            avatar, frames, [&] { return dplProject(context, &avatar, 1, &camera, 1, splats.data(), uint32_t(splats.size()), &made); });
        const double meshMs =
            medianMs(avatar, frames, [&] { return dplGetPosedMesh(avatar, positions.data(), about.vertexCount, nullptr, 0); });
        if (projectMs < 0 || meshMs < 0) return false;
        std::printf("%.3f %.3f\n", projectMs, meshMs);
    }
    return true;
}

/** What the module does for webTrack and webSetPoseFromTracker. */
bool track(DplAvatar avatar) {
    DplAvatarInfo about{};
    about.structSize = sizeof about;
    DplTrackerInfo info{};
    info.structSize = sizeof info;
    info.format = DPL_TRACK_MEDIAPIPE_POSE, info.flags = DPL_TRACKER_IN_PLACE;
    DplTracker tracker = nullptr;
    if (dplGetAvatarInfo(avatar, &about) != DPL_OK || dplCreateTracker(avatar, &info, &tracker) != DPL_OK) return false;
    constexpr uint32_t kLandmarks = 33;
    std::vector<float> numbers(4 * kLandmarks), positions(3 * size_t(about.jointCount));
    std::string word, number;
    double timeMs = 0;
    while (std::cin >> word >> timeMs) {
        if (word == "seen") {
            for (float& value : numbers) std::cin >> number, value = std::strtof(number.c_str(), nullptr);  // operator>> knows no "nan"
            DplTrackFrame frame{};
            frame.structSize = sizeof frame;
            frame.jointCount = kLandmarks, frame.timeNs = int64_t(timeMs * 1e6);
            frame.positions = numbers.data(), frame.confidence = numbers.data() + 3 * kLandmarks;
            if (dplTrackFrame(tracker, &frame) != DPL_OK) return false;
            continue;
        }
        DplTrackerStatus status{};
        status.structSize = sizeof status;
        if (dplSetPoseFromTracker(tracker, int64_t(timeMs * 1e6), &status) != DPL_OK) return false;
        if (dplGetJointPositions(avatar, positions.data(), about.jointCount) != DPL_OK) return false;
        std::printf("%d %u", int(status.state), status.drivenJoints);
        for (const float value : positions) std::printf(" %.9g", double(value));
        std::printf("\n");
    }
    return dplDestroyTracker(tracker) == DPL_OK;
}

/** Sets the face to "NAME=WEIGHT,..." or, by "-", to the neutral one. */
bool setExpression(DplAvatar avatar, const std::string& text) {
    std::vector<std::string> names;
    std::vector<float> weights;
    std::istringstream parts(text == "-" ? "" : text);
    for (std::string name, weight; std::getline(parts, name, '=') && std::getline(parts, weight, ',');)
        names.push_back(name), weights.push_back(std::strtof(weight.c_str(), nullptr));
    std::vector<const char*> given(names.size() + 1);  // of no names, the pointer is not null
    for (size_t i = 0; i < names.size(); ++i) given[i] = names[i].c_str();
    return dplSetExpressionNamed(avatar, given.data(), weights.data(), uint32_t(names.size())) == DPL_OK;
}

bool writeFile(const std::string& name, const std::vector<uint8_t>& bytes) {
    std::FILE* out = std::fopen(name.c_str(), "wb");
    if (out && std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size() && std::fclose(out) == 0) return true;
    std::fprintf(stderr, "web_referee: cannot write %s\n", name.c_str());
    return false;
}

/** Nothing after an error. */
std::vector<uint8_t> splatsFor(const float* eye, DplAvatar avatar) {
    constexpr uint32_t kFloats = 13, kBytes = 4 * kFloats;
    DplBufferElement elements[4]{};
    const uint32_t properties[] = {DPL_SPLAT_POSITION, DPL_SPLAT_COVARIANCE, DPL_SPLAT_COLOUR, DPL_SPLAT_OPACITY},
                   floatsBefore[] = {0, 3, 9, 12};
    for (size_t i = 0; i < 4; ++i) {
        elements[i].structSize = sizeof elements[i];
        elements[i].property = properties[i], elements[i].offsetBytes = 4 * floatsBefore[i], elements[i].strideBytes = kBytes;
    }
    DplSplatOptions options{};
    options.structSize = sizeof options;
    options.eye = eye;
    DplWritten written{};
    written.structSize = sizeof written;
    if (dplWriteSplats(avatar, &options, nullptr, &written) != DPL_OK) return {};
    std::vector<uint8_t> bytes(size_t(written.count) * kBytes);
    DplBuffer buffer{};
    buffer.structSize = sizeof buffer;
    buffer.elementCount = 4, buffer.elements = elements;
    buffer.data = bytes.data(), buffer.dataBytes = bytes.size();
    if (dplWriteSplats(avatar, &options, &buffer, &written) != DPL_OK) return {};
    return bytes;
}

int drawScenes(DplContext context, const char* avatarFile) {
    std::vector<DplAvatar> avatars;
    DplCamera camera{};
    camera.structSize = sizeof camera;
    float sceneDepthM = 0;
    size_t count = 0;
    std::string file;
    while (std::cin >> camera.widthPx >> camera.heightPx >> camera.fx >> camera.fy >> camera.cx >> camera.cy) {
        for (float& x : camera.viewFromWorld) std::cin >> x;
        std::cin >> sceneDepthM >> count;
        if (!std::cin || count == 0 || count > DPL_MAX_TOGETHER) return complain("a line is wrong");
        for (size_t k = 0; k < count; ++k) {
            if (k == avatars.size()) avatars.push_back(nullptr);
            if (!avatars[k] && dplLoadAvatarFile(context, avatarFile, &avatars[k]) != DPL_OK) return complain(avatarFile);
            int clip = 0;
            double timeS = 0;
            float worldFromAvatar[12];
            std::cin >> clip >> timeS;
            for (float& x : worldFromAvatar) std::cin >> x;
            if (clip < 0 || dplSetPoseFromClip(avatars[k], uint32_t(clip), timeS, DPL_TRUE) != DPL_OK) return complain("a pose");
            if (dplSetTransform(avatars[k], worldFromAvatar) != DPL_OK) return complain("a place");
        }
        if (!(std::cin >> file)) return complain("a line is wrong");
        const std::vector<float> depthM(sceneDepthM > 0 ? size_t(camera.widthPx) * camera.heightPx : 0, sceneDepthM);
        camera.sceneDepthM = depthM.empty() ? nullptr : depthM.data(), camera.sceneDepthCount = depthM.size();
        std::vector<uint8_t> rgba(size_t(camera.widthPx) * camera.heightPx * 4);
        DplImage image{};
        image.structSize = sizeof image;
        image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
        if (dplRenderTogether(context, avatars.data(), uint32_t(count), &camera, 1, &image) != DPL_OK) return complain(file);
        if (!writeFile(file, rgba)) return 1;
    }
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    const bool tracks = argc == 3 && std::string(argv[2]) == "--track";
    const int timed = argc >= 4 && std::string(argv[2]) == "--time" ? std::atoi(argv[3]) : 0;
    std::vector<uint32_t> budgets;
    for (int i = 4; timed > 0 && i < argc; ++i) budgets.push_back(uint32_t(std::atoi(argv[i])));
    if (budgets.empty()) budgets = {0};
    const bool scenes = argc == 3 && std::string(argv[2]) == "--scenes";
    const bool splats = argc == 3 && std::string(argv[2]) == "--splats";
    if (argc != 2 && timed <= 0 && !tracks && !scenes && !splats) {
        std::fprintf(stderr, "usage: web_referee AVATAR [--time N [BUDGET...] | --track | --scenes | --splats] < SHOTS\n");
        return 2;
    }
    DplContextInfo info{};
    info.structSize = sizeof info;
    info.renderer = DPL_RENDERER_SOFTWARE;
    if (timed > 0) info.threadCount = 1;
    DplContext context = nullptr;
    if (dplCreateContext(&info, &context) != DPL_OK) return complain("no context");
    if (scenes) return drawScenes(context, argv[1]);
    DplAvatar avatar = nullptr;
    if (dplLoadAvatarFile(context, argv[1], &avatar) != DPL_OK) return complain(argv[1]);
    if (tracks) return track(avatar) ? 0 : complain("tracking");
    int clip = 0;
    double timeS = 0;
    float eye[3], target[3], fovYRad = 0;
    uint32_t width = 0, height = 0;
    std::string expression, file;
    for (std::string shot, more; std::getline(std::cin, shot);) {
        std::istringstream fields(shot);
        fields >> clip >> timeS >> eye[0] >> eye[1] >> eye[2] >> target[0] >> target[1] >> target[2] >> fovYRad >> width >> height;
        if (!(fields >> expression >> file) || fields >> more) return complain("a line that is no shot: " + shot);
        if (clip >= 0 && dplSetPoseFromClip(avatar, uint32_t(clip), timeS, DPL_TRUE) != DPL_OK) return complain(file);
        if (!setExpression(avatar, expression)) return complain(expression);
        if (splats) {
            const std::vector<uint8_t> bytes = splatsFor(eye, avatar);
            if (bytes.empty()) return complain(file);
            if (!writeFile(file, bytes)) return 1;
            continue;
        }
        const float up[3] = {0, 1, 0};
        DplCamera camera{};
        camera.structSize = sizeof camera;
        if (dplCameraLookAt(eye, target, up, fovYRad, width, height, &camera) != DPL_OK) return complain(file);
        if (timed > 0) {
            if (!timeFrames(context, avatar, camera, timed, budgets)) return complain(file);
            continue;
        }
        std::vector<uint8_t> rgba(size_t(width) * height * 4);
        DplImage image{};
        image.structSize = sizeof image;
        image.rgba = rgba.data(), image.rgbaBytes = rgba.size();
        if (dplRender(context, avatar, &camera, 1, &image) != DPL_OK) return complain(file);
        if (!writeFile(file, rgba)) return 1;
    }
    dplDestroyContext(context);
    return 0;
}
