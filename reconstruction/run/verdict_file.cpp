// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/verdict_file.h"

#include "sdk/core/files.h"

namespace dpl {
namespace {

using nlohmann::ordered_json;

Status writeTo(const std::filesystem::path& out, const ordered_json& verdict) {
    return writeFileAtomically(out / "verdict.json", verdict.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

bool isAboutTheScan(Code code) {
    return code == Code::InvalidArgument || code == Code::NotFound || code == Code::CorruptData || code == Code::Version ||
           code == Code::Unsupported;
}

}  // namespace

Error refuse(const std::filesystem::path& out, const Refusal& refusal, Error reason) {
    if (!isAboutTheScan(reason.code)) return reason;
    const ordered_json verdict = {{"scan", nullptr},
                                  {"avatar", nullptr},
                                  {"refused", {{"stage", refusal.stage}, {"reason", reason.message}}},
                                  {"film_again", refusal.filmAgain},
                                  {"places", ordered_json::array()},
                                  {"scan_check", refusal.scanCheck}};
    if (const Status written = writeTo(out, verdict); !written) reason.message += "\n" + written.error().message;
    if (reason.code == Code::InvalidArgument) reason.code = Code::Unsupported;  // not the arguments are wrong, but what was filmed
    return reason;
}

Status writeVerdict(const std::filesystem::path& out, const Verdict& verdict) {
    ordered_json file = {{"scan", verdict.scanHash},
                         {"avatar", verdict.avatarHash.empty() ? ordered_json() : ordered_json(verdict.avatarHash)},
                         {"refused", nullptr}};
    file.update(verdict.figures);
    file["scan_check"] = ordered_json::parse(verdict.scanCheck, nullptr, /*allow_exceptions=*/false);
    return writeTo(out, file);
}

}  // namespace dpl
