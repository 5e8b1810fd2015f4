// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/colmap_run.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>

#include "reconstruction/base/program.h"
#include "sdk/core/files.h"
#include "sdk/core/task.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr size_t kPairsPerCall = 60;  // COLMAP says nothing while it matches, so it is called for some pairs at a time
// More and finer features take longer to match than they gain: matching takes the square of their number.
constexpr int kMaxFeatures = 2048, kMaxSidePx = 1600;
// Shares of the time, measured on 78 pictures of 378 × 504 px on two cores.
constexpr double kExtractShare = 0.19, kMatchShare = 0.72;

std::string decimal(double value) {
    char text[64];
    std::snprintf(text, sizeof text, "%.6f", value);
    return text;
}

/** The numbers of "... [12/78]" or "... #42 (17)": the last number before the closing bracket's slash, or in parentheses. */
std::optional<unsigned> numberAfter(std::string_view line, std::string_view mark) {
    const size_t at = line.find(mark);
    if (at == std::string_view::npos) return std::nullopt;
    unsigned value = 0;
    const char* begin = line.data() + at + mark.size();
    const auto [end, error] = std::from_chars(begin, line.data() + line.size(), value);
    return error == std::errc() ? std::optional(value) : std::nullopt;
}

class Colmap {
public:
    explicit Colmap(const ColmapRun& run) : run_(run), database_((run.folder / "database.db").string()) {}

    Result<std::vector<ColmapImage>> run() {
        const fs::path model = run_.folder / "sparse";
        std::error_code error;
        for (const fs::path& old : {model, fs::path(database_), run_.folder / "colmap.log"}) fs::remove_all(old, error);
        fs::create_directories(model, error);
        if (error) return fail(Code::Io, "cannot create {}: {}", model.string(), error.message());
        DPL_RETURN_IF_ERROR(extract());
        DPL_RETURN_IF_ERROR(match());
        DPL_RETURN_IF_ERROR(map(model));
        return largest(model);
    }

private:
    const ColmapRun& run_;
    std::string database_;

    Status call(std::vector<std::string> arguments, const std::function<void(std::string_view)>& line) const {
        arguments.insert(arguments.begin(), kColmapProgram);
        // Without a screen Qt, which COLMAP links, would end the program.
        const Status ended = runProgram({arguments, {"QT_QPA_PLATFORM=offscreen"}, run_.folder / "colmap.log", line});
        if (!ended && ended.error().code == Code::NotFound)
            return fail(Code::NotFound,
                        "the pictures have no cameras, and COLMAP, which finds them, is not installed: {}; or give a scan with cameras",
                        kHowToGetColmap);
        return ended;
    }

    Status extract() const {
        const std::string lens = decimal(run_.focalPx) + "," + decimal(run_.widthPx / 2.0) + "," + decimal(run_.heightPx / 2.0) + ",0";
        std::vector<std::string> arguments = {"feature_extractor",
                                              "--database_path",
                                              database_,
                                              "--image_path",
                                              (run_.folder / "images").string(),
                                              "--ImageReader.single_camera",
                                              "1",
                                              "--ImageReader.camera_model",
                                              "SIMPLE_RADIAL",
                                              "--ImageReader.camera_params",
                                              lens,
                                              "--SiftExtraction.use_gpu",
                                              "0",
                                              "--SiftExtraction.num_threads",
                                              std::to_string(run_.threads),
                                              "--SiftExtraction.max_image_size",
                                              std::to_string(kMaxSidePx),
                                              "--SiftExtraction.max_num_features",
                                              std::to_string(kMaxFeatures)};
        std::error_code ignored;
        if (fs::is_directory(run_.folder / "masks", ignored))
            arguments.insert(arguments.end(), {"--ImageReader.mask_path", (run_.folder / "masks").string()});
        return call(arguments, [&](std::string_view line) {
            if (const auto done = numberAfter(line, "Processed file ["))
                (void)taskAt(kExtractShare * *done / double(run_.images.size()),
                             formatText("features, picture {} of {}", *done, run_.images.size()));
        });
    }

    Status match() const {
        const fs::path list = run_.folder / "pairs.txt";
        for (size_t begin = 0; begin < run_.pairs.size(); begin += kPairsPerCall) {
            const size_t end = std::min(run_.pairs.size(), begin + kPairsPerCall);
            std::string text;
            for (size_t i = begin; i < end; ++i) text += run_.images[run_.pairs[i].first] + " " + run_.images[run_.pairs[i].second] + "\n";
            DPL_RETURN_IF_ERROR(writeFileAtomically(list, text));
            DPL_RETURN_IF_ERROR(call({"matches_importer", "--database_path", database_, "--match_list_path", list.string(),
                                      "--SiftMatching.use_gpu", "0", "--SiftMatching.num_threads", std::to_string(run_.threads)},
                                     {}));
            (void)taskAt(kExtractShare + kMatchShare * double(end) / double(run_.pairs.size()),
                         formatText("matches, pair {} of {}", end, run_.pairs.size()));
        }
        return {};
    }

    Status map(const fs::path& model) const {
        const Status ended = call(
            {"mapper", "--database_path", database_, "--image_path", (run_.folder / "images").string(), "--output_path", model.string(),
             "--Mapper.num_threads", std::to_string(run_.threads)},
            [&](std::string_view line) {
                if (const auto done = numberAfter(line.substr(std::min(line.size(), line.find('('))), "("))
                    (void)taskAt(
                        std::min(1.0, kExtractShare + kMatchShare + (1 - kExtractShare - kMatchShare) * *done / double(run_.images.size())),
                        formatText("cameras, {} of {} found", *done, run_.images.size()));
            });
        // The mapper of newer versions fails when it finds no model, which is an answer.
        return ended || ended.error().code != Code::Io ? ended : Status();
    }

    static Result<std::vector<ColmapImage>> largest(const fs::path& model) {
        std::vector<ColmapImage> best;
        std::error_code error;
        std::vector<fs::path> folders;
        for (const auto& entry : fs::directory_iterator(model, error)) folders.push_back(entry.path());
        std::sort(folders.begin(), folders.end());
        for (const fs::path& folder : folders) {
            std::vector<UnreadColmapImage> unread;  // a picture that COLMAP puts nowhere is one that it did not place
            DPL_TRY(auto images, readColmapModel(folder, &unread));
            if (images.size() > best.size()) best = std::move(images);
        }
        return best;
    }
};

}  // namespace

Result<std::vector<ColmapImage>> runColmap(const ColmapRun& run) {
    return Colmap(run).run();
}

}  // namespace dpl
