// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/kit.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "reconstruction/base/sdk_camera.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxPictureBytes = 1 << 26;
constexpr double kDifferenceGain = 8;
constexpr int kSheetScale = 2, kSheetGapPx = 8;

Status writePng(const fs::path& path, const cv::Mat& picture) {
    std::vector<uint8_t> bytes;
    if (!cv::imencode(".png", picture, bytes)) return fail(Code::Internal, "{}: the picture cannot be encoded", path.string());
    return writeFileAtomically(path, bytes);
}

/** Reads a PNG of 8 or 16 bits as RGBA of 16 bits. */
Result<cv::Mat> readPng(const fs::path& path) {
    DPL_TRY(const auto bytes, readFile(path, kMaxPictureBytes));
    cv::Mat picture;
    try {
        picture = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {
        picture.release();
    }
    if (picture.empty()) return fail(Code::CorruptData, "{} is not a readable PNG", path.string());
    if (picture.channels() != 4)
        return fail(Code::CorruptData, "{} has {} channels; it must be premultiplied RGBA", path.string(), picture.channels());
    if (picture.depth() != CV_8U && picture.depth() != CV_16U)
        return fail(Code::CorruptData, "{} must have 8 or 16 bits per channel", path.string());
    cv::Mat wide, rgba;
    picture.convertTo(wide, CV_16U, picture.depth() == CV_8U ? 257 : 1);
    cv::cvtColor(wide, rgba, cv::COLOR_BGRA2RGBA);
    return rgba;
}

cv::Mat pictureOf(const ReferencePicture& reference) {
    cv::Mat bgra(int(reference.heightPx), int(reference.widthPx), CV_16UC4);
    for (size_t p = 0; p < reference.alpha.size(); ++p) {
        cv::Vec4w& out = bgra.at<cv::Vec4w>(int(p / reference.widthPx), int(p % reference.widthPx));
        for (int c = 0; c < 3; ++c) out[2 - c] = cv::saturate_cast<uint16_t>(reference.rgb[3 * p + size_t(c)] * 65535);
        out[3] = cv::saturate_cast<uint16_t>(reference.alpha[p] * 65535);
    }
    return bgra;
}

ReferencePicture referenceOf(const cv::Mat& rgba) {
    ReferencePicture out{uint32_t(rgba.cols), uint32_t(rgba.rows), {}, {}};
    for (int y = 0; y < rgba.rows; ++y)
        for (int x = 0; x < rgba.cols; ++x) {
            const cv::Vec4w& p = rgba.at<cv::Vec4w>(y, x);
            for (int c = 0; c < 3; ++c) out.rgb.push_back(p[c] / 65535.0);
            out.alpha.push_back(p[3] / 65535.0);
        }
    return out;
}

nlohmann::ordered_json cameraJson(const Cameraf& camera) {
    const DplCamera c = sdkCamera(camera);
    return {{"width_px", c.widthPx},
            {"height_px", c.heightPx},
            {"fx", c.fx},
            {"fy", c.fy},
            {"cx", c.cx},
            {"cy", c.cy},
            {"view_from_world", std::vector<float>(c.viewFromWorld, c.viewFromWorld + 12)}};
}

std::vector<float> rotationsOf(const Pose& pose) {
    std::vector<float> out;
    for (const Quatf& q : pose.localRotations) out.insert(out.end(), {q.x, q.y, q.z, q.w});
    return out;
}

std::vector<EarlierRotations> earlierOf(const ConformanceCase& c) {
    std::vector<EarlierRotations> out;
    for (size_t i = 0; i < c.earlier.size(); ++i) {
        const int64_t next = i + 1 < c.earlier.size() ? c.earlier[i + 1].timeNs : c.timeNs;
        out.push_back({rotationsOf(c.earlier[i].pose), double(next - c.earlier[i].timeNs) * 1e-9});
    }
    return out;
}

/** Reference, picture and amplified difference side by side, over mid grey and enlarged. A picture of another size is shown black. */
cv::Mat sheetRow(const cv::Mat& reference, const cv::Mat& picture) {
    cv::Mat row(reference.rows * kSheetScale, reference.cols * kSheetScale * 3 + 2 * kSheetGapPx, CV_8UC3, cv::Scalar::all(255));
    for (int y = 0; y < row.rows; ++y)
        for (int panel = 0; panel < 3; ++panel)
            for (int x = 0; x < reference.cols * kSheetScale; ++x) {
                cv::Vec3b& out = row.at<cv::Vec3b>(y, x + panel * (reference.cols * kSheetScale + kSheetGapPx));
                const auto over = [&](const cv::Mat& image, int c) {
                    const cv::Vec4w& p = image.at<cv::Vec4w>(y / kSheetScale, x / kSheetScale);
                    return p[c] / 65535.0 + 0.5 * (1 - p[3] / 65535.0);
                };
                const bool same = picture.size() == reference.size();
                for (int c = 0; c < 3; ++c) {
                    const double want = over(reference, c), is = same ? over(picture, c) : 0;
                    out[2 - c] = cv::saturate_cast<uint8_t>(255 * (panel == 0   ? want
                                                                   : panel == 1 ? is
                                                                                : 0.5 + kDifferenceGain * (is - want)));
                }
            }
    return row;
}

std::string decibels(double db) {
    return std::isfinite(db) ? formatText("{}", std::round(db * 10) / 10) : "equal";
}

}  // namespace

