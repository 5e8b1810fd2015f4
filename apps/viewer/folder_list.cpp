// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/folder_list.h"

#include <algorithm>
#include <cctype>
#include <tuple>

#include "apps/viewer/new_run.h"
#include "apps/viewer/run_reader.h"

namespace dpl {

namespace fs = std::filesystem;

bool isOpenable(const std::string& name) {
    std::string ending = fs::path(name).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return ending == ".glb" || ending == ".ply" || ending == ".spz" || ending == ".bvh" || ending == ".gltf" || isVideoName(name);
}

Result<FolderList> listFolder(const fs::path& folder) {
    FolderList list;
    std::error_code error;
    list.folder = fs::absolute(folder, error).lexically_normal();
    if (!list.folder.has_filename() && list.folder.has_relative_path()) list.folder = list.folder.parent_path();
    fs::directory_iterator at(list.folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && at != fs::directory_iterator(); at.increment(error)) {
        const std::string name = at->path().filename().string();
        std::error_code gone;
        const bool isFolder = at->is_directory(gone);
        if (name.starts_with('.') || (!isFolder && !(isOpenable(name) && at->is_regular_file(gone)))) continue;
        if (list.entries.size() == FolderList::kMostEntries) {
            list.cut = true;
            break;
        }
        using Kind = FolderEntry::Kind;
        const Kind kind = !isFolder                                             ? Kind::File
                          : isRunFolder(at->path())                             ? Kind::Run
                          : fs::is_regular_file(at->path() / "scan.json", gone) ? Kind::Scan
                                                                                : Kind::Folder;
        list.entries.push_back({name, kind});
    }
    if (error) return fail(Code::Io, "{} cannot be listed: {}", list.folder.string(), error.message());
    std::sort(list.entries.begin(), list.entries.end(), [](const FolderEntry& a, const FolderEntry& b) {
        const bool fileA = a.kind == FolderEntry::Kind::File, fileB = b.kind == FolderEntry::Kind::File;
        return std::tie(fileA, a.name) < std::tie(fileB, b.name);
    });
    return list;
}

}  // namespace dpl
