// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/import/folder_contents.h"

#include <algorithm>
#include <cctype>
#include <functional>

#include "reconstruction/base/program.h"
#include "sdk/core/result.h"

namespace dpl {

namespace fs = std::filesystem;

namespace {

constexpr size_t kMaxListed = 100000;
constexpr size_t kMaxFolders = 1000;

bool endsIn(const fs::path& file, std::initializer_list<const char*> extensions) {
    const std::string extension = lowerExtension(file);
    return std::any_of(extensions.begin(), extensions.end(), [&](const char* e) { return extension == e; });
}

void sortNaturally(std::vector<fs::path>& paths) {
    std::sort(paths.begin(), paths.end(),
              [](const fs::path& a, const fs::path& b) { return naturallyBefore(a.filename().string(), b.filename().string()); });
}

/** Visible entries of a folder that `wanted` takes, in natural order. */
std::vector<fs::path> entriesOf(const fs::path& folder, size_t most, const std::function<bool(const fs::directory_entry&)>& wanted) {
    std::vector<fs::path> paths;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end && paths.size() < most; at.increment(error))
        if (at->path().filename().string().front() != '.' && wanted(*at)) paths.push_back(at->path());
    sortNaturally(paths);
    return paths;
}

std::vector<fs::path> filesThat(const fs::path& folder, const std::function<bool(const fs::path&)>& wanted) {
    return entriesOf(folder, kMaxListed, [&](const fs::directory_entry& entry) {
        std::error_code ignored;
        return wanted(entry.path()) && entry.is_regular_file(ignored);
    });
}

/** Files that `wanted` takes and that do not lie there as a picture that is read too: IMG_1.HEIC as IMG_1.jpg or as IMG_1.HEIC.jpg. */
std::vector<fs::path> unreadIn(const fs::path& folder, const std::function<bool(const fs::path&)>& wanted) {
    std::vector<std::string> read;
    for (const fs::path& picture : picturesIn(folder)) read.push_back(picture.stem().string());
    std::sort(read.begin(), read.end());
    return filesThat(folder, [&](const fs::path& path) {
        return wanted(path) && !std::binary_search(read.begin(), read.end(), path.stem().string()) &&
               !std::binary_search(read.begin(), read.end(), path.filename().string());
    });
}

}  // namespace

bool naturallyBefore(std::string_view a, std::string_view b) {
    const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
    size_t i = 0, j = 0;
    while (i < a.size() && j < b.size()) {
        if (isDigit(a[i]) && isDigit(b[j])) {
            while (i < a.size() && a[i] == '0') ++i;
            while (j < b.size() && b[j] == '0') ++j;
            size_t endA = i, endB = j;
            while (endA < a.size() && isDigit(a[endA])) ++endA;
            while (endB < b.size() && isDigit(b[endB])) ++endB;
            if (endA - i != endB - j) return endA - i < endB - j;
            if (const int order = a.substr(i, endA - i).compare(b.substr(j, endB - j)); order != 0) return order < 0;
            i = endA, j = endB;
            continue;
        }
        if (a[i] != b[j]) return a[i] < b[j];
        ++i, ++j;
    }
    if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
    return a < b;  // "01" and "1"
}

std::string lowerCase(std::string text) {
    for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

std::string lowerExtension(const fs::path& file) {
    return lowerCase(file.extension().string());
}

std::vector<fs::path> filesWith(const fs::path& folder, std::initializer_list<const char*> extensions) {
    return filesThat(folder, [&](const fs::path& path) { return endsIn(path, extensions); });
}

bool isPicture(const fs::path& file) {
    return endsIn(file, {".jpg", ".jpeg", ".png"});
}

bool isVideo(const fs::path& file) {
    const std::string extension = lowerExtension(file);
    return std::any_of(std::begin(kVideoEndings), std::end(kVideoEndings), [&](const VideoEnding& e) { return extension == e.extension; });
}

bool isHeic(const fs::path& file) {
    return endsIn(file, {".heic", ".heif"});
}

std::vector<fs::path> picturesIn(const fs::path& folder) {
    return filesThat(folder, isPicture);
}

std::vector<fs::path> videosIn(const fs::path& folder) {
    return filesThat(folder, isVideo);
}

std::vector<fs::path> heicIn(const fs::path& folder) {
    return unreadIn(folder, isHeic);
}

std::vector<fs::path> otherPicturesIn(const fs::path& folder) {
    return unreadIn(folder, [](const fs::path& path) { return endsIn(path, {".avif", ".bmp", ".dng", ".tif", ".tiff", ".webp"}); });
}

std::vector<fs::path> foldersIn(const fs::path& folder) {
    return entriesOf(folder, kMaxFolders, [](const fs::directory_entry& entry) {
        std::error_code ignored;
        return entry.is_directory(ignored);
    });
}

std::string howToConvertHeic(const fs::path& folder) {
    return formatText(
        "export them as JPEG (on an iPhone: Settings, Camera, Formats, Most Compatible), or convert them (apt-get install "
        "libheif-examples) and run the same command again: for f in {}/*.[Hh][Ee][Ii][CcFf]; do heif-convert -q 95 \"$f\" "
        "\"$f.jpg\"; done",
        shellWord(folder));
}

std::string namesOf(const std::vector<fs::path>& files) {
    constexpr size_t kMostNamed = 8;
    std::string text;
    for (size_t i = 0; i < std::min(files.size(), kMostNamed); ++i) text += (i > 0 ? ", " : "") + files[i].filename().string();
    return files.size() > kMostNamed ? text + ", ..." : text;
}

std::vector<std::string> leftBesidePhotos(const fs::path& folder) {
    std::vector<std::string> notes;
    if (const auto heic = heicIn(folder); !heic.empty())
        notes.push_back(formatText("{} HEIC photos are left out, because they are not read ({}); {}", heic.size(), namesOf(heic),
                                   howToConvertHeic(folder)));
    if (const auto others = otherPicturesIn(folder); !others.empty())
        notes.push_back(formatText("{} pictures are left out, because only JPEG and PNG are read ({}); convert them to JPEG", others.size(),
                                   namesOf(others)));
    if (const auto videos = videosIn(folder); !videos.empty())
        notes.push_back(
            formatText("the photos are taken, {} videos beside them are left out; for a scan of a video instead: doppel import {} -o scan",
                       videos.size(), shellWord(videos.front())));
    for (const fs::path& below : foldersIn(folder))
        if (const size_t pictures = picturesIn(below).size(); pictures > 0)
            notes.push_back(formatText("{} pictures in its folder {} are left out; move them beside the others if they belong to the scan",
                                       pictures, below.filename().string()));
    return notes;
}

}  // namespace dpl
