// SPDX-License-Identifier: Apache-2.0
// A folder as tools/prove-web --build leaves it, as far as pages read it. Nothing in it runs.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "reconstruction/output/page/web_module.h"
#include "sdk/core/files.h"

namespace dpl::test {

struct ModuleFolder {
    static inline int made = 0;
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("doppel-web-" + std::to_string(::getpid()) + "-" + std::to_string(made++));
    ModuleFolder() {
        std::filesystem::create_directories(path / "page");
        std::vector<uint8_t> packed(40, 7);
        packed[0] = 93;  // the usual properties of .lzma
        write("doppel.wasm.lzma", {packed.begin(), packed.end()});
        write("live-bundle.js", "console.log('alive');\n");
        write("live.css", "#person{margin:0}\n");
    }
    ~ModuleFolder() { std::filesystem::remove_all(path); }
    void write(const std::string& name, const std::string& text) const { (void)writeFileAtomically(path / "page" / name, text); }
    void remove(const std::string& name) const { std::filesystem::remove(path / "page" / name); }
};

}  // namespace dpl::test
