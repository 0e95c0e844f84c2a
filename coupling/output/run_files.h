// The output files of a run on the disk: which are there, what they hold, in which one the run goes on. A run that goes on
// from a checkpoint may have several, one a leg: NAME.h5, NAME.2.h5, NAME.3.h5. Used by one rank.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "coupling/output/xdmf.h"
#include "coupling/settings.h"

namespace twogrid {

/// bed.h5 -> bed
std::string stem(const std::string& file);
/// bed.h5, 2 -> bed.2.h5; 1 -> bed.h5
std::string name_of_leg(const std::string& file, int leg);
std::string name_in_directory(const std::string& file);

/// What stands in a file.
struct FoundFile {
  enum class Kind { kNone, kOther, kDamaged, kOutput };
  Kind kind = Kind::kNone;
  std::string what;  ///< in words, for a sentence
  std::string run;   ///< id of the run
  std::array<int, 3> fine{}, ratio{};
  int legs = 0;      ///< the highest number of a leg in it; 0: the run began in it, and never went on
  double from = -1;  ///< least step of the checkpoints that it was gone on from
  bool means = false;
  std::vector<XdmfFrame> frames;
};
FoundFile look_at(const std::string& path);

/// Where a run writes.
struct WhereToWrite {
  std::string file;
  bool create = true;                  ///< else the run goes on in the file that is there
  int leg = 0;                         ///< number of this leg; 0: the run begins
  bool means = false;                  ///< it holds some
  int frames = 0;                      ///< that it holds and that stay
  std::vector<std::string> drop;       ///< frames of it that don't
  std::vector<XdmfFrame> shown;        ///< frames of all files, in order of time
  std::vector<std::string> sentences;  ///< what the user should know
};

/// A run that begins. Throws std::runtime_error with a sentence when it would destroy something unasked.
WhereToWrite begin_files(const OutputSettings& settings);
/// The run `id` goes on after step `last`. The same.
WhereToWrite go_on_with_files(const OutputSettings& settings, const std::string& id, const Int3& fine,
                              const Int3& ratio, double last);

}  // namespace twogrid