Status writeKit(const fs::path& folder) {
    std::error_code ignored;
    fs::create_directories(folder / "reference", ignored);
    nlohmann::ordered_json json = {
        {"format", "doppel-conformance"},
        {"version", kKitVersion},
        {"pictures",
         "One PNG per view, named by `picture`: premultiplied RGBA, 8 or 16 bits, display-referred numbers as the avatar has them, no "
         "background, top row first."},
        {"conventions",
         "Cameras: X_view = R X_world + t, rows [R0 R1 R2 t]; x right, y down, z forward; pixel (0,0) has its centre at (0.5, 0.5). "
         "Rotations: local, x y z w, identity is the rest pose; docs/formats/avatar.md has the rest. `earlier`: poses that are drawn "
         "first, at "
         "their times, for clothes remember them; the first had been kept for ever. A case without has a pose that knows no time."},
        {"cases", nlohmann::ordered_json::array()}};
    for (const ConformanceCase& c : conformanceCases()) {
        DPL_TRY(const auto bytes, writeAvatar(c.avatar));
        DPL_RETURN_IF_ERROR(writeFileAtomically(folder / (c.name + ".glb"), bytes));
        DPL_TRY(const ReferenceFile file, ReferenceFile::read(bytes));
        const std::vector<float> rotations = rotationsOf(c.pose);
        nlohmann::ordered_json views = nlohmann::ordered_json::array();
        for (size_t v = 0; v < c.views.size(); ++v) {
            const std::string picture = c.name + (c.views.size() == 1 ? "" : v == 0 ? ".left" : ".right") + ".png";
            const ReferencePicture reference = file.draw(rotations, c.pose.rootTranslation, c.views[v], earlierOf(c));
            DPL_RETURN_IF_ERROR(writePng(folder / "reference" / picture, pictureOf(reference)));
            nlohmann::ordered_json view = {{"picture", picture}};
            view.update(cameraJson(c.views[v]));
            views.push_back(std::move(view));
        }
        const Vec3f& root = c.pose.rootTranslation;
        nlohmann::ordered_json written = {
            {"name", c.name},
            {"about", c.about},
            {"avatar", c.name + ".glb"},
            {"rotations", rotations},
            {"root_translation", {root.x, root.y, root.z}},
            {"views", std::move(views)},
            {"may_be_blank", c.mayBeBlank},
            {"band", {{"psnr_db", c.band.psnrDb}, {"covered_psnr_db", c.band.coveredPsnrDb}, {"max_levels", c.band.maxLevels}}}};
        for (const EarlierPose& e : c.earlier) written["earlier"].push_back({{"rotations", rotationsOf(e.pose)}, {"time_ns", e.timeNs}});
        if (!c.earlier.empty()) written["time_ns"] = c.timeNs;
        json["cases"].push_back(std::move(written));
    }
    return writeFileAtomically(folder / "kit.json", json.dump(1) + "\n");
}

