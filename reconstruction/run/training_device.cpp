// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/training_device.h"

#include "reconstruction/training/gpu/open_engine.h"
#include "sdk/core/files.h"

namespace dpl {

Result<TrainingDevice> parseTrainingDevice(const std::string& text) {
    if (text == "cpu") return TrainingDevice{TrainingDevice::Kind::Cpu, {}};
    if (text == "auto") return TrainingDevice{TrainingDevice::Kind::Auto, {}};
    if (text == "gpu") return TrainingDevice{TrainingDevice::Kind::Gpu, {}};
    if (text.size() > 4 && text.starts_with("gpu:")) return TrainingDevice{TrainingDevice::Kind::Gpu, text.substr(4)};
    return fail(Code::InvalidArgument, "'{}' is no engine; cpu, gpu, gpu:NAME with a part of the GPU's name, and auto are", text);
}

Result<std::unique_ptr<TrainingEngine>> engineOf(const TrainingDevice& device, Progress& progress) {
    std::unique_ptr<TrainingEngine> none;
    if (device.kind == TrainingDevice::Kind::Cpu) return none;
    const bool mayFail = device.kind == TrainingDevice::Kind::Auto;
    auto engine = openTrainingEngine({device.name, !mayFail});
    if (!engine && !mayFail) return fail(engine.error().code, "--engine gpu: {}", engine.error().message);
    if (engine)
        progress.note(formatText("training on {}", (*engine)->name()));
    else
        progress.note(formatText("training on the CPU: {}", engine.error().message));
    return engine ? std::move(*engine) : std::move(none);
}

Status trainOnDevice(const TrainingDevice& device, TrainingEngine* engine, const TrainingFiles& files, Progress& progress,
                     const std::function<Status(TrainingEngine*)>& train) {
    const auto forgetUnlessBegun = [&] {
        std::error_code ignored;
        const bool began = std::filesystem::exists(files.checkpoint, ignored);
        if (!began) std::filesystem::remove(files.engine, ignored);
        return began;
    };
    forgetUnlessBegun();  // of a run that was killed before its first checkpoint
    if (!engine) return train(nullptr);
    DPL_RETURN_IF_ERROR(writeFileAtomically(files.engine, engine->name()));
    const Status trained = train(engine);
    const bool deviceFailed = !trained && (trained.error().code == Code::Device || trained.error().code == Code::OutOfMemory);
    if (!deviceFailed || device.kind != TrainingDevice::Kind::Auto) return trained;
    const bool began = forgetUnlessBegun();
    progress.note(formatText("{}: {}; training {} on the CPU", engine->name(), trained.error().message,
                             began ? "goes on from its last checkpoint" : "begins anew"));
    return train(nullptr);
}

}  // namespace dpl
