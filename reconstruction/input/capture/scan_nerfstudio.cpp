// SPDX-License-Identifier: Apache-2.0
// Reads nerfstudio's transforms.json: OpenGL camera-to-world matrices, shared or per-frame intrinsics, optional masks and split lists.
//
// Many programs write such files: with y up (ARKit) or z up (Blender, nerfstudio), in metres or scaled to a box. So up and scale are
// trusted only where the file states them, by "metric" and "world_up", or NeRFCapture wrote it.
#include <array>
#include <cmath>
#include <map>

#include "reconstruction/base/image_file.h"
#include "reconstruction/input/cameras/camera_convention.h"
#include "reconstruction/input/capture/picture_size.h"
#include "reconstruction/input/capture/scan_readers.h"

namespace dpl {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/** A field of the frame, or of the file when the frame has none: nerfstudio allows frames to override every intrinsic. */
Result<double> eitherNumber(const JsonFields& frame, const JsonFields& file, const char* key, double otherwise) {
    if (frame.has(key)) return frame.number(key);
    return file.number(key, otherwise);
}

Result<fs::path> imageOf(const fs::path& root, const std::string& relative, const std::string& where) {
    std::error_code ignored;
    if (const std::string read = convertedName(root, relative); read != relative) return fileInside(root, read, where);
    if (fs::path(relative).has_extension() && fs::exists(root / relative, ignored)) return fileInside(root, relative, where);
    for (const char* extension : {".jpg", ".jpeg", ".png"})  // Blender's files omit the extension, and a name may have a point
        if (fs::exists(root / (relative + extension), ignored)) return fileInside(root, relative + extension, where);
    return fileInside(root, relative, where);
}

/** Refuses lenses that are not Brown's, as the file or one of its frames states them: nerfstudio by camera_model, instant-ngp by keys of
 *  its own. */
Status checkLensModel(const JsonFields& fields) {
    const auto unread = [&](const std::string& what) {
        return fail(Code::Unsupported, "{}: {} is not read; undistort the images first, for example with 'colmap image_undistorter'",
                    fields.where(), what);
    };
    DPL_TRY(const std::string model, fields.text("camera_model", "OPENCV"));
    if (model != "PINHOLE" && model != "SIMPLE_PINHOLE" && model != "OPENCV" && model != "SIMPLE_RADIAL" && model != "RADIAL")
        return unread(formatText("camera_model '{}'", model.substr(0, 60)));
    for (const char* key : {"is_fisheye", "latlong", "equirectangular", "ftheta_p0", "ftheta_p1"})
        if (fields.states(key)) return unread(formatText("the lens that '{}' states, which is no OPENCV lens,", key));
    return {};
}

/** Focal lengths in pixels that a frame or a file states, or from angles across the picture. 0: not stated. */
struct Focal {
    double x = 0, y = 0;
};
Result<Focal> focalOf(const JsonFields& fields, double width, double height) {
    Focal focal;
    const auto fromAngle = [](double angleRad, double side) { return angleRad > 0 ? 0.5 * side / std::tan(0.5 * angleRad) : 0; };
    DPL_TRY(const double angleX, fields.number("camera_angle_x", 0));
    DPL_TRY(const double angleY, fields.number("camera_angle_y", 0));
    DPL_TRY(focal.x, fields.number("fl_x", fromAngle(angleX, width)));
    DPL_TRY(focal.y, fields.number("fl_y", fields.has("fl_x") ? 0 : fromAngle(angleY, height)));
    return focal;
}

/** The focal lengths of a frame: its own before the file's, and square pixels unless something else is stated. */
Status readFocal(const JsonFields& frame, const JsonFields& file, Camerad& camera) {
    DPL_TRY(const Focal own, focalOf(frame, camera.widthPx, camera.heightPx));
    DPL_TRY(const Focal shared, focalOf(file, camera.widthPx, camera.heightPx));
    const bool angleOfItsOwn = own.x != 0 && !frame.has("fl_x");
    camera.fx = own.x != 0 ? own.x : shared.x;  // 0 is refused by checkCamera, which names fx
    camera.fy = own.y != 0 ? own.y : shared.y != 0 && !angleOfItsOwn ? shared.y : camera.fx;
    return {};
}

Status readIntrinsics(const JsonFields& frame, const JsonFields& file, const ImageHeader& header, Camerad& camera, LensDistortion& lens) {
    DPL_TRY(const double width, eitherNumber(frame, file, "w", header.widthPx));
    DPL_TRY(const double height, eitherNumber(frame, file, "h", header.heightPx));
    if (!(width >= 1 && height >= 1 && width <= 65536 && height <= 65536))
        return fail(Code::CorruptData, "{}: w, h = {}, {} is not a size in pixels; correct it", frame.where(), width, height);
    camera.widthPx = uint32_t(width), camera.heightPx = uint32_t(height);
    DPL_RETURN_IF_ERROR(readFocal(frame, file, camera));
    DPL_TRY(camera.cx, eitherNumber(frame, file, "cx", 0.5 * width));
    DPL_TRY(camera.cy, eitherNumber(frame, file, "cy", 0.5 * height));
    DPL_TRY(lens.k1, eitherNumber(frame, file, "k1", 0));
    DPL_TRY(lens.k2, eitherNumber(frame, file, "k2", 0));
    DPL_TRY(lens.p1, eitherNumber(frame, file, "p1", 0));
    DPL_TRY(lens.p2, eitherNumber(frame, file, "p2", 0));
    DPL_TRY(const double k3, eitherNumber(frame, file, "k3", 0));
    DPL_TRY(const double k4, eitherNumber(frame, file, "k4", 0));
    if (k3 != 0 || k4 != 0)
        return fail(Code::Unsupported,
                    "{}: distortion k3, k4 is not read; undistort the images first, for example with 'colmap image_undistorter'",
                    frame.where());
    return {};
}

Status readPose(const json& entry, const std::string& where, Camerad& camera) {
    std::array<double, 16> m{};
    const auto found = entry.find("transform_matrix");
    bool good = found != entry.end() && found->is_array() && (found->size() == 4 || found->size() == 3);
    for (size_t row = 0; good && row < found->size(); ++row) {
        const json& numbers = (*found)[row];
        good = numbers.is_array() && numbers.size() == 4;
        for (size_t column = 0; good && column < 4; ++column) {
            good = numbers[column].is_number();
            if (good) m[row * 4 + column] = numbers[column].get<double>();
        }
    }
    if (!good) return fail(Code::CorruptData, "{}: 'transform_matrix' must be 4 rows of 4 numbers; register the frame or remove it", where);
    setOpenglPose(camera, m);
    return {};
}

/** file_path -> split, from the three lists; empty when the file has no lists. Validation images count as test.
 */
Result<std::map<std::string, Split>> readSplits(const JsonFields& fields) {
    std::map<std::string, Split> splits;
    for (const auto& [key, split] :
         {std::pair{"train_filenames", Split::Train}, {"val_filenames", Split::Test}, {"test_filenames", Split::Test}}) {
        if (!fields.has(key)) continue;
        DPL_TRY(const json* list, fields.array(key));
        for (const json& name : *list) {
            if (!name.is_string()) return fail(Code::CorruptData, "{}: '{}' must be a list of file paths; correct it", fields.where(), key);
            const auto [at, fresh] = splits.emplace(withSlashes(name.get<std::string>()), split);
            if (!fresh && at->second != split && at->second == Split::Train)
                return fail(Code::CorruptData, "{}: '{}' is both in a train and a test list; keep it in one", fields.where(),
                            at->first.substr(0, 200));
        }
    }
    return splits;
}

/** What is known of the world. */
struct NerfWorld {
    bool zUp = false, metric = false, unitStated = true;
    std::string assumed;
};

Result<NerfWorld> readWorld(const JsonFields& fields, char upIfUnstated) {
    const bool upStated = fields.has("world_up"), metricStated = fields.has("metric");
    DPL_TRY(const std::string up, fields.text("world_up", std::string(1, upIfUnstated)));
    if (up != "y" && up != "z")
        return fail(Code::Unsupported, "{}: world_up '{}' is neither y nor z; turn the world", fields.where(), up.substr(0, 60));
    // NeRFCapture (Manifest.swift) alone has this key; instant-ngp's is integer_depth_scale. It writes ARKit's poses: metres, y up.
    const bool nerfCapture = !upStated && fields.has("depth_integer_scale");
    NerfWorld world;
    world.zUp = up == "z" && !nerfCapture;
    DPL_TRY(world.metric, fields.boolean("metric", nerfCapture));
    if (world.metric && !upStated && !nerfCapture)
        return fail(Code::CorruptData, "{}: 'metric' is true, but the file does not say which way is up; add \"world_up\": \"y\" or \"z\"",
                    fields.where());
    // Programs that scaled the world say by what, so it is not in metres.
    world.unitStated = metricStated || nerfCapture || fields.has("applied_transform") || fields.has("applied_scale");
    if (nerfCapture && !metricStated)
        world.assumed = formatText("{} was written by NeRFCapture, so its world is in metres and y is up", fields.where());
    else if (!metricStated)
        world.assumed = formatText(
            "{} does not say that its world is in metres: the body fit finds up and scale{}. If it is in metres, add \"metric\": true and "
            "\"world_up\": \"y\" or \"z\"; if not, --height sets the scale",
            fields.where(), world.unitStated ? "" : ", and takes it for metres if the person in it is then of a human size");
    return world;
}

/** Paths of a frame's picture and mask, and the picture's size. NotFound, CorruptData, Unsupported: one of them cannot be read, so that the
 *  frame is left out. InvalidArgument: a path that is not allowed. */
Result<ImageHeader> readFiles(const JsonFields& fields, const std::string& relative, const NerfstudioFiles& files, ScanFrame& frame) {
    const auto allowed = [](Result<fs::path> path) -> Result<fs::path> {
        if (path || path.error().code != Code::CorruptData) return path;
        return Error{Code::InvalidArgument, path.error().message};
    };
    DPL_TRY(frame.imagePath, allowed(files.picture(relative, fields.where() + ": 'file_path'")));
    if (fields.has("mask_path")) {
        const auto mask = fields.text("mask_path");
        if (!mask) return Error{Code::InvalidArgument, mask.error().message};
        DPL_TRY(frame.maskPath, allowed(files.mask(withSlashes(*mask), fields.where() + ": 'mask_path'")));
    }
    DPL_TRY(const ImageHeader header, files.header(frame.imagePath));
    if (frame.maskPath.empty()) return header;
    DPL_TRY(const ImageHeader mask, files.header(frame.maskPath));
    DPL_RETURN_IF_ERROR(checkMaskSize(mask, header, frame.maskPath));
    return header;
}

/** The camera of a frame, for its picture of the size in `header`. Whether it was scaled to fit. */
Result<bool> readCamera(const JsonFields& fields, const json& entry, const JsonFields& file, const ImageHeader& header, bool zUp,
                        ScanFrame& frame) {
    DPL_RETURN_IF_ERROR(checkLensModel(fields));
    DPL_RETURN_IF_ERROR(readIntrinsics(fields, file, header, frame.camera, frame.lens));
    DPL_RETURN_IF_ERROR(readPose(entry, fields.where(), frame.camera));
    if (zUp) turnZUpWorld(frame.camera);
    const std::string named = formatText("{} ('{}')", fields.where(), frame.name);
    DPL_RETURN_IF_ERROR(checkCamera(frame.camera, named));
    DPL_RETURN_IF_ERROR(checkDistortion(frame.lens, frame.camera, named));
    return fitToPicture(frame.camera, header, frame.imagePath, named);
}

FrameKind kindFromName(const std::string& name) {
    if (name.starts_with("close")) return FrameKind::StaticCloseup;
    if (name.starts_with("dyn")) return FrameKind::Dynamic;
    return FrameKind::StaticFull;
}

}  // namespace

