// SPDX-License-Identifier: Apache-2.0
// Where tools/models installs networks.
#pragma once

#include <filesystem>

namespace dpl {

/** $XDG_DATA_HOME/doppel/models, or ~/.local/share/doppel/models where that variable is empty or relative, as the XDG base directory
 *  specification says. Empty without $HOME. */
std::filesystem::path userModelsFolder();

/** userModelsFolder() if it holds a pose network, else empty. */
std::filesystem::path installedModels();

}  // namespace dpl
