// While a run is only planned no file of the user's changes: what LIGGGHTS, VTK and the standard library would write goes
// to a folder of the process for the time being, where it is found again by who reads it under its own name, and which
// vanishes with the process. The program has fopen() and its like in place of the C library's (as it has MPI_Abort), so
// that it holds for whatever a style of LIGGGHTS writes; switched off they pass on.
#pragma once

#include <string>
#include <vector>

namespace twogrid {

/// From here on. Local.
void keep_files_still();
bool files_are_still();

/// Where a file of that name is written instead; the name itself while files aren't still.
std::string still_path(const std::string& path);
/// Where it is to be read: as it was written since, else the file of that name.
std::string still_path_to_read(const std::string& path);

/// Whether such a file can be made, or written over.
bool can_be_written(const std::string& path);
/// As if it had not been written. Local.
void forget_still_file(const std::string& path);
/// Its size by now, as it is written instead (bytes).
double still_bytes(const std::string& path);

/// As if it had been made.
void take_as_folder(const std::string& path);
/// A command that may have made folders and files is left out: what is written to a folder that isn't there is no
/// mistake from now on.
void expect_missing_folders();

struct StillFile {
  std::string path;  ///< as the user knows it
  double bytes = 0;
};
/// What would have been written so far, by this process.
std::vector<StillFile> still_files();

/// The last file that could not be opened to be written, in a plan or in a run; no path: there was none.
struct UnopenedFile {
  std::string path;  ///< as it was given
  int error = 0;     ///< errno
};
const UnopenedFile& unopened_file();

/// The folder goes. At the end of a process by itself, but for MPI_Abort and _Exit. Local.
void forget_still_files();

}  // namespace twogrid
