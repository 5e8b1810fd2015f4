// SPDX-License-Identifier: Apache-2.0
// Qualisys camera calibrations. Follows "Qualisys Track Manager – User Manual", appendix "Calibration file format", and the reader of
// Pose2Sim (github.com/perfanalytics/pose2sim, calibration.py, read_qca). Focal lengths and centres are in 1/64 px; fov_video gives the
// picture that was recorded, in pixels of the sensor. transform holds the camera's place in millimetres in a z-up world, and the rotation
// from the world to a camera with y up and z backwards.
//
// Distortion is taken as Brown's coefficients, as stated. Pose2Sim divides it by 64, which makes it vanish.
#include <expat.h>

#include <cmath>
#include <map>

#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/import/calibration.h"
#include "sdk/core/numbers.h"

namespace dpl {
namespace {

constexpr size_t kMaxQcaCameras = 256;
constexpr double kUnitsPerPixel = 64;

using Attributes = std::map<std::string, std::string>;

/** The elements that matter, for each <camera> in order. */
struct QcaCamera {
    Attributes camera, fov, transform, intrinsic;
};

struct QcaParser {
    std::vector<QcaCamera> cameras;
    XML_Parser parser = nullptr;

    static void begin(void* self, const char* element, const char** attributes) {
        auto& parser = *static_cast<QcaParser*>(self);
        Attributes read;
        for (; attributes[0]; attributes += 2) read.emplace(attributes[0], attributes[1]);
        const std::string_view name = element;
        if (name == "camera") {
            if (parser.cameras.size() >= kMaxQcaCameras) XML_StopParser(parser.parser, XML_FALSE);
            parser.cameras.emplace_back();
        }
        if (parser.cameras.empty()) return;
        QcaCamera& camera = parser.cameras.back();
        Attributes* const kept = name == "camera"      ? &camera.camera
                                 : name == "fov_video" ? &camera.fov
                                 : name == "transform" ? &camera.transform
                                 : name == "intrinsic" ? &camera.intrinsic
                                                       : nullptr;
        if (kept) *kept = std::move(read);
    }
};

Result<double> number(const Attributes& attributes, const char* key, const std::string& where) {
    const auto found = attributes.find(key);
    double value = 0;
    if (found == attributes.end() || !readNumber(found->second, value))
        return fail(Code::CorruptData, "{}: '{}' is missing or not a number; export the calibration again", where, key);
    return value;
}

Result<CalibratedCamera> convert(const QcaCamera& qca, const std::string& file, size_t index) {
    CalibratedCamera out;
    const auto serial = qca.camera.find("serial");
    out.name = serial == qca.camera.end() ? std::to_string(index + 1) : serial->second;
    const std::string where = formatText("{} camera '{}'", file, out.name.substr(0, 60));
    DPL_TRY(const double left, number(qca.fov, "left", where));
    DPL_TRY(const double right, number(qca.fov, "right", where));
    DPL_TRY(const double top, number(qca.fov, "top", where));
    DPL_TRY(const double bottom, number(qca.fov, "bottom", where));
    const double width = right - left + 1, height = bottom - top + 1;
    if (!(width >= 1 && height >= 1 && width <= 65536 && height <= 65536))
        return fail(Code::CorruptData, "{}: fov_video is {} x {} pixels; export the calibration again", where, width, height);
    Camerad& camera = out.camera;
    camera.widthPx = uint32_t(width), camera.heightPx = uint32_t(height);
    DPL_TRY(const double fu, number(qca.intrinsic, "focalLengthU", where));
    DPL_TRY(const double fv, number(qca.intrinsic, "focalLengthV", where));
    DPL_TRY(const double cu, number(qca.intrinsic, "centerPointU", where));
    DPL_TRY(const double cv, number(qca.intrinsic, "centerPointV", where));
    camera.fx = fu / kUnitsPerPixel, camera.fy = fv / kUnitsPerPixel;
    camera.cx = cu / kUnitsPerPixel - left, camera.cy = cv / kUnitsPerPixel - top;
    DPL_TRY(out.lens.k1, number(qca.intrinsic, "radialDistortion1", where));
    DPL_TRY(out.lens.k2, number(qca.intrinsic, "radialDistortion2", where));
    DPL_TRY(out.lens.p1, number(qca.intrinsic, "tangentalDistortion1", where));
    DPL_TRY(out.lens.p2, number(qca.intrinsic, "tangentalDistortion2", where));
    Mat3d r;  // r[column][row] = r<row><column>
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            const char key[] = {'r', char('1' + row), char('1' + column), '\0'};
            DPL_TRY(r[column][row], number(qca.transform, key, where));
        }
    Vec3d place;
    DPL_TRY(place.x, number(qca.transform, "x", where));
    DPL_TRY(place.y, number(qca.transform, "y", where));
    DPL_TRY(place.z, number(qca.transform, "z", where));
    const Mat3d reversed(Vec3d(1, 0, 0), Vec3d(0, -1, 0), Vec3d(0, 0, -1));
    camera.viewFromWorldRotation = reversed * r;
    camera.viewFromWorldTranslation = -(camera.viewFromWorldRotation * (place / 1000.0));
    turnZUpWorld(camera);
    DPL_RETURN_IF_ERROR(checkCamera(camera, where));
    DPL_RETURN_IF_ERROR(checkDistortion(out.lens, camera, where));
    return out;
}

}  // namespace

Result<std::vector<CalibratedCamera>> parseQualisys(std::string_view text, const std::string& where) {
    QcaParser handler;
    handler.parser = XML_ParserCreate("UTF-8");  // whatever the file declares: "ASCII" is common, and expat does not know it
    if (!handler.parser) return fail(Code::OutOfMemory, "{}: no memory to read it", where);
    XML_SetUserData(handler.parser, &handler);
    XML_SetStartElementHandler(handler.parser, &QcaParser::begin);
    const XML_Status status = XML_Parse(handler.parser, text.data(), int(text.size()), 1);
    const XML_Error error = XML_GetErrorCode(handler.parser);
    const auto line = XML_GetCurrentLineNumber(handler.parser);
    XML_ParserFree(handler.parser);
    if (handler.cameras.size() > kMaxQcaCameras)
        return fail(Code::Unsupported, "{}: more than {} cameras; export fewer", where, kMaxQcaCameras);
    if (status != XML_STATUS_OK)
        return fail(Code::CorruptData, "{}: not valid XML at line {} ({}); export the calibration again", where, line,
                    XML_ErrorString(error));
    std::vector<CalibratedCamera> cameras;
    for (size_t i = 0; i < handler.cameras.size(); ++i) {
        DPL_TRY(auto camera, convert(handler.cameras[i], where, i));
        cameras.push_back(std::move(camera));
    }
    if (cameras.empty()) return fail(Code::CorruptData, "{}: it lists no camera; export the calibration again", where);
    return cameras;
}

}  // namespace dpl
