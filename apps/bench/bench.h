// SPDX-License-Identifier: Apache-2.0
// A bench from its options to its tables: `doppel bench`, and tools/bench/frames with more contestants and more tables.
#pragma once

#include <CLI/CLI.hpp>

#include "apps/bench/contestants.h"

namespace dpl {

/** What a program prints besides the tables that every bench has. */
class BenchExtras {
public:
    virtual ~BenchExtras() = default;
    /** Called once a case, when it is timed and measured. */
    virtual void add(const BenchCase&, const std::vector<Contestant>&, const BenchSubject&, const ReferenceFile&) {}
    virtual std::string text() const { return {}; }
    /** JSON lines (JsonRow). */
    virtual std::string json() const { return {}; }
};

/** Adds the options of every bench to a command. `renderers`: the values that --renderers takes. options.renderers holds its default. */
void addBenchOptions(CLI::App& command, BenchOptions& options, const std::vector<std::string>& renderers);

/** Times all cases, measures their pictures, prints the tables and writes the files that the options name. An error also when warm frames
 *  allocated or waited; the tables are printed all the same. */
Status runBench(const BenchOptions& options, const ContestantMaker& make, BenchExtras& extras);

}  // namespace dpl
