// SPDX-License-Identifier: Apache-2.0
// Command line of the small bench programs: positional arguments, and --json FILE at any place between them.
#pragma once

#include <cstdlib>
#include <string>
#include <vector>

#include "sdk/core/files.h"

namespace dpl {

class BenchArguments {
public:
    BenchArguments(int argc, char** argv) {
        for (int i = 1; i < argc; ++i)
            if (std::string(argv[i]) == "--json" && i + 1 < argc)
                json_ = argv[++i];
            else
                list_.push_back(argv[i]);
    }
    size_t count() const { return list_.size(); }
    std::string text(size_t i, const std::string& otherwise = "") const { return i < list_.size() ? list_[i] : otherwise; }
    double number(size_t i, double otherwise) const { return i < list_.size() ? std::atof(list_[i].c_str()) : otherwise; }
    /** Writes `lines` to the file of --json; does nothing without that option. */
    Status writeJson(const std::string& lines) const { return json_.empty() ? Status() : writeFileAtomically(json_, lines); }

private:
    std::vector<std::string> list_;
    std::string json_;
};

}  // namespace dpl
