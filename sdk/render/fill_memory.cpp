// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/fill_memory.h"

#include <filesystem>
#include <map>
#include <mutex>

#include "sdk/core/files.h"
#include "sdk/core/log.h"

namespace dpl {
namespace {

constexpr uint64_t kMaxFileBytes = 64;

const char* fileText(Fill fill) {
    return fill == Fill::Tiles ? "tiles\n" : "quads\n";
}

std::optional<Fill> readFill(const std::filesystem::path& path) {
    const auto bytes = path.empty() ? Result<std::vector<uint8_t>>(fail(Code::NotFound, "no folder")) : readFile(path, kMaxFileBytes);
    if (!bytes) return std::nullopt;
    const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
    for (const Fill fill : {Fill::Quads, Fill::Tiles})
        if (text == fileText(fill)) return fill;
    return std::nullopt;
}

Result<Fill> runSelfTest(Renderer& renderer, TrustedPicture trusted) {
    const FillScene scene = fillTestScene();
    DPL_TRY(const std::vector<uint8_t> want, trusted(scene));
    std::string reason;
    DPL_TRY(const Fill fill, chooseFill(renderer, scene, want, reason));
    // A fill that draws wrong pixels is a fault of the driver or of Doppel. It is worth a warning, even if the other fill works.
    log(reason.find("wrong") == std::string::npos ? LogLevel::Info : LogLevel::Warning, "{}: self-test, {}", renderer.name(), reason);
    return fill;
}

}  // namespace

Status setBestFill(Renderer& renderer, const std::string& cacheFolder, TrustedPicture trusted) {
    static std::mutex mutex;
    static auto* known = new std::map<std::string, Result<Fill>>();  // never freed: threads may still call while the process ends
    std::lock_guard lock(mutex);
    const std::string identity = renderer.identity();
    std::filesystem::path path;
    if (!cacheFolder.empty())
        path = std::filesystem::path(reinterpret_cast<const char8_t*>(cacheFolder.c_str())) / ("doppel-fill-" + identity + ".txt");
    const std::optional<Fill> kept = readFill(path);
    auto found = known->find(identity);
    if (found == known->end()) {
        const Result<Fill> tested = kept ? Result<Fill>(*kept) : runSelfTest(renderer, trusted);
        if (!tested && (tested.error().code != Code::Device || renderer.lost())) return tested.error();
        found = known->emplace(identity, tested).first;
    }
    if (!found->second) return found->second.error();
    const Fill fill = *found->second;
    if (!path.empty() && kept != fill)
        if (const Status written = writeFileAtomically(path, fileText(fill)); !written)
            log(LogLevel::Warning, "the result of the self-test cannot be saved: {}", written.error().message);
    renderer.setFill(fill);
    return {};
}

}  // namespace dpl
