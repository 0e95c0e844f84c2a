// A folder of checkpoints, each a folder of its own, NNNNNN_step_S, with the particles' restart file, what it
// lacks of insertion (insertion_state.h), a file for the fluid of every fix twogrid, and record.txt: where the script stands (ResumePoint), and size and checksum of all files.
// It is filled under another name, synced, and renamed: what has such a name is whole, unless the disk has lost
// something since. Used by one rank.
#pragma once

#include <string>
#include <vector>

#include "liggghts_fixes/run/resume_point.h"

namespace twogrid {

/// Where checkpoints of a script are that names no folder.
std::string default_folder(const std::string& script);

class CheckpointFolder {
 public:
  explicit CheckpointFolder(std::string path) : path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  /// Names of checkpoints, the newest first, whole or not.
  std::vector<std::string> names() const;
  /// Makes the place to fill. bytes: what it will need; met by a full disk before anything is written. Throws
  /// std::runtime_error with a sentence.
  std::string begin(double bytes) const;
  /// Adds a file of this text to what is being filled. Throws std::runtime_error with a sentence.
  void add(const std::string& name, const std::string& text) const;
  /// Of all files of a checkpoint, bytes.
  static double size(const std::string& path);
  static std::string content(const std::string& file);
  /// What is filled becomes a checkpoint, of a number above `above`; all but the last `keep` are removed. Returns its path.
  /// Throws std::runtime_error with a sentence; then those before are as they were.
  std::string complete(const ResumePoint& point, int keep, long above) const;
  /// Takes away what was begun.
  void give_up() const;

 private:
  std::string part() const { return path_ + "/being_written"; }
  std::string path_;
};

/// A checkpoint that was found.
struct Checkpoint {
  std::string path;                      ///< of its folder; empty: none
  std::string record;                    ///< its ResumePoint as text
  std::vector<std::string> passed_over;  ///< sentences: those newer than it, and what is wrong with them
};

/// The newest whole one of a folder, or `path` itself if it is one. Throws nothing.
Checkpoint find_checkpoint(const std::string& path);
/// The same, of all folders that a script's checkpoints have gone to.
Checkpoint find_checkpoint_of(const std::string& script);
/// The highest number of a checkpoint there; 0: none.
long last_number(const std::string& script);
/// Leaves word where checkpoints of the script go, other than its default folder. Silent if it can't.
void note_folder(const std::string& script, const std::string& folder);

constexpr char kParticlesFile[] = "particles.restart", kInsertionFile[] = "insertion.txt";

}  // namespace twogrid
