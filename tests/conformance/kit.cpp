// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/kit.h"

#include <cmath>
#include <doppel/doppel.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "reconstruction/report/sdk_camera.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr int kVersion = 1;
constexpr uint64_t kMaxJsonBytes = 1 << 22, kMaxPictureBytes = 1 << 26;
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

Cameraf cameraFrom(const nlohmann::json& j) {
    Cameraf c;
    c.widthPx = j.at("width_px"), c.heightPx = j.at("height_px");
    c.fx = j.at("fx"), c.fy = j.at("fy"), c.cx = j.at("cx"), c.cy = j.at("cy");
    const auto& m = j.at("view_from_world");
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) c.viewFromWorldRotation[column][row] = m.at(size_t(row * 4 + column));
        c.viewFromWorldTranslation[row] = m.at(size_t(row * 4 + 3));
    }
    return c;
}

std::vector<float> rotationsOf(const Pose& pose) {
    std::vector<float> out;
    for (const Quatf& q : pose.localRotations) out.insert(out.end(), {q.x, q.y, q.z, q.w});
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
        {"version", kVersion},
        {"pictures",
         "One PNG per view, named by `picture`: premultiplied RGBA, 8 or 16 bits, display-referred numbers as the avatar has them, no "
         "background, top row first."},
        {"conventions",
         "Cameras: X_view = R X_world + t, rows [R0 R1 R2 t]; x right, y down, z forward; pixel (0,0) has its centre at (0.5, 0.5). "
         "Rotations: local, x y z w, identity is the rest pose; docs/formats/avatar.md has the rest."},
        {"cases", nlohmann::ordered_json::array()}};
    for (const ConformanceCase& c : conformanceCases()) {
        DPL_TRY(const auto bytes, writeAvatar(c.avatar));
        DPL_CHECK_OK(writeFileAtomically(folder / (c.name + ".glb"), bytes));
        DPL_TRY(const ReferenceFile file, ReferenceFile::read(bytes));
        const std::vector<float> rotations = rotationsOf(c.pose);
        nlohmann::ordered_json views = nlohmann::ordered_json::array();
        for (size_t v = 0; v < c.views.size(); ++v) {
            const std::string picture = c.name + (c.views.size() == 1 ? "" : v == 0 ? ".left" : ".right") + ".png";
            const ReferencePicture reference = file.draw(rotations, c.pose.rootTranslation, c.views[v]);
            DPL_CHECK_OK(writePng(folder / "reference" / picture, pictureOf(reference)));
            nlohmann::ordered_json view = {{"picture", picture}};
            view.update(cameraJson(c.views[v]));
            views.push_back(std::move(view));
        }
        const Vec3f& root = c.pose.rootTranslation;
        json["cases"].push_back(
            {{"name", c.name},
             {"about", c.about},
             {"avatar", c.name + ".glb"},
             {"rotations", rotations},
             {"root_translation", {root.x, root.y, root.z}},
             {"views", std::move(views)},
             {"may_be_blank", c.mayBeBlank},
             {"band", {{"psnr_db", c.band.psnrDb}, {"covered_psnr_db", c.band.coveredPsnrDb}, {"max_levels", c.band.maxLevels}}}});
    }
    return writeFileAtomically(folder / "kit.json", json.dump(1) + "\n");
}

Result<std::vector<KitCase>> readKit(const fs::path& folder) {
    const fs::path path = folder / "kit.json";
    DPL_TRY(const auto bytes, readFile(path, kMaxJsonBytes));
    std::vector<KitCase> cases;
    try {
        const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
        if (json.at("format") != "doppel-conformance" || json.at("version") != kVersion)
            return fail(Code::Version, "{} is not a conformance kit of version {}; write it again with `tools/conformance write`",
                        path.string(), kVersion);
        for (const auto& c : json.at("cases")) {
            KitCase k{c.at("name"), c.at("about"), c.at("avatar"), c.at("rotations"), Vec3f(0), {}, c.at("may_be_blank"), {}};
            for (int a = 0; a < 3; ++a) k.rootTranslation[a] = c.at("root_translation").at(size_t(a));
            for (const auto& v : c.at("views")) k.views.push_back({v.at("picture"), cameraFrom(v)});
            k.band = {c.at("band").at("psnr_db"), c.at("band").at("covered_psnr_db"), c.at("band").at("max_levels")};
            cases.push_back(std::move(k));
        }
    } catch (const nlohmann::json::exception& error) {
        return fail(Code::CorruptData, "{}: {}", path.string(), error.what());
    }
    if (cases.empty()) return fail(Code::CorruptData, "{} has no cases", path.string());
    return cases;
}

