// SPDX-License-Identifier: Apache-2.0
// From a scan folder to an avatar.
//
//   (observe, with networks →) (cameras, where unknown →) (closeups, with networks →) ingest → body-fit → surface → body-map → garments
//   → register → co-optimise → evidence → package → pose-fit → report
//
// The stages are a graph (graph.h), and each function here asks it for other artefacts.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/input/import/video_capture.h"
#include "reconstruction/run/presets.h"
#include "reconstruction/run/progress.h"
#include "reconstruction/run/stage.h"
#include "sdk/core/result.h"

namespace dpl {

struct ProfiledSteps;
struct ProfiledTraining;

/** Parts of the method that a run can leave out, to measure what they bring. */
struct WithoutParts {
    bool layers = false;           // clothes are painted on the skin
    bool largeSteps = false;       // every vertex moves by itself
    bool light = false;            // brightness does not follow the pose
    bool motion = false;           // clothes do not remember that the subject has moved
    bool gradientControl = false;  // close-ups count no more than other pictures
};

/** What computes the steps of training. The stages after it train on the CPU. */
struct TrainingDevice {
    enum class Kind : uint8_t { Cpu, Gpu, Auto };  // Auto: a GPU where there is one, but none that the CPU plays; else the CPU
    Kind kind = Kind::Cpu;
    std::string name;  // part of the GPU's name; empty: the best one
};

/** From "cpu", "gpu", "gpu:NAME" or "auto". InvalidArgument: anything else. */
Result<TrainingDevice> parseTrainingDevice(const std::string& text);

struct ReconstructOptions {
    std::filesystem::path scan;        // scan folder, nerfstudio or COLMAP folder, or a capture that is imported; empty with videos
    VideoSources videos;               // named by what they show; imported
    std::filesystem::path out;         // made if absent
    bool replace = false;              // take an output folder that holds the run of another scan
    std::filesystem::path body;        // glTF body; empty: the built-in one
    std::filesystem::path models;      // ONNX networks for keypoints, labels and masks; empty: those that tools/models installed
    std::vector<std::string> persons;  // where the person is, "FRAME:X,Y" (parsePersonPoint()); empty: chosen by size and place
    double heightM = 0;                // of the subject; sets the scale where cameras are not in metres. 0: unknown
    Preset preset = *findPreset("standard");
    double timeBudgetMinutes = 0;  // of the whole run; 0: the preset's number of steps
    uint32_t steps = 0;            // of training; 0: the preset's number; above 0: the time budget is ignored
    std::filesystem::path from;    // a checkpoint of a stopped training of the same scan, which this one continues with its own settings
    TrainingDevice device;
    uint64_t seed = 1;
    WithoutParts without;
    std::filesystem::path web;  // folder of the web module, with which the person of the report moves; empty: the picture stands still
    double checkpointS = 30;    // a kill loses about this much training at most; a checkpoint is written every 100 steps at most
    uint32_t threadCount = 0;   // 0: one a core; results do not depend on it
};

struct ReconstructResult {
    std::filesystem::path avatar;     // OUT/avatar.glb
    std::filesystem::path poses;      // OUT/poses.json
    std::filesystem::path report;     // OUT/report.html
    std::string word;                 // what it is worth (docs/reference/metrics.md)
    std::string words;                // the same in a few sentences
    std::string summary;              // figures, lines for the terminal
    std::vector<StageRecord> stages;  // in the order of their runs
};

/** Runs a reconstruction, or continues an interrupted one. Only this function writes under `out`. Errors name the stage, the file and the
 *  remedy. After Ctrl-C it returns Code::Cancelled and keeps the finished stages and the last checkpoint. */
Result<ReconstructResult> reconstruct(const ReconstructOptions& options, Progress& progress);

/** The first part alone: checks the scan, fits the body and its surface, and says what to film again. Takes seconds once cameras and
 *  keypoints are there. Writes OUT/verdict.json, and the stages, which reconstruct() with the same `out` does not repeat. Returns the
 *  advice, lines of text. Errors as of reconstruct(). */
Result<std::string> checkFilm(const ReconstructOptions& options, Progress& progress);

/** Runs the stages before the training, unless they are up to date, and measures steps of the training. The output folder keeps the
 *  stages. Errors as of reconstruct(). */
Result<ProfiledTraining> profileTraining(const ReconstructOptions& options, const ProfiledSteps& steps, Progress& progress);

}  // namespace dpl
