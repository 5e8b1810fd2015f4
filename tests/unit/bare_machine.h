// SPDX-License-Identifier: Apache-2.0
// A machine without networks and without any program in PATH, to which a test adds what it wants. Only the environment is changed.
#pragma once

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

namespace dpl {

class BareMachine {
public:
    /** Keeps its files in `folder`, which must exist. */
    explicit BareMachine(const std::filesystem::path& folder) : folder_(folder) {
        for (size_t i = 0; i < kNames.size(); ++i)
            if (const char* value = std::getenv(kNames[i])) before_[i] = value;
        std::filesystem::create_directories(folder_ / "bin");
        ::setenv("PATH", (folder_ / "bin").c_str(), 1);
        ::setenv("XDG_DATA_HOME", (folder_ / "share").c_str(), 1);
    }
    BareMachine(const BareMachine&) = delete;
    BareMachine& operator=(const BareMachine&) = delete;
    ~BareMachine() {
        for (size_t i = 0; i < kNames.size(); ++i) before_[i] ? ::setenv(kNames[i], before_[i]->c_str(), 1) : ::unsetenv(kNames[i]);
    }
    /** A program that does nothing. */
    void addProgram(const std::string& name) const {
        std::ofstream(folder_ / "bin" / name) << "#!/bin/sh\n";
        std::filesystem::permissions(folder_ / "bin" / name, std::filesystem::perms::owner_all);
    }
    /** A file in the place of the networks, which is none. */
    void addNetworks() const {
        std::filesystem::create_directories(folder_ / "share/doppel/models");
        std::ofstream(folder_ / "share/doppel/models/blazepose_full.onnx") << "no network";
    }
    /** From now on nothing says where networks are. */
    static void forgetHome() {
        ::unsetenv("HOME");
        ::unsetenv("XDG_DATA_HOME");
    }

private:
    static constexpr std::array kNames = {"PATH", "XDG_DATA_HOME", "HOME"};
    std::filesystem::path folder_;
    std::array<std::optional<std::string>, kNames.size()> before_;
};

}  // namespace dpl
