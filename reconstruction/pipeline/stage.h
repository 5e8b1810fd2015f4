// SPDX-License-Identifier: Apache-2.0
// A stage runs once: its folder appears complete, with a manifest of what it was made from, or not at all.
//
//   OUT/stages/03-body-fit/            appears by rename when the stage has ended
//       manifest.json                  key (hash of name, version, settings, inputs), seconds, peak memory, outputs
//       ...                            what the stage wrote
//   OUT/stages/03-body-fit.work/       while it runs; kept after a kill so that checkpoints survive, dropped when the key changed
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "reconstruction/pipeline/progress.h"
#include "sdk/core/result.h"

namespace dpl {

/** 128-bit content hash as 32 hex digits. */
std::string hashBytes(std::span<const uint8_t> bytes);
Result<std::string> hashFile(const std::filesystem::path& path);

struct StageRecord {
    std::string name;
    std::string key;
    double seconds = 0;
    uint64_t peakBytes = 0;
    bool reused = false;
};

/** What a running stage is given. */
struct StageContext {
    std::filesystem::path folder;  // write here; the same folder holds checkpoints of an interrupted run with the same key
    Progress& progress;
};

/** Runs stages in order under OUT/stages and remembers what each cost. */
class StageChain {
public:
    StageChain(std::filesystem::path outFolder, Progress& progress);

    /** Runs `work` unless a finished folder with the same key is there. `inputs` is everything the result depends on:
     *  settings, hashes of input files, keys of earlier stages. Returns the finished folder. */
    Result<std::filesystem::path> run(const std::string& name, uint32_t version, const nlohmann::json& inputs,
                                      const std::function<Status(StageContext&)>& work);

    /** Key of the last finished stage of that name; empty when it has not run. */
    std::string keyOf(const std::string& name) const;
    const std::vector<StageRecord>& records() const { return records_; }

private:
    std::filesystem::path stagesFolder_;
    Progress& progress_;
    std::vector<StageRecord> records_;
};

}  // namespace dpl
