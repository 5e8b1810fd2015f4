// SPDX-License-Identifier: Apache-2.0
// The readers of the kinds of scan folder, and what they share. Private to reconstruction/input.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "reconstruction/base/image_file.h"
#include "reconstruction/base/json_fields.h"
#include "reconstruction/input/capture/scan.h"

namespace dpl {

constexpr size_t kMaxFrames = 20000;

/** Checks that there are 1 … kMaxFrames frames with unique, safe names and images of the camera's size. Chooses test frames when the source
 *  states no split. */
Status finishScan(Scan& scan);

Result<Scan> readScanFolder(const std::filesystem::path& manifest);
/** `up`: 'y' or 'z', of a file that does not state it. */
Result<Scan> readNerfstudio(const std::filesystem::path& manifest, char up = 'y');
/** How parseNerfstudio looks at files: the checked path of a name in the manifest, and the size of a picture. */
struct NerfstudioFiles {
    std::function<Result<std::filesystem::path>(const std::string&relative, const std::string&where)> picture, mask;
    std::function<Result<ImageHeader>(const std::filesystem::path&)> header;
    bool decode = true;  // whether pictures are decoded to find damage
};
/** Frames and cameras of a manifest, before finishScan(). */
Result<Scan> parseNerfstudio(const nlohmann::json& manifest, const std::filesystem::path& path, const NerfstudioFiles& files,
                             char up = 'y');
class LeftOut;

/** Where a COLMAP model and its pictures lie. */
struct ColmapProject {
    std::filesystem::path root;   // of masks; images or input lies in it, or it holds the pictures itself
    std::filesystem::path model;  // folder of cameras and images
    std::string note;             // which models were left and how to take them; empty: there is no other
};
/** The project at `folder`: a project's folder, its sparse, one of its models, or COLMAP's dense folder or one that holds it. A model that
 *  is named is taken; else the one with the most images. Nothing when there is no model. */
std::optional<ColmapProject> findColmapProject(const std::filesystem::path& folder);
Result<Scan> readColmapScan(const ColmapProject& project);

/** IMG_1.HEIC.jpg if it lies beside the picture IMG_1.HEIC, which is not read; else `relative`. */
std::string convertedName(const std::filesystem::path& root, const std::string& relative);

/** Leaves out frames of which the pixels of the picture or of the mask are damaged: decodes all of them, on all cores. Names are relative
 *  to `pictures`. Cancelled: the task of the thread. */
Status leaveOutDamaged(Scan& scan, const std::filesystem::path& pictures, LeftOut& left);

/** Makes the names of frames unique: the second "a" becomes "a_2". */
void numberEqualNames(std::vector<ScanFrame>& frames);

/** Pictures that are left out because they cannot be read, so that one of them does not sink the rest. */
class LeftOut {
public:
    void add(const std::filesystem::path& picture, const Error& why);
    bool empty() const { return names_.empty(); }
    /** "2 of 9 pictures are left out: a.jpg, b.jpg (why the first)". Empty when none is. */
    std::string sentence(size_t all, const char* what = "pictures") const;
    /** The first picture's error when nothing was kept. */
    Status check(size_t kept) const;

private:
    std::vector<std::string> names_;
    std::optional<Error> first_;
};

}  // namespace dpl
