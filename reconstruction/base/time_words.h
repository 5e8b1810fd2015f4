// SPDX-License-Identifier: Apache-2.0
// Times as people say them. The command line and the viewer use the same words.
#pragma once

#include <string>

namespace dpl {

/** "less than a minute", "25 minutes", "1 h 40 min", "3 days". */
std::string wordsOfTime(double seconds);
/** "about 12 minutes left". */
std::string wordsOfTimeLeft(double seconds);
/** The same of a whole run: "about 12 minutes left in all". */
std::string wordsOfRunLeft(double seconds);

}  // namespace dpl