Result<Scan> parseNerfstudio(const json& manifest, const fs::path& manifestPath, const NerfstudioFiles& files, char up) {
    const std::string file = manifestPath.string();
    JsonFields fields(manifest, file);
    DPL_RETURN_IF_ERROR(checkLensModel(fields));
    DPL_TRY(NerfWorld world, readWorld(fields, up));
    Scan scan;
    scan.source = ScanSource::Nerfstudio;
    scan.root = manifestPath.parent_path();
    scan.name = scan.root.filename().string();
    scan.metricWorld = world.metric;
    scan.unitStated = world.unitStated;
    scan.assumed = std::move(world.assumed);
    DPL_TRY(auto splits, readSplits(fields));
    scan.splitStated = !splits.empty();
    DPL_TRY(const json* frames, fields.array("frames"));
    if (frames->size() > kMaxFrames)
        return fail(Code::Unsupported, "{}: {} frames, at most {} are read; remove some frames from the scan", file, frames->size(),
                    kMaxFrames);
    size_t scaled = 0;
    LeftOut left;
    for (size_t i = 0; i < frames->size(); ++i) {
        const json& entry = (*frames)[i];
        const std::string where = formatText("{} frame {}", file, i);
        if (!entry.is_object()) return fail(Code::CorruptData, "{} is not an object; correct it", where);
        JsonFields fieldsHere(entry, where);
        ScanFrame frame;
        DPL_TRY(const std::string stated, fieldsHere.text("file_path"));
        const std::string relative = withSlashes(stated);
        frame.name = nameFromPath(relative);
        frame.kind = kindFromName(frame.name);
        if (scan.splitStated) {
            const auto found = splits.find(relative);
            if (found == splits.end())
                return fail(Code::CorruptData, "{}: '{}' is in none of train_filenames, val_filenames, test_filenames; add it to one",
                            where, relative.substr(0, 200));
            frame.split = found->second;
        }
        const auto header = readFiles(fieldsHere, relative, files, frame);
        if (!header) {
            if (header.error().code == Code::InvalidArgument) return header.error();
            left.add(relative, header.error());
            continue;
        }
        const auto fitted = readCamera(fieldsHere, entry, fields, *header, world.zUp, frame);
        if (!fitted) {
            left.add(relative, fitted.error());
            continue;
        }
        scaled += *fitted;
        scan.frames.push_back(std::move(frame));
    }
    if (files.decode) DPL_RETURN_IF_ERROR(leaveOutDamaged(scan, scan.root, left));
    DPL_RETURN_IF_ERROR(left.check(scan.frames.size()));
    addAssumption(scan, left.sentence(frames->size()));
    noteScaledCameras(scan, scaled);
    numberEqualNames(scan.frames);
    return scan;
}

Result<Scan> readNerfstudio(const fs::path& manifestPath, char up) {
    DPL_TRY(const json manifest, readJsonObject(manifestPath));
    const fs::path root = manifestPath.parent_path();
    NerfstudioFiles files;
    files.picture = [&](const std::string& relative, const std::string& where) { return imageOf(root, relative, where); };
    files.mask = [&](const std::string& relative, const std::string& where) { return fileInside(root, relative, where); };
    files.header = probeCompleteImage;
    DPL_TRY(Scan scan, parseNerfstudio(manifest, manifestPath, files, up));
    DPL_RETURN_IF_ERROR(finishScan(scan));
    return scan;
}

}  // namespace dpl
