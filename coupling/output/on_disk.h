// Files that outlive a loss of power. Each returns an empty string where it is done, else why not. Local.
#pragma once

#include <string>

namespace twogrid {

/// What has been written into the file, or the names in the folder, is on the disk.
std::string sync_to_disk(const std::string& path);
/// The file or folder `from` is on the disk, and then takes the place of `to`.
std::string put_in_place(const std::string& from, const std::string& to);

}  // namespace twogrid
