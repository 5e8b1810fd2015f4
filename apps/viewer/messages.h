// SPDX-License-Identifier: Apache-2.0
// What the viewer tells its user: errors stay until they are clicked away, other lines for a few seconds. All of them, and what the library
// says, are kept for the log.
#pragma once

#include <deque>
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
    struct Kept {
        std::string text;
        bool error = false;
        double atS = 0;  // of the viewer's clock
    };
    static constexpr size_t kMost = 4;        // older lines give way
    static constexpr size_t kMostKept = 500;  // the same in the log
    static constexpr double kSecondsShown = 6;

    /** The same error twice is shown once. */
    void error(const std::string& text);
    void info(const std::string& text, double nowS);
    /** For the log alone. */
    void note(const std::string& text, bool error);
    void dismiss(size_t line);
    /** Forgets what was shown long enough. What comes from now on comes at nowS. */
    void tick(double nowS);

    const std::vector<Line>& lines() const { return lines_; }
    /** The newest last. */
    const std::deque<Kept>& log() const { return log_; }

private:
    void add(Line line);
    std::vector<Line> lines_;
    std::deque<Kept> log_;
    double nowS_ = 0;
};

}  // namespace dpl
