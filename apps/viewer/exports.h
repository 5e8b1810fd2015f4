// SPDX-License-Identifier: Apache-2.0
// What can be saved from the viewer, under which name, and the export of a file by the program `doppel`.
#pragma once

#include <array>
#include <memory>

#include "apps/viewer/program_job.h"
#include "apps/viewer/recorder.h"
#include "apps/viewer/subject.h"

namespace dpl {

enum class ExportKind : uint8_t { Picture, CutOut, Turntable, Clip, SplatsGlb, SplatsSpz, SplatsPly, Mesh };

struct ExportKindWords {
    ExportKind kind;
    const char* name;
    const char* help;
    const char* ending;  // of the file; with its dot
};
/** All of them, in the order in which they are offered. */
constexpr std::array<ExportKindWords, 8> kExportKinds{{
    {ExportKind::Picture, "Picture", "What the window shows, without panels (.png)", ".png"},
    {ExportKind::CutOut, "Picture without background", "The avatars alone, on a transparent ground (.png)", ".png"},
    {ExportKind::Turntable, "Video: once around", "What the window shows, while the camera turns once around (.mp4)", ".mp4"},
    {ExportKind::Clip, "Video: the clip", "What the window shows, while a clip plays once: the selected avatar's, if it has one (.mp4)",
     ".mp4"},
    {ExportKind::SplatsGlb, "Splats (.glb)", "The selected one in its pose, for splat viewers: KHR_gaussian_splatting", ".glb"},
    {ExportKind::SplatsSpz, "Splats (.spz)", "The selected one in its pose, for splat viewers: the smallest file", ".spz"},
    {ExportKind::SplatsPly, "Splats (.ply)", "The selected one in its pose, for splat viewers and editors: the layout of INRIA", ".ply"},
    {ExportKind::Mesh, "Mesh (.glb)", "The selected avatar with skeleton, texture and clips, for any glTF viewer, editor or engine",
     ".glb"},
}};
const ExportKindWords& wordsOf(ExportKind kind);

/** Whether `doppel export` writes it. */
bool isByProgram(ExportKind kind);
/** Why it cannot be exported from these now, with what would help; "": it can. chosen: the selected subject; player: whose clip plays.
 *  Either may be NULL. */
std::string whyNotExport(ExportKind kind, const ViewedSubject* chosen, const ViewedSubject* player);

/** The file to be written: folder/NAME-1.ply or the first such name that is free. The name is that of the selected subject, for pictures
 *  and videos too. */
std::filesystem::path exportFile(ExportKind kind, const ViewedSubject* chosen, const std::filesystem::path& folder);

/** The command line that exports a subject as the clock poses it. Joints bent by hand are not in it. `kind` is by the program. */
std::vector<std::string> exportArguments(const std::filesystem::path& program, ExportKind kind, const ViewedSubject& subject,
                                         const Playback& clock, const std::filesystem::path& out);

/** A file that a program is writing. It has its name only when it is complete: until then it lies in a hidden folder beside, which goes
 *  with this object. */
class FileExport {
public:
    /** arguments: the command line that writes the file it is given. InvalidArgument: `file` is there. Io: its folder cannot be made. */
    static Result<std::unique_ptr<FileExport>> begin(
        const std::filesystem::path& file, const std::function<std::vector<std::string>(const std::filesystem::path&)>& arguments);

    const std::filesystem::path& file() const { return file_; }
    const ProgramJob& job() const { return *job_; }
    void cancel() { job_->cancel(); }
    /** Gives the file its name once the program has ended. Nothing: it has not. */
    std::optional<Status> finished();

private:
    FileExport() = default;
    std::filesystem::path file_;
    std::unique_ptr<RecordingFolder> folder_;
    std::unique_ptr<ProgramJob> job_;  // ends before its folder goes
};

}  // namespace dpl
