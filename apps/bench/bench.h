// SPDX-License-Identifier: Apache-2.0
// Runs a bench from its options to its tables. `doppel bench` uses it; tools/bench/frames adds contestants and tables.
#pragma once

#include <CLI/CLI.hpp>

#include "apps/bench/contestants.h"

namespace dpl {

/** Extra output of a bench program, after the tables that every bench prints. */
class BenchExtras {
public:
    virtual ~BenchExtras() = default;
    /** Called once for each case, after it has been timed and its pictures measured. */
    virtual void add(const BenchCase&, const std::vector<Contestant>&, const BenchSubject&, const ReferenceFile&) {}
    virtual std::string text() const { return {}; }
    /** JSON lines, as JsonRow writes them. */
    virtual std::string json() const { return {}; }
};

/** Adds the options that every bench has to `command`. `renderers`: the allowed values of --renderers; options.renderers holds its default.
 *  `options` must outlive the parsing. */
void addBenchOptions(CLI::App& command, BenchOptions& options, const std::vector<std::string>& renderers);

/** Times all cases, measures their pictures, prints the tables and writes the files that the options name. Also returns an error when warm
 *  frames allocated or waited; the tables are printed first. */
Status runBench(const BenchOptions& options, const ContestantMaker& make, BenchExtras& extras);

}  // namespace dpl
