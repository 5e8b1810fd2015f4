// SPDX-License-Identifier: Apache-2.0
// What lies in a folder, by the endings of file names, and what an import leaves out of it.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace dpl {

/** The ending of files that are taken for videos, and ffmpeg's name of the format. ffmpeg may read no other format. */
struct VideoEnding {
    const char *extension, *format;
};
inline constexpr VideoEnding kVideoEndings[] = {
    {".mp4", "mov"}, {".mov", "mov"},   {".m4v", "mov"},    {".3gp", "mov"},     {".mkv", "matroska"}, {".webm", "matroska"},
    {".avi", "avi"}, {".ts", "mpegts"}, {".mts", "mpegts"}, {".m2ts", "mpegts"}, {".mpg", "mpeg"},     {".mpeg", "mpeg"},
};

/** The text with its ASCII letters in lower case. */
std::string lowerCase(std::string text);

/** Extension of a file's name in lower case, with its dot. */
std::string lowerExtension(const std::filesystem::path& file);

/** Regular files of a folder whose extension is one of `extensions` (lower case, with dots; compared without case), in natural order of
 *  their names: "2.jpg" before "10.jpg". Hidden files are left out. Stops at 100,000 files. */
std::vector<std::filesystem::path> filesWith(const std::filesystem::path& folder, std::initializer_list<const char*> extensions);

/** Whether `a` comes before `b` when runs of digits count as numbers. */
bool naturallyBefore(std::string_view a, std::string_view b);

std::vector<std::filesystem::path> picturesIn(const std::filesystem::path& folder);
std::vector<std::filesystem::path> videosIn(const std::filesystem::path& folder);
/** Photos that are not read, and pictures of other formats that are not. Those that lie there as JPEG or PNG too are left out. */
std::vector<std::filesystem::path> heicIn(const std::filesystem::path& folder);
std::vector<std::filesystem::path> otherPicturesIn(const std::filesystem::path& folder);
/** Visible folders of a folder, in natural order of their names, at most 1000. */
std::vector<std::filesystem::path> foldersIn(const std::filesystem::path& folder);

bool isPicture(const std::filesystem::path& file);
bool isVideo(const std::filesystem::path& file);
bool isHeic(const std::filesystem::path& file);

/** Names of files without folders, at most 8. */
std::string namesOf(const std::vector<std::filesystem::path>& files);

/** How to make JPEG files of the HEIC photos of a folder: a sentence that ends in a shell command. */
std::string howToConvertHeic(const std::filesystem::path& folder);

/** Sentences about what lies beside the photos of a folder and is not read. */
std::vector<std::string> leftBesidePhotos(const std::filesystem::path& folder);

}  // namespace dpl
