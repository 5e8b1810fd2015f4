// SPDX-License-Identifier: Apache-2.0
// A folder of the NeuMan layout that the procedural subject makes. The data themselves are not ours to have.
#pragma once

#include <array>
#include <cstdio>
#include <string_view>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/subject/sample/scan_writer.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_import/made_captures.h"

namespace dpl {

/** COLMAP's world against that of the made scan: X' = kNeumanScale · kNeumanTurn · X + kNeumanShift. */
constexpr double kNeumanScale = 0.37;
inline const Mat3d kNeumanTurn = glm::mat3_cast(glm::normalize(Quatd(0.3, 0.8, -0.4, 0.2)));
inline const Vec3d kNeumanShift(1.5, -0.7, 2.25);

inline constexpr std::array<std::string_view, 17> kCocoOrder = {"nose",       "eye_l",   "eye_r",   "ear_l",   "ear_r",   "shoulder_l",
                                                                "shoulder_r", "elbow_l", "elbow_r", "wrist_l", "wrist_r", "hip_l",
                                                                "hip_r",      "knee_l",  "knee_r",  "ankle_l", "ankle_r"};

/** Every digit of a number, as COLMAP writes. */
inline std::string exact(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

/** NumPy's file of 32-bit floats. */
inline std::vector<uint8_t> npyOf(const std::string& shape, const std::vector<float>& values) {
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': " + shape + ", }";
    header.append(63 - (10 + header.size()) % 64, ' ');
    header += '\n';
    std::vector<uint8_t> bytes = {0x93, 'N', 'U', 'M', 'P', 'Y', 1, 0, uint8_t(header.size() & 255), uint8_t(header.size() >> 8)};
    bytes.insert(bytes.end(), header.begin(), header.end());
    const auto* raw = reinterpret_cast<const uint8_t*>(values.data());
    bytes.insert(bytes.end(), raw, raw + values.size() * sizeof(float));
    return bytes;
}

inline std::string neumanName(size_t index) {
    std::string digits = std::to_string(index);
    return std::string(5 - digits.size(), '0') + digits + ".png";
}

/** The moving frames of the made scan, in the order of the folder. */
inline std::vector<ScanFrame> movingFrames(const Scan& scan) {
    std::vector<ScanFrame> frames;
    for (const ScanFrame& frame : scan.frames)
        if (frame.kind == FrameKind::Dynamic) frames.push_back(frame);
    return frames;
}

/** Writes the moving frames of a scan as a NeuMan subject. Pictures of the model are listed in an order of their own, as COLMAP does. */
inline void writeNeuman(const Scan& scan, const std::filesystem::path& root) {
    const std::vector<ScanFrame> frames = movingFrames(scan);
    std::string list = "# Image list with two lines of data per image:\n";
    for (size_t k = 0; k < frames.size(); ++k) {
        const size_t i = (7 * k + 3) % frames.size();
        const ScanFrame& frame = frames[i];
        const ImageRgb8 image = must(readFrameImage(frame));
        ImageGrey8 mask = must(readFrameMask(frame));
        for (uint8_t& value : mask.pixels) value = value >= 128 ? 0 : 255;
        writeBytes(root / "images" / neumanName(i), must(encodePng(image.pixels, image.widthPx, image.heightPx, 3)));
        writeBytes(root / "segmentations" / neumanName(i), must(encodePng(mask.pixels, mask.widthPx, mask.heightPx, 1)));
        const std::vector<Keypoint> keypoints = must(readKeypoints(scan, frame));
        std::vector<float> rows;
        for (const std::string_view name : kCocoOrder) {
            const size_t at = size_t(std::find(scan.keypointNames.begin(), scan.keypointNames.end(), name) - scan.keypointNames.begin());
            const Keypoint& k17 = keypoints.at(at);
            rows.insert(rows.end(), {float(k17.px.x), float(k17.px.y), float(k17.confidence)});
        }
        writeBytes(root / "keypoints" / (neumanName(i) + ".npy"), npyOf("(17, 3)", rows));
        const Mat3d turn = frame.camera.viewFromWorldRotation * glm::transpose(kNeumanTurn);
        const Vec3d t = kNeumanScale * frame.camera.viewFromWorldTranslation - turn * kNeumanShift;
        const Quatd q = glm::quat_cast(turn);
        list += formatText("{} {} {} {} {} {} {} {} 1 {}\n1.5 2.5 -1\n", i + 1, exact(q.w), exact(q.x), exact(q.y), exact(q.z), exact(t.x),
                           exact(t.y), exact(t.z), neumanName(i));
    }
    const Camerad& camera = frames.front().camera;
    writeText(root / "sparse/cameras.txt",
              formatText("# Camera list with one line of data per camera:\n1 PINHOLE {} {} {} {} {} {}\n", camera.widthPx, camera.heightPx,
                         exact(camera.fx), exact(camera.fy), exact(camera.cx), exact(camera.cy)));
    writeText(root / "sparse/images.txt", list);
    writeText(root / "sparse/points3D.txt", "# 3D point list with one line of data per point:\n");
}

}  // namespace dpl