Result<std::vector<CaseScore>> scoreKit(const fs::path& kit, const fs::path& pictures, const fs::path& sheet,
                                        const OtherReferences* others) {
    DPL_TRY(const auto cases, readKit(kit));
    const fs::path references = others ? others->folder : kit / "reference";
    std::vector<CaseScore> scores;
    std::vector<cv::Mat> rows;
    for (const KitCase& c : cases) {
        const ToleranceBand& band = others ? others->band : c.band;
        CaseScore score{c.name, false, {}, {}, 0};
        for (const KitView& view : c.views) {
            DPL_TRY(const cv::Mat want, readPng(references / view.picture));
            const ReferencePicture reference = referenceOf(want);
            for (const double a : reference.alpha) score.coverage += (a > 1.0 / 255) / double(reference.alpha.size() * c.views.size());
            auto is = readPng(pictures / view.picture);
            if (!is)
                score.trouble = is.error().message;
            else if (is->size() != want.size())
                score.trouble = formatText("{} is {} x {} px; it must be {} x {} px", (pictures / view.picture).string(), is->cols,
                                           is->rows, want.cols, want.rows);
            else
                score.error += compareWith(reference, {is->ptr<uint16_t>(), size_t(is->total()) * 4});
            if (!sheet.empty()) rows.push_back(sheetRow(want, is ? *is : cv::Mat()));
        }
        if (score.trouble.empty()) {
            const PictureError& e = score.error;
            if (e.psnrDb() < band.psnrDb)
                score.trouble = formatText("{} dB, at least {} required", decibels(e.psnrDb()), band.psnrDb);
            else if (e.coveredPsnrDb() < band.coveredPsnrDb)
                score.trouble =
                    formatText("{} dB on covered pixels, at least {} required", decibels(e.coveredPsnrDb()), band.coveredPsnrDb);
            else if (e.maxLevels > band.maxLevels)
                score.trouble = formatText("largest error of a channel is {} levels, at most {} allowed", std::round(e.maxLevels * 10) / 10,
                                           band.maxLevels);
        }
        score.passed = score.trouble.empty();
        scores.push_back(std::move(score));
    }
    if (!sheet.empty()) {
        int width = 0, height = 0;
        for (const cv::Mat& row : rows) width = std::max(width, row.cols), height += row.rows + kSheetGapPx;
        cv::Mat all(height, width, CV_8UC3, cv::Scalar::all(255));
        int y = 0;
        for (const cv::Mat& row : rows) row.copyTo(all(cv::Rect(0, y, row.cols, row.rows))), y += row.rows + kSheetGapPx;
        DPL_RETURN_IF_ERROR(writePng(sheet, all));
    }
    return scores;
}

std::string scoreTable(const std::vector<CaseScore>& scores) {
    std::string table = "| case | verdict | PSNR dB | covered pixels dB | largest error, levels | covered |\n|---|---|---|---|---|---|\n";
    for (const CaseScore& s : scores)
        table +=
            formatText("| {} | {} | {} | {} | {} | {} % |\n", s.name, s.passed ? "pass" : "FAIL: " + s.trouble, decibels(s.error.psnrDb()),
                       decibels(s.error.coveredPsnrDb()), std::round(s.error.maxLevels * 10) / 10, std::round(s.coverage * 1000) / 10);
    return table;
}

}  // namespace dpl
