// SPDX-License-Identifier: Apache-2.0
// A stage runs once: its folder appears complete, with a manifest of what it was made from, or not at all.
//
//   OUT/stages/body-fit/            appears by rename when the stage has ended
//       manifest.json               key (hash of name, version and inputs), inputs, seconds, peak memory
//       ...                         what the stage wrote
//   OUT/stages/body-fit.work/       while it runs; kept after a kill so that checkpoints survive, removed when the key has changed
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
std::string hashText(std::string_view text);
Result<std::string> hashFile(const std::filesystem::path& path);

struct StageRecord {
    std::string name;
    double seconds = 0;
    uint64_t peakBytes = 0;
    bool reused = false;
};

/** A finished stage. The key names everything that its files were made from: later stages put it into their inputs. */
struct StageOutput {
    std::filesystem::path folder;
    std::string key;
};

/** What a running stage is given. */
struct StageContext {
    std::filesystem::path folder;  // write here; the same folder holds checkpoints of an interrupted run with the same key
    Progress& progress;
};

/** Runs stages under OUT/stages and records what each cost. One thread. */
class StageChain {
public:
    StageChain(std::filesystem::path outFolder, Progress& progress);

    /** Runs `work` unless a finished folder with the same key exists. `inputs` holds every value that the result depends on: numbers of the
     *  settings, hashes of input files, keys of earlier stages. The version changes when the code makes other files from the same inputs.
     */
    Result<StageOutput> run(const std::string& name, uint32_t version, const nlohmann::json& inputs,
                            const std::function<Status(StageContext&)>& work);

    /** In the order in which the stages ran. */
    const std::vector<StageRecord>& records() const { return records_; }

    /** Names of folders that an earlier layout numbered ("03-body-fit"). Nothing reads or removes them. */
    std::vector<std::string> numberedFolders() const;

private:
    std::filesystem::path stagesFolder_;
    Progress& progress_;
    std::vector<StageRecord> records_;
};

}  // namespace dpl
