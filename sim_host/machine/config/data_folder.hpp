// SPDX-License-Identifier: Apache-2.0
// Where the shipped plants, scenarios, studies and limits are: in share/trackservo/sim_host beside the folder of the
// program, so that both can be moved together. A build has a link there, to the sources.
#ifndef TRACKSERVO_SIM_CONFIG_DATA_FOLDER_HPP
#define TRACKSERVO_SIM_CONFIG_DATA_FOLDER_HPP

#include <filesystem>

namespace trackservo::sim {

// Returns the folder, without links in its name. Nothing says that it exists: reading a file in it fails then.
std::filesystem::path data_folder();

}  // namespace trackservo::sim

#endif