Result<std::string> drawKit(const fs::path& kit, const fs::path& pictures, DplRenderer renderer, DplFill fill) {
    const auto sdk = [](const doppel::Error& error) {
        return fail(error.code == DPL_ERROR_UNSUPPORTED ? Code::Unsupported : Code::Internal, "{}", error.message);
    };
    DPL_TRY(const auto cases, readKit(kit));
    auto context = doppel::Context::create(renderer, 0, 0, fill);
    if (!context) return sdk(context.error());
    std::error_code ignored;
    fs::create_directories(pictures, ignored);
    for (const KitCase& c : cases) {
        DPL_TRY(const auto bytes, readFile(kit / c.avatarFile, kMaxPictureBytes));
        auto avatar = context->loadAvatar(bytes);
        if (!avatar) return sdk(avatar.error());
        if (auto set = avatar->setPose(c.rotations, {&c.rootTranslation.x, 3}); !set) return sdk(set.error());
        std::vector<DplCamera> cameras;
        std::vector<DplImage> images;
        std::vector<std::vector<uint8_t>> pixels;
        for (const KitView& view : c.views) {
            cameras.push_back(sdkCamera(view.camera));
            pixels.emplace_back(size_t(view.camera.widthPx) * view.camera.heightPx * 4);
            images.push_back({.structSize = sizeof(DplImage),
                              .flags = 0,
                              .rgba = pixels.back().data(),
                              .rgbaBytes = pixels.back().size(),
                              .rowBytes = 0,
                              .depthM = nullptr,
                              .depthCount = 0});
        }
        if (auto drawn = avatar->render(cameras, images); !drawn) return sdk(drawn.error());
        for (size_t v = 0; v < c.views.size(); ++v) {
            cv::Mat bgra;
            cv::cvtColor(cv::Mat(int(cameras[v].heightPx), int(cameras[v].widthPx), CV_8UC4, pixels[v].data()), bgra, cv::COLOR_RGBA2BGRA);
            DPL_CHECK_OK(writePng(pictures / c.views[v].picture, bgra));
        }
    }
    return context->rendererName();
}

Result<std::vector<CaseScore>> scoreKit(const fs::path& kit, const fs::path& pictures, const fs::path& sheet) {
    DPL_TRY(const auto cases, readKit(kit));
    std::vector<CaseScore> scores;
    std::vector<cv::Mat> rows;
    for (const KitCase& c : cases) {
        CaseScore score{c.name, false, {}, {}, 0};
        for (const KitView& view : c.views) {
            DPL_TRY(const cv::Mat want, readPng(kit / "reference" / view.picture));
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
            if (e.psnrDb() < c.band.psnrDb)
                score.trouble = formatText("{} dB, at least {} required", decibels(e.psnrDb()), c.band.psnrDb);
            else if (e.coveredPsnrDb() < c.band.coveredPsnrDb)
                score.trouble =
                    formatText("{} dB on covered pixels, at least {} required", decibels(e.coveredPsnrDb()), c.band.coveredPsnrDb);
            else if (e.maxLevels > c.band.maxLevels)
                score.trouble = formatText("largest error of a channel is {} levels, at most {} allowed", std::round(e.maxLevels * 10) / 10,
                                           c.band.maxLevels);
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
        DPL_CHECK_OK(writePng(sheet, all));
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
