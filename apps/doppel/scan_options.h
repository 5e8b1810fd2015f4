// SPDX-License-Identifier: Apache-2.0
// The options by which `doppel check` and `doppel reconstruct` name a scan.
#pragma once

#include "apps/doppel/commands.h"
#include "apps/doppel/video_options.h"
#include "apps/shared/checks.h"
#include "reconstruction/input/capture/person_height.h"
#include "reconstruction/run/reconstruct.h"

namespace dpl {

/** `options` must outlive the parsing. outHelp: what the output folder is for. */
inline void addScanOptions(CLI::App& command, ReconstructOptions& options, const std::string& outHelp) {
    CLI::Option* scan = command.add_option(
        "scan", options.scan, "Scan folder (docs/formats/scan.md), nerfstudio or COLMAP folder, or anything that `doppel import` reads");
    addVideoOptions(command, options.videos, scan);
    command.add_option("-o,--out", options.out, outHelp)->required();
    command.add_flag("--replace", options.replace, "Give an output folder that holds the run of another scan to this one");
    command.add_option("--body", options.body, "Body to start from (.glb made by `doppel body import`); default: the built-in body")
        ->check(CLI::ExistingFile);
    command.add_option("--models", options.models,
                       "Folder of ONNX networks that find keypoints, masks and clothing if the scan has none; default: where tools/models "
                       "installs them");
    command
        .add_option(
            "--person", options.persons,
            "FRAME:X,Y: the person is at this pixel of this picture, where several are in view; once for the still and once for the "
            "moving pictures")
        ->allow_extra_args(false);
    command
        .add_option("--height", options.heightM,
                    "Height of the subject in metres, without shoes; sets the scale of a scan whose cameras are not in metres")
        ->check(inRange(kShortestPersonM, kTallestPersonM));
    command.add_option("--threads", options.threadCount, "CPU threads; 0: one for each core. The result is the same for any number")
        ->check(inRange(0, 256))
        ->capture_default_str();
}

/** --engine: what trains. */
inline void addEngineOption(CLI::App& command, ReconstructOptions& options) {
    const auto choose = [&options](const std::string& text) {
        auto device = parseTrainingDevice(text);
        if (!device) throw CLI::ValidationError("--engine", device.error().message);
        options.device = std::move(*device);
    };
    command
        .add_option_function<std::string>(
            "--engine", choose,
            "What trains: cpu; gpu, by Vulkan or Metal (gpu:NAME with a part of its name, where there are several); "
            "auto, a GPU where there is one, and the CPU if it fails. New: it has run on emulated GPUs only")
        ->type_name("cpu|gpu|gpu:NAME|auto")
        ->default_str("cpu");
}

}  // namespace dpl
