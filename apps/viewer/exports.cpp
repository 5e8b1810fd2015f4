// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/exports.h"

#include <algorithm>

namespace dpl {

namespace fs = std::filesystem;

const ExportKindWords& wordsOf(ExportKind kind) {
    return kExportKinds[size_t(kind)];
}

bool isByProgram(ExportKind kind) {
    return kind >= ExportKind::SplatsGlb;
}

std::string whyNotExport(ExportKind kind, const ViewedSubject* chosen, const ViewedSubject* player) {
    if (!chosen) return kind == ExportKind::Picture ? "" : "Open an avatar first.";
    if (kind == ExportKind::Clip && !player) return "Choose a clip of an avatar first.";
    if (kind == ExportKind::Mesh && !chosen->isAvatar()) return "General splats have no mesh; select an avatar.";
    if (isByProgram(kind) && chosen->path.empty()) return "The selected one has no file of its own.";
    return {};
}

fs::path exportFile(ExportKind kind, const ViewedSubject* chosen, const fs::path& folder) {
    const std::string name = chosen ? fs::path(chosen->file).stem().string() : "doppel";
    return nextFreeName((folder / name).string(), wordsOf(kind).ending);
}

std::vector<std::string> exportArguments(const fs::path& program, ExportKind kind, const ViewedSubject& subject, const Playback& clock,
                                         const fs::path& out) {
    std::vector<std::string> words = {program.string(), "export", subject.path.string(), "-o", out.string()};
    const bool mesh = kind == ExportKind::Mesh;
    if (mesh) words.emplace_back("--mesh");
    if (!subject.clip) return words;
    const ViewedSubject::Clip& clip = subject.clips[*subject.clip];
    if (mesh && clip.from.empty()) return words;  // the mesh keeps all clips of its own file
    words.push_back("--clip=" + (clip.from.empty() ? clip.name : clip.from.string()));
    if (!mesh) words.push_back(formatText("--time={}", timeInClip(clock.timeS, clip.durationS, clock.loop)));
    return words;
}

Result<std::unique_ptr<FileExport>> FileExport::begin(const fs::path& file,
                                                      const std::function<std::vector<std::string>(const fs::path&)>& arguments) {
    std::error_code error;
    if (fs::exists(file, error)) return fail(Code::InvalidArgument, "{} is there already; choose another folder", file.string());
    std::unique_ptr<FileExport> made(new FileExport);
    made->file_ = file;
    DPL_TRY(made->folder_, RecordingFolder::beside(file));
    made->job_ = std::make_unique<ProgramJob>(arguments(made->folder_->path() / file.filename()));
    return made;
}

std::optional<Status> FileExport::finished() {
    std::optional<Status> ended = job_->ended();
    if (!ended || !*ended) return ended;
    std::error_code error;
    fs::rename(folder_->path() / file_.filename(), file_, error);
    if (error) return fail(Code::Io, "{} cannot be created: {}", file_.string(), error.message());
    return ended;
}

}  // namespace dpl
