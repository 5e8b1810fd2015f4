// SPDX-License-Identifier: Apache-2.0
// What the viewer tells its user: errors stay until they are clicked away, other lines for a few seconds.
#pragma once

#include <string>
#include <vector>

namespace dpl {

class Messages {
public:
    struct Line {
        std::string text;
        bool error = false;
        double untilS = 0;  // of the viewer's clock; not read for errors
    };
    static constexpr size_t kMost = 4;  // older lines give way
    static constexpr double kSecondsShown = 6;

    /** The same error twice is shown once. */
    void error(const std::string& text);
    void info(const std::string& text, double nowS);
    void dismiss(size_t line);
    /** Forgets what was shown long enough. */
    void tick(double nowS);

    const std::vector<Line>& lines() const { return lines_; }

private:
    void add(Line line);
    std::vector<Line> lines_;
};

}  // namespace dpl
